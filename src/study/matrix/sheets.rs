//! Cases of the drying shell and of the other ways to its shapes.

use super::bench::SMALL;
use super::{Bench, Case, Seen, case, slow};
use crate::base::figures::Figures;
use crate::base::flat_mesh::FlatMesh;
use crate::base::limits::Limits;
use crate::base::mesh::Mesh;
use crate::base::vector::{DVec2, DVec3, Vec2};
use crate::deform::integrators::{Method, run};
use crate::deform::shell::{self, plates};
use crate::deform::{self, DeformError, Job, Model, Settings};
use crate::study::numbers::shown;
use crate::study::problems::ovate;

pub const CASES: &[Case] = &[
    case("D07", "a white mask", "stays flat to 1e-9", |_| {
        flat_to(&FlatMesh { greys: vec![255.0; ovate(6).positions.len()], ..ovate(6) }, 1e-9)
    }),
    case("D09a", "a mask of 16 bits a channel", "converted", |bench| {
        masked(bench, "d09a", png::ColorType::Grayscale, 16, 32)
    }),
    case("D09b", "a mask in colours", "converted", |bench| masked(bench, "d09b", png::ColorType::Rgb, 8, 32)),
    case("D09c", "a mask with alpha", "converted", |bench| masked(bench, "d09c", png::ColorType::Rgba, 8, 32)),
    case("D09d", "a mask of another size than the texture", "read between its pixels", |bench| {
        masked(bench, "d09d", png::ColorType::Grayscale, 8, 5)
    }),
    case("D17", "thickness 1e-4, curl 25", "settles, or says how far it came; finite", |_| thin()),
    case("D18", "thickness 0.2", "finite, at most 12 iterations a state", |_| thick()),
    case("D19", "overcurled: curl 1000", "finite, told of its overlap; or says how far it came", |_| overcurled()),
    case("D21", "a saddle", "finite, symmetric to 1e-6", |_| saddle()),
    case("D23", "nothing holds the leaf", "centre and turn unchanged to 1e-8", |_| free()),
    case("D24", "everything is held", "the input", |_| {
        flat_to(&FlatMesh { held: (0..ovate(6).positions.len() as u32).collect(), ..ovate(6) }, 1e-12)
    }),
    case("D25a", "a triangle without area", "error that names it", |_| degenerate(0)),
    case("D25b", "an edge of 1e-12 m", "error that names it", |_| degenerate(1)),
    case("D27a", "one triangle", "a shape", |_| triangles(1)),
    case("D27b", "two triangles", "a shape", |_| triangles(2)),
    case("D27c", "no triangle", "error", |_| triangles(0)),
    slow("D28", "100,000 vertices", "settles in at most twice the iterations of 2,000", |_| large()),
    case("D29a", "a leaf of a millionth of the size", "the same shape to 1e-6", |_| scaled(1e-6)),
    case("D29b", "a leaf of a million times the size", "the same shape to 1e-6", |_| scaled(1e6)),
    case(
        "D31",
        "a matrix that is not positive definite: a flat start that wants to buckle",
        "left by a push, counted",
        |_| buckling(),
    ),
    case(
        "D32a",
        "implicit Euler, stretch 1e7 times stiffer than bending",
        "finite, energy at most 10 times the start",
        |_| stiff(Method::Implicit { steps: 8 }),
    ),
    case("D32b", "position-based dynamics, the same", "finite, energy at most 10 times the start", |_| {
        stiff(Method::PositionBased { steps: 100 })
    }),
];

fn job(dryness: f64) -> Job {
    Job { state: "brown".to_owned(), variant: 0, dryness }
}

fn shell(shell: shell::Settings) -> Settings {
    Settings { model: Model::Shell, shell, ..Settings::default() }
}

fn shapes(settings: &Settings, mesh: &FlatMesh, drynesses: &[f64]) -> Result<(Vec<Mesh>, Figures), DeformError> {
    let jobs: Vec<Job> = drynesses.iter().copied().map(job).collect();
    deform::deform(settings, mesh, &jobs, 1, &Limits::default())
}

fn figure(figures: &Figures, name: &str) -> f64 {
    figures.values.get(name).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN)
}

/// Root mean square distance of a shape's vertices from the flat blade, metres.
fn rise(shape: &Mesh, mesh: &FlatMesh) -> f64 {
    let away = |(p, q): (&crate::base::vector::Vec3, &DVec2)| {
        (DVec3::new(f64::from(p.x) - f64::from(q.x as f32), f64::from(p.y) - f64::from(q.y as f32), f64::from(p.z)))
            .norm_squared()
    };
    let sum: f64 = shape.positions.iter().zip(&mesh.positions).map(away).sum();
    (sum / mesh.positions.len().max(1) as f64).sqrt()
}

