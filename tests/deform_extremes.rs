//! Stiff, huge, empty, thin and broken leaves: a finite shape within its bounds or a refusal that says why.

mod deform_meshes;

use deform_meshes::{distance, flat, jobs, ovate, shapes};
use leafseason::base::flat_mesh::FlatMesh;
use leafseason::base::limits::{Limit, Limits};
use leafseason::base::picture::Picture;
use leafseason::base::vector::{DVec2, Vec2};
use leafseason::deform::integrators::{Method, run};
use leafseason::deform::{self, DeformError, Field, Flat, Model, Settings, shell};

fn shell(shell: shell::Settings) -> Settings {
    Settings { model: Model::Shell, shell, ..Settings::default() }
}

fn paper() -> Settings {
    Settings { model: Model::Paper, steps: 500, force: 6e-3, ..Settings::default() }
}

fn refusal(settings: &Settings, mesh: &FlatMesh) -> DeformError {
    deform::deform(settings, mesh, &jobs(&[0.5]), 1, &Limits::default()).expect_err("a refusal")
}

/// A triangle, or two that share an edge, 20 mm wide.
fn triangles(count: usize) -> FlatMesh {
    let corners = [[0.0, 0.0], [0.02, 0.0], [0.01, 0.017], [0.03, 0.017]];
    let positions: Vec<DVec2> = corners.iter().take(count + 2).map(|&p| DVec2::from(p)).collect();
    FlatMesh {
        uvs: vec![Vec2::zeros(); positions.len()],
        greys: vec![0.0; positions.len()],
        positions,
        triangles: [[0, 1, 2], [2, 1, 3]][..count].to_vec(),
        ..FlatMesh::default()
    }
}

#[test]
fn no_dryness_and_no_force_give_the_input_bits() {
    let mesh = ovate(5);
    for settings in [Settings::default(), Settings { force: 0.0, ..paper() }] {
        let (made, _) = shapes(&settings, &mesh, &[0.0]);
        assert_eq!(made[0].positions, flat(&mesh));
    }
    let (made, _) = shapes(&Settings { force: 0.0, ..paper() }, &mesh, &[1.0]);
    assert_eq!(made[0].positions, flat(&mesh));
    let (made, _) = shapes(&Settings { steps: 0, ..paper() }, &mesh, &[1.0]);
    assert_eq!(made[0].positions, flat(&mesh));
}

#[test]
fn a_white_mask_stays_flat_and_a_wholly_held_leaf_too() {
    let white = FlatMesh { greys: vec![255.0; ovate(6).positions.len()], ..ovate(6) };
    let held = FlatMesh { held: (0..ovate(6).positions.len() as u32).collect(), ..ovate(6) };
    for mesh in [white, held] {
        let (made, _) = shapes(&Settings::default(), &mesh, &[1.0]);
        assert!(distance(&made[0].positions, &flat(&mesh)) < 1e-9);
    }
}

#[test]
fn black_and_checkered_masks_are_no_trouble() {
    for grey in [|_: usize| 0.0, |v: usize| 255.0 * (v % 2) as f64, |v: usize| f64::from(v as u32 % 3)] {
        let count = ovate(6).positions.len();
        let mesh = FlatMesh { greys: (0..count).map(grey).collect(), ..ovate(6) };
        let (_, figure) = shapes(&Settings::default(), &mesh, &[0.5, 1.0]);
        // No more than what shrinks pulls at what does not.
        assert!(figure("max_strain") < Settings::default().shell.shrink);
        let (_, figure) = shapes(&paper(), &mesh, &[1.0]);
        assert!(figure("max_strain") <= 0.11);
    }
}

#[test]
fn thickness_over_three_decades() {
    for thickness in [1e-4, 1e-3, 0.02, 0.2] {
        let settings = shell(shell::Settings { thickness, curl: 10.0, ..shell::Settings::default() });
        let made = deform::deform(&settings, &ovate(7), &jobs(&[0.5, 1.0]), 1, &Limits::default());
        match made {
            Ok((shapes, figures)) => {
                assert!(shapes.iter().all(|shape| shape.check().is_ok()));
                // A blade as thin as paper is to a wall has to be led there in small steps.
                let most = if thickness == 1e-4 { 8 * 150 } else { 8 * 60 };
                assert!(figures.values["iterations"].as_u64().expect("a count") <= most, "{thickness}");
            }
            Err(error) => assert!(thickness == 1e-4 && matches!(error, DeformError::NotSettled { .. }), "{error}"),
        }
    }
}

#[test]
fn an_overcurled_leaf_is_finite_or_refused_and_told_of() {
    let settings = shell(shell::Settings { curl: 1000.0, iterations: 100, ..shell::Settings::default() });
    match deform::deform(&settings, &ovate(6), &jobs(&[1.0]), 1, &Limits::default()) {
        Ok((shapes, figures)) => {
            assert!(shapes[0].check().is_ok());
            let count = |name: &str| figures.values[name].as_u64().expect("a count");
            assert!(count("overlapping_shapes") + count("held_back_shapes") > 0);
        }
        Err(error) => assert!(error.to_string().contains("does not settle"), "{error}"),
    }
}

