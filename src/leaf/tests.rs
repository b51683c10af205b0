use super::*;
use crate::base::maths::sincos;
use crate::base::settings::Complaint;
use std::path::Path;

#[derive(serde::Deserialize)]
struct File {
    leaf: Settings,
}

fn maple() -> Settings {
    let file: File = toml::from_str(include_str!("../species/red-maple.leaf.toml")).unwrap();
    file.leaf
}

fn modelled(settings: &Settings) -> (Blade, Figures) {
    model(settings, Pictures::default(), &Limits::default()).unwrap()
}

fn figure(figures: &Figures, name: &str) -> f64 {
    figures.values[name].as_f64().unwrap()
}

/// Everything that must hold for a blade.
fn assert_sound(blade: &Blade) {
    let mesh = &blade.mesh;
    assert!(mesh.triangles.iter().all(|&t| mesh.doubled_area(t) > 0.0));
    let edges = mesh.edges();
    assert_eq!(mesh.positions.len() + mesh.triangles.len(), edges.len() + 1, "Euler's formula of a disc");
    assert_eq!(2 * edges.len() - mesh.rim.len(), 3 * mesh.triangles.len(), "every edge is inner or rim");
    let rim: Vec<DVec2> = mesh.rim.iter().map(|&v| mesh.positions[v as usize]).collect();
    assert!((polygon::doubled_area(&rim) * 0.5 / mesh.area() - 1.0).abs() < 1e-12);
    // Small teeth, of which the mesh knows nothing, add and take a little.
    assert!((polygon::doubled_area(&blade.outline) * 0.5 / mesh.area() - 1.0).abs() < 0.03);
    let margin = BLADE_UV_MARGIN as f32 - 1e-6;
    assert!(mesh.uvs.iter().all(|uv| uv.iter().all(|&x| x >= margin && x <= 1.0 - margin)));
    assert!(mesh.greys.iter().all(|g| (0.0..=255.0).contains(g)) && mesh.greys.len() == mesh.positions.len());
    assert!(mesh.held.iter().any(|&v| mesh.positions[v as usize].norm() < 1e-3));
}

#[test]
fn the_red_maple_has_even_triangles() {
    let (blade, figures) = modelled(&maple());
    println!("red maple: {figures:?}");
    assert_sound(&blade);
    assert!((209.0..=231.0).contains(&figure(&figures, "vertices")), "{figures:?}");
    assert!(figure(&figures, "min_angle_deg") >= 25.0, "{figures:?}");
    assert!(figure(&figures, "q_mean") >= 0.95, "{figures:?}");
    assert!(figure(&figures, "edge_cv") <= 0.12, "{figures:?}");
    assert_eq!(blade.veins.iter().filter(|v| v.order == 1).count(), 5);
}

#[test]
fn without_teeth_the_mesh_encloses_what_the_outline_does() {
    let (blade, _) = modelled(&Settings { teeth: Teeth::default(), ..maple() });
    assert_sound(&blade);
    assert!((polygon::doubled_area(&blade.outline) * 0.5 / blade.mesh.area() - 1.0).abs() < 1e-3);
}

#[test]
fn teeth_change_the_drawn_margin_and_nothing_that_bends() {
    let (plain, toothed) = (modelled(&Settings { teeth: Teeth::default(), ..maple() }).0, modelled(&maple()).0);
    assert_ne!(plain.outline, toothed.outline);
    assert_eq!((plain.mesh, plain.veins, plain.mask), (toothed.mesh, toothed.veins, toothed.mask));
}

#[test]
fn finer_meshes_are_better_and_nearer_the_outline() {
    let at = |vertices: u32| modelled(&Settings { vertices, ..maple() });
    let (coarse, fine) = (at(220).1, at(900).1);
    let error = |figures: &Figures| figures.error.clone().unwrap().value;
    assert!(error(&fine) < error(&coarse));
    assert!(figure(&fine, "q_mean") > figure(&coarse, "q_mean"));
    assert!((855.0..=945.0).contains(&figure(&fine, "vertices")));
}

#[test]
fn rounds_even_the_triangles_out() {
    let after = |iterations: u32| figure(&modelled(&Settings { iterations, ..maple() }).1, "q_mean");
    assert!(after(0) < after(3) && after(3) < after(160));
}