fn flat_to(mesh: &FlatMesh, bound: f64) -> Seen {
    match shapes(&Settings::default(), mesh, &[1.0]) {
        Ok((made, _)) => {
            let rise = rise(&made[0], mesh);
            (rise <= bound, format!("{} m from flat", shown(rise)))
        }
        Err(error) => (false, error.to_string()),
    }
}

fn masked(bench: &Bench, name: &str, colour: png::ColorType, bits: u8, side: u32) -> Seen {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(colour);
    encoder.set_depth(if bits == 16 { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
    let length = side as usize * side as usize * colour.samples() * usize::from(bits) / 8;
    let data: Vec<u8> = (0..length).map(|at| (at * 37 % 251) as u8).collect();
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&data));
    if let Err(error) = written {
        return (false, error.to_string());
    }
    bench.put(&format!("{name}.png"), &bytes);
    bench.render(name, &format!("{SMALL}[leaf]\nvertices = 40\nmask = \"{name}.png\"\n"), &[]).is_drawn()
}

fn thin() -> Seen {
    let settings = shell(shell::Settings { thickness: 1e-4, curl: 25.0, ..shell::Settings::default() });
    match shapes(&settings, &ovate(7), &[0.5, 1.0]) {
        Ok((made, figures)) => {
            let finite = made.iter().all(|shape| shape.check().is_ok());
            (finite, format!("settled in {} iterations", figure(&figures, "iterations")))
        }
        Err(error) => (error.to_string().contains("residual"), error.to_string()),
    }
}

fn thick() -> Seen {
    let settings = shell(shell::Settings { thickness: 0.2, curl: 10.0, ..shell::Settings::default() });
    let states = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];
    match shapes(&settings, &ovate(7), &states) {
        Ok((made, figures)) => {
            let each = figure(&figures, "iterations") / 8.0;
            (made.iter().all(|shape| shape.check().is_ok()) && each <= 12.0, format!("{each:.2} iterations a state"))
        }
        Err(error) => (false, error.to_string()),
    }
}

fn overcurled() -> Seen {
    let settings = shell(shell::Settings { curl: 1000.0, iterations: 100, ..shell::Settings::default() });
    match shapes(&settings, &ovate(6), &[1.0]) {
        Ok((made, figures)) => {
            let told = figure(&figures, "overlapping_shapes") + figure(&figures, "held_back_shapes");
            (made[0].check().is_ok() && told > 0.0, format!("settled, overlap told of {told} shape"))
        }
        Err(error) => (error.to_string().contains("does not settle"), error.to_string()),
    }
}

fn saddle() -> Seen {
    let settings = shell::Settings::default();
    let curvatures = [1.0, 3.0].map(|k| [k, 0.0, -k]);
    let Some(made) = plates::settled(&settings, (16, 0.6), &curvatures, 0.0) else {
        return (false, "does not settle".to_owned());
    };
    let rise = made.positions.iter().map(|p| p.z.abs()).fold(0.0, f64::max);
    let twin = |place: &DVec2| {
        let mirrored = DVec2::new(1.0 - place.x, place.y);
        made.places.iter().position(|q| (q - mirrored).norm() < 1e-9)
    };
    let asymmetry = |(p, place): (&DVec3, &DVec2)| match twin(place) {
        Some(twin) => {
            let q = made.positions[twin];
            (p - DVec3::new(1.0 - q.x, q.y, q.z)).norm()
        }
        None => f64::INFINITY,
    };
    let worst = made.positions.iter().zip(&made.places).map(asymmetry).fold(0.0, f64::max);
    (rise > 0.05 && worst < 1e-6, format!("rises by {rise:.3}, asymmetric by {}", shown(worst)))
}

fn free() -> Seen {
    let mesh = FlatMesh { held: Vec::new(), ..ovate(7) };
    let Ok((made, _)) = shapes(&Settings::default(), &mesh, &[0.8]) else { return (false, "refused".to_owned()) };
    let mut areas = vec![0.0; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        triangle.iter().for_each(|&v| areas[v as usize] += mesh.doubled_area(triangle));
    }
    let all: f64 = areas.iter().sum();
    let mean = |of: &dyn Fn(usize) -> f64| (0..areas.len()).map(|v| of(v) * areas[v]).sum::<f64>() / all;
    let moved = |v: usize, axis: usize| {
        f64::from(made[0].positions[v][axis]) - if axis < 2 { mesh.positions[v][axis] } else { 0.0 }
    };
    let centre = (0..3).map(|axis| mean(&|v| moved(v, axis)).abs()).fold(0.0, f64::max);
    let middle = [0, 1].map(|axis| mean(&|v| mesh.positions[v][axis]));
    // The turn that fits best in the plane: its sine is the sum of the cross products over that of the products.
    let arm = |v: usize, axis: usize| mesh.positions[v][axis] - middle[axis];
    let cross = mean(&|v| arm(v, 0) * moved(v, 1) - arm(v, 1) * moved(v, 0));
    let inertia = mean(&|v| arm(v, 0) * arm(v, 0) + arm(v, 1) * arm(v, 1));
    let turn = (cross / inertia).abs();
    (centre < 1e-8 && turn < 1e-6, format!("centre moved by {} m, turned by {} rad", shown(centre), shown(turn)))
}