#[test]
fn size_does_not_matter() {
    let mesh = ovate(7);
    let (made, _) = shapes(&Settings::default(), &mesh, &[0.7]);
    for scale in [1e-6, 1e6] {
        let scaled = FlatMesh { positions: mesh.positions.iter().map(|p| p * scale).collect(), ..mesh.clone() };
        let (other, _) = shapes(&Settings::default(), &scaled, &[0.7]);
        let back: Vec<_> = other[0].positions.iter().map(|p| p / scale as f32).collect();
        assert!(distance(&back, &made[0].positions) < 1e-6 * 0.08);
    }
}

#[test]
fn a_free_leaf_keeps_its_place() {
    let mesh = FlatMesh { held: Vec::new(), ..ovate(7) };
    let (made, _) = shapes(&Settings::default(), &mesh, &[0.8]);
    let mut areas = vec![0.0; mesh.positions.len()];
    for &t in &mesh.triangles {
        t.iter().for_each(|&v| areas[v as usize] += mesh.doubled_area(t));
    }
    let mean =
        |of: &dyn Fn(usize) -> f64| (0..areas.len()).map(|v| of(v) * areas[v]).sum::<f64>() / areas.iter().sum::<f64>();
    for axis in 0..3 {
        let flat = |v: usize| if axis < 2 { mesh.positions[v][axis] } else { 0.0 };
        let moved = mean(&|v| f64::from(made[0].positions[v][axis]) - flat(v));
        assert!(moved.abs() < 1e-8, "{axis}: {moved}");
    }
}

#[test]
fn smallest_meshes_are_defined_and_none_is_an_error() {
    for count in [1, 2] {
        let (made, _) = shapes(&Settings::default(), &triangles(count), &[1.0]);
        assert_eq!(made[0].triangles.len(), count);
        assert_eq!(shapes(&paper(), &triangles(count), &[1.0]).0.len(), 1);
    }
    assert_eq!(refusal(&Settings::default(), &FlatMesh::default()), DeformError::Empty);
    assert_eq!(refusal(&paper(), &FlatMesh::default()), DeformError::Empty);
}

#[test]
fn degenerate_triangles_are_named() {
    let mut sliver = ovate(4);
    let [a, b, c] = sliver.triangles[20];
    sliver.positions[c as usize] = (sliver.positions[a as usize] + sliver.positions[b as usize]) * 0.5;
    let mut short = ovate(4);
    let [a, b, _] = short.triangles[20];
    short.positions[b as usize] = short.positions[a as usize] + DVec2::new(1e-12, 0.0);
    let mut not_a_number = ovate(4);
    not_a_number.positions[7].x = f64::NAN;
    for mesh in [sliver, short, not_a_number] {
        for settings in [Settings::default(), paper()] {
            let refusal = refusal(&settings, &mesh);
            assert!(matches!(refusal, DeformError::Degenerate { .. }), "{refusal}");
            assert!(refusal.to_string().contains("triangle"));
        }
    }
}

#[test]
fn memory_is_refused_before_it_is_taken() {
    let mut limits = Limits::default();
    limits.set(Limit::Memory, 1e5);
    let refused = deform::deform(&Settings::default(), &ovate(12), &jobs(&[0.5]), 1, &limits);
    assert!(matches!(refused, Err(DeformError::Refused(refusal)) if refusal.limit == Limit::Memory));
}

#[test]
#[ignore = "takes a minute and more than a gigabyte"]
fn a_hundred_thousand_vertices_settle() {
    let settings = shell(shell::Settings { curl: 10.0, ..shell::Settings::default() });
    let iterations = |rings| shapes(&settings, &ovate(rings), &[1.0]).1("iterations");
    let (few, many) = (iterations(26), iterations(182));
    assert!(many <= 2.0 * few, "{few} {many}");
}

#[test]
fn a_mesh_of_two_levels_has_the_shape_of_one() {
    // 8,269 vertices start from a coarser mesh; 2,107 do not.
    let settings = shell(shell::Settings { curl: 10.0, ..shell::Settings::default() });
    let [coarse, fine] = [26, 52].map(ovate);
    let [a, b] = [&coarse, &fine].map(|mesh| shapes(&settings, mesh, &[0.6]).0.remove(0).positions);
    let twin = |p: &DVec2| fine.positions.iter().position(|q| (q - p).norm() < 1e-9).expect("a twin");
    let twins: Vec<_> = coarse.positions.iter().map(|p| b[twin(p)]).collect();
    let difference = distance(&a, &twins) / distance(&twins, &flat(&coarse));
    assert!(difference < 0.02, "{difference}");
}