#[test]
fn the_same_outline_gives_the_same_blade_in_either_direction() {
    let settings = maple();
    let mut reversed = settings.clone();
    reversed.outline.as_mut().unwrap().reverse();
    assert!(check(&reversed).is_empty());
    assert_eq!(modelled(&settings), modelled(&settings));
    assert_eq!(modelled(&settings).0, modelled(&reversed).0);
}

#[test]
fn a_smooth_oval_keeps_its_area() {
    let point = |i: u32| sincos(std::f64::consts::TAU * f64::from(i) / 24.0);
    let outline = (0..24).map(point).map(|(s, c)| [20.0 * c, 40.0 * (s + 1.0)]).collect();
    let (blade, _) = modelled(&Settings { outline: Some(outline), length: 80.0, ..Settings::default() });
    assert_sound(&blade);
    assert!((blade.mesh.area() / (std::f64::consts::PI * 8e-4) - 1.0).abs() < 2e-3);
}

#[test]
fn faulty_outlines_are_refused() {
    let bow_tie = vec![[0.0, 0.0], [20.0, 30.0], [20.0, 0.0], [0.0, 30.0]];
    let settings = Settings { outline: Some(bow_tie), ..Settings::default() };
    let complaints: Vec<Complaint> = check(&settings);
    assert!(complaints[0].message.contains("crosses itself"), "{complaints:?}");
    let refused = model(&settings, Pictures::default(), &Limits::default());
    assert!(matches!(refused, Err(LeafError::Settings(_))));
    let shapeless = model(&Settings::default(), Pictures::default(), &Limits::default());
    assert_eq!(shapeless.unwrap_err(), LeafError::Shapeless);
}

#[test]
fn limits_stand_before_the_work() {
    let mut limits = Limits::default();
    limits.set(Limit::Vertices, 100.0);
    assert!(matches!(model(&maple(), Pictures::default(), &limits), Err(LeafError::Refused(_))));
}

#[test]
fn a_painted_mask_wins() {
    let mask = Picture::filled(8, 8, [77, 77, 77, 255]);
    let pictures = Pictures { mask: Some(&mask), ..Pictures::default() };
    let (blade, _) = model(&maple(), pictures, &Limits::default()).unwrap();
    assert!(blade.mesh.greys.iter().all(|g| (g - 77.0).abs() < 1e-9));
}

const PAPER: [u8; 4] = [235, 228, 215, 255];
const GREEN: [u8; 4] = [70, 130, 40, 255];
/// Where the painted leaf's axis points: up and to the right.
const AXIS: [f64; 2] = [0.6, -0.8];
const JOINT: [f64; 2] = [130.0, 280.0];

/// An oval of 200 x 120 px on cream paper with a stalk of 60 x 4 px.
fn painted() -> Picture {
    let mut picture = Picture::filled(400, 400, PAPER);
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let (x, y) = ((i % 400) as f64 + 0.5 - JOINT[0], (i / 400) as f64 + 0.5 - JOINT[1]);
        let (along, across) = (x * AXIS[0] + y * AXIS[1], x * AXIS[1] - y * AXIS[0]);
        let oval = ((along - 100.0) / 100.0, across / 60.0);
        if oval.0 * oval.0 + oval.1 * oval.1 < 1.0 || (along > -60.0 && along < 10.0 && across.abs() < 2.0) {
            *pixel = GREEN;
        }
    }
    picture
}

#[test]
fn a_painted_leaf_is_traced() {
    let picture = painted();
    let settings = Settings { length: 100.0, ..Settings::default() };
    let trace = trace(&settings, &picture, &Limits::default()).unwrap();
    assert!((trace.pose.joint - DVec2::from(JOINT)).norm() < 8.0, "{:?}", trace.pose);
    assert!(trace.pose.axis.dot(&DVec2::from(AXIS)) > 0.99, "{:?}", trace.pose);
    // the default bound: a thousandth of the diagonal, at least a pixel
    assert!(trace.hausdorff <= 1.0);
    let pictures = Pictures { picture: Some(&picture), ..Pictures::default() };
    let (blade, figures) = model(&settings, pictures, &Limits::default()).unwrap();
    assert_sound(&blade);
    assert!(figure(&figures, "outline_hausdorff_px") <= 1.0);
    // An oval of half axes 100 and 60 px, 100 mm for about 200 px.
    assert!((blade.mesh.area() / (std::f64::consts::PI * 50.0 * 30.0 * 1e-6) - 1.0).abs() < 0.05);
    let scan = blade.scan.unwrap();
    let far = |p: &[u8; 4]| (0..3).map(|c| (i32::from(p[c]) - i32::from(GREEN[c])).abs()).max().unwrap();
    assert!(scan.pixels.iter().all(|p| far(p) <= 12), "only leaf colour is left");
}