fn degenerate(kind: u32) -> Seen {
    let mut mesh = ovate(4);
    let [a, b, c] = mesh.triangles[20].map(|v| v as usize);
    if kind == 0 {
        mesh.positions[c] = (mesh.positions[a] + mesh.positions[b]) * 0.5;
    } else {
        mesh.positions[b] = mesh.positions[a] + DVec2::new(1e-12, 0.0);
    }
    match shapes(&Settings::default(), &mesh, &[0.5]) {
        Ok(_) => (false, "a shape".to_owned()),
        Err(error) => (error.to_string().contains("triangle"), error.to_string()),
    }
}

fn triangles(count: usize) -> Seen {
    let corners = [[0.0, 0.0], [0.02, 0.0], [0.01, 0.017], [0.03, 0.017]];
    let positions: Vec<DVec2> = corners.iter().take(count + 2).map(|&p| DVec2::from(p)).collect();
    let mesh = FlatMesh {
        uvs: vec![Vec2::zeros(); positions.len()],
        greys: vec![0.0; positions.len()],
        positions,
        triangles: [[0, 1, 2], [2, 1, 3]][..count].to_vec(),
        ..FlatMesh::default()
    };
    match shapes(&Settings::default(), &mesh, &[1.0]) {
        Ok((made, _)) => (count > 0 && made[0].check().is_ok(), format!("{} triangles", made[0].triangles.len())),
        Err(error) => (count == 0 && error == DeformError::Empty, error.to_string()),
    }
}

fn large() -> Seen {
    let settings = shell(shell::Settings { curl: 10.0, ..shell::Settings::default() });
    let iterations =
        |rings| shapes(&settings, &ovate(rings), &[1.0]).map(|(_, figures)| figure(&figures, "iterations"));
    match (iterations(26), iterations(182)) {
        (Ok(few), Ok(many)) => (many <= 2.0 * few, format!("{many} iterations, {few} at 2,107 vertices")),
        (Err(error), _) | (_, Err(error)) => (false, error.to_string()),
    }
}

fn scaled(scale: f64) -> Seen {
    let mesh = ovate(7);
    let other = FlatMesh { positions: mesh.positions.iter().map(|p| p * scale).collect(), ..mesh.clone() };
    let made = [&mesh, &other].map(|mesh| shapes(&Settings::default(), mesh, &[0.7]));
    let [Ok((own, _)), Ok((other, _))] = made else { return (false, "refused".to_owned()) };
    let apart = |(p, q): (&crate::base::vector::Vec3, &crate::base::vector::Vec3)| {
        (p.cast::<f64>() - q.cast::<f64>() / scale).norm()
    };
    let worst = own[0].positions.iter().zip(&other[0].positions).map(apart).fold(0.0, f64::max) / 0.08;
    (worst < 1e-6, format!("{} of the extent apart at most", shown(worst)))
}

fn buckling() -> Seen {
    let settings = shell::Settings { thickness: 0.005, ..shell::Settings::default() };
    match plates::settled(&settings, (16, 1.0), &[[0.0; 3]], 0.1) {
        Some(made) => {
            let rise = made.positions.iter().map(|p| p.z.abs()).fold(0.0, f64::max);
            let observed =
                format!("{} saddles left, rises by {rise:.3}, energy {:.3} of flat", made.saddles, made.energy_share);
            (made.saddles > 0 && rise > 0.05 && made.energy_share < 0.5, observed)
        }
        None => (false, "does not settle".to_owned()),
    }
}

fn stiff(method: Method) -> Seen {
    let settings = shell::Settings { thickness: 1e-3, curl: 3.0, ..shell::Settings::default() };
    let energies = |method| run(&settings, &ovate(5), &[0.5, 1.0], 1, method);
    // No steps leave the flat blade, whose energy is that of the start.
    let (start, found) = match (energies(Method::Explicit { steps: 0 }), energies(method)) {
        (Ok(start), Ok(found)) => (start, found),
        (Err(error), _) | (_, Err(error)) => return (false, error.to_string()),
    };
    let share = found.energies.iter().zip(&start.energies).map(|(e, start)| e / start).fold(0.0, f64::max);
    let far = found.shapes.iter().flatten().map(DVec3::norm).fold(0.0, f64::max);
    (share <= 10.0 && far < 3.0, format!("energy {} of the start, no vertex beyond {far:.2} extents", shown(share)))
}