#[test]
fn a_mask_of_any_size_bends_alike() {
    let mesh = FlatMesh { uv_scale: 0.94 / 0.08, uv_origin: DVec2::new(0.5, 0.97), ..ovate(8) };
    let shape = |width: u32, height: u32| {
        let grey = |i: u32| {
            let x = (f64::from(i % width) + 0.5) / f64::from(width) - 0.5;
            let grey = 255.0 * (1.0 - (x / 0.47 / 0.7).abs()).clamp(0.0, 1.0);
            [grey as u8, grey as u8, grey as u8, 255]
        };
        let mask = Picture { width, height, pixels: (0..width * height).map(grey).collect() };
        let flat = Flat { mesh: &mesh, mask: Some(&mask) };
        deform::deform(&Settings::default(), flat, &jobs(&[0.5]), 1, &Limits::default()).expect("a shape").0.remove(0)
    };
    let (square, wide) = (shape(512, 512), shape(700, 90));
    let away = distance(&square.positions, &flat(&mesh));
    assert!(distance(&square.positions, &wide.positions) < 0.02 * away, "{away}");
    assert!(shape(1, 1).check().is_ok());
}

#[test]
fn settings_out_of_range_are_refused_by_their_key() {
    for (key, value) in [
        ("strain_limit", "-0.1"),
        ("strain_limit", "nan"),
        ("step", "0.0"),
        ("step", "-1e-4"),
        ("step", "nan"),
        ("step", "1e-300"),
        ("step", "1e300"),
    ] {
        let text = format!("species = \"red-maple\"\n[deform]\nmodel = \"paper\"\n{key} = {value}\n");
        let folder = tempfile::tempdir().expect("a folder");
        let scene = folder.path().join("scene.toml");
        std::fs::write(&scene, text).expect("a scene");
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_leafseason")).arg("plan").arg(&scene).output();
        let run = run.expect("a run");
        let told = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(3), "{key} = {value}: {told}");
        assert!(told.contains(key), "{key} = {value}: {told}");
    }
}

#[test]
fn stiff_sheets_do_not_shake_the_implicit_ways() {
    // A thickness of a thousandth: stretch is 10^7 times stiffer than bending.
    let settings = shell::Settings { thickness: 1e-3, curl: 3.0, ..shell::Settings::default() };
    let mesh = ovate(5);
    for method in [Method::Implicit { steps: 8 }, Method::PositionBased { steps: 100 }] {
        let found = run(&settings, &mesh, &[0.5, 1.0], 1, method).expect("a run");
        assert!(found.energies.iter().all(|energy| energy.is_finite()), "{method:?}");
        let far = found.shapes.iter().flatten().map(|p| p.norm()).fold(0.0, f64::max);
        assert!(far < 3.0, "{method:?}: {far}");
    }
}

#[test]
fn the_papers_strain_bound_holds_from_nought_to_none_and_over_eight_decades_of_stiffness() {
    let mesh = ovate(4);
    for strain_limit in [0.0, 1e-6, 0.1, 1.0, 1e6] {
        let settings = Settings { strain_limit, force: 0.05, field: Field::Normal, steps: 60, ..paper() };
        let (_, figure) = shapes(&settings, &mesh, &[1.0]);
        assert!(figure("max_strain") <= strain_limit + 0.011, "{strain_limit}: {}", figure("max_strain"));
    }
    for stiffness in [1e-6, 1.0, 1e2, 1e4, 1e6, 1e8] {
        for field in [Field::Constant, Field::Point, Field::Normal, Field::Curl] {
            let settings = Settings { stiffness, field, steps: 40, ..paper() };
            let (_, figure) = shapes(&settings, &mesh, &[1.0]);
            assert!(figure("max_strain") <= 0.111, "{stiffness} {field:?}");
        }
    }
}

#[test]
fn forces_that_cannot_be_borne_are_refused_by_name() {
    let settings = Settings { force: 1e6, field: Field::Constant, steps: 50, ..paper() };
    match deform::deform(&settings, &ovate(4), &jobs(&[1.0]), 1, &Limits::default()) {
        Ok((shapes, _)) => assert!(shapes[0].check().is_ok()),
        Err(error) => assert!(error.to_string().contains("deform.force"), "{error}"),
    }
}

#[test]
fn gravity_bends_down_and_dry_leaves_still_settle() {
    for gravity in [0.5, 50.0, 1000.0] {
        let settings = shell(shell::Settings { gravity, ..shell::Settings::default() });
        let mesh = ovate(6);
        let (made, _) = shapes(&settings, &mesh, &[0.0, 0.5]);
        let mean = made[0].positions.iter().map(|p| f64::from(p.z)).sum::<f64>() / made[0].positions.len() as f64;
        assert!(mean < -1e-5, "{gravity}: {mean}");
    }
}