#[test]
fn a_traced_leaf_written_to_a_file_gives_the_same_blade() {
    let picture = painted();
    let settings = Settings { length: 100.0, ..Settings::default() };
    let found = traced(&settings, &picture, None, &Limits::default()).unwrap().0;
    let text = file_text(&found.settings, "painted.png");
    let file: File = toml::from_str(&text).unwrap();
    let pictures = Pictures { mask: Some(&found.blade.mask), texture: found.blade.scan.as_ref(), picture: None };
    let (blade, _) = model(&file.leaf, pictures, &Limits::default()).unwrap();
    assert_eq!(blade, found.blade);
}

#[test]
fn a_texture_of_its_own_stands_before_the_scan_s() {
    let picture = painted();
    let blue = Picture::filled(32, 32, [10, 20, 200, 255]);
    let pictures = Pictures { picture: Some(&picture), texture: Some(&blue), mask: None };
    let (blade, _) = model(&Settings::default(), pictures, &Limits::default()).unwrap();
    assert_eq!(blade.scan, Some(blue));
    let clear = Picture::filled(32, 32, [10, 20, 200, 0]);
    let pictures = Pictures { texture: Some(&clear), ..Pictures::default() };
    assert!(matches!(model(&maple(), pictures, &Limits::default()), Err(LeafError::Settings(_))));
}

#[test]
fn lists_that_make_no_sense_are_told() {
    let told = |settings: Settings| check(&settings).first().map(|one| one.key.clone()).unwrap_or_default();
    assert_eq!(told(Settings { petiole: vec![[0.0, 0.0, 1.0], [0.0, -5.0, -1.0]], ..maple() }), "petiole.1");
    let vein = VeinLine { points: vec![[0.0, 0.0]], ..VeinLine::default() };
    assert_eq!(told(Settings { veins: vec![vein.clone()], ..maple() }), "veins.0");
    assert_eq!(told(Settings { veins: vec![vein; 6000], ..maple() }), "veins");
    assert_eq!(told(Settings { outline: Some(vec![[0.0, 1.0]; 30_000]), ..maple() }), "outline");
    assert_eq!(told(maple()), "");
}

#[derive(serde::Deserialize)]
struct Truth {
    blade: Vec<[f64; 2]>,
}

#[test]
fn shared_scans_agree_with_their_hand_traces() {
    // Beside the repository, or beside the folder of its worktrees.
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["../shared/leaves", "../../shared/leaves"].map(|folder| here.join(folder));
    let folder = folders.iter().find(|folder| folder.is_dir()).unwrap_or(&folders[0]);
    let (mut sum, mut count) = (0.0, 0);
    for name in ["grape_palmate_a", "grape_palmate_b", "grape_palmate_petiole"] {
        let Ok(image) = image::open(folder.join(format!("{name}.jpg"))) else { continue };
        let image = image.to_rgba8();
        let pixels = image.pixels().map(|p| p.0).collect();
        let picture = Picture { width: image.width(), height: image.height(), pixels };
        let text = std::fs::read_to_string(folder.join(format!("{name}.truth.json"))).unwrap();
        let truth: Truth = serde_json::from_str(&text).unwrap();
        let trace = trace(&Settings::default(), &picture, &Limits::default()).unwrap();
        let iou = trace.iou(&truth.blade);
        let joint = (trace.pose.joint - DVec2::from(truth.blade[0])).norm();
        println!("{name}: IoU {iou:.4}, joint {joint:.0} px off, {} keys", trace.keys.len());
        assert!(iou >= 0.98, "{name}: {iou}");
        sum += iou;
        count += 1;
        assert!(joint < 0.03 * f64::from(picture.height), "{name}: {joint}");
        // the lobes overlap and leave gaps; only the third leaf's petiole lies beside the blade
        assert!(trace.gaps >= 1 && trace.others == 0, "{name}");
        assert_eq!(trace.petiole.is_some_and(|p| p.length() > 300.0), name == "grape_palmate_petiole");
    }
    assert!(sum >= 0.985 * f64::from(count), "mean IoU {}", sum / f64::from(count));
}
