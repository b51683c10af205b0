//! What the leaf stage must reach on scans: of a painted leaf whose outline is known, and of real ones where they lie beside
//! the repository (or beside the folder of its worktrees).

#[path = "common/painted_leaf.rs"]
mod painted_leaf;

use leafseason::base::blade::Blade;
use leafseason::base::figures::Figures;
use leafseason::base::limits::Limits;
use leafseason::base::picture::Picture;
use leafseason::base::vector::DVec2;
use leafseason::deform::{self, Field, Job, Model};
use leafseason::leaf::steps::{agreement, distance_correlation};
use leafseason::leaf::{self, Settings, Traced, Truth};
use leafseason::scene::{self, Asset};
use painted_leaf::{Scan, outline, painted};
use std::path::{Path, PathBuf};

/// The scans beside the repository, by name; none when they are not there.
fn shared(traced_only: bool) -> Vec<(String, PathBuf)> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["../shared/leaves", "../../shared/leaves"].map(|folder| here.join(folder));
    let Some(folder) = folders.iter().find(|folder| folder.is_dir()) else { return Vec::new() };
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_picture = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "jpg" || ending == "png");
    let mut files: Vec<PathBuf> = files.filter(is_picture).filter(|p| !traced_only || truth_of(p).is_some()).collect();
    files.sort();
    files.into_iter().map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), path)).collect()
}

fn truth_of(scan: &Path) -> Option<Truth> {
    let text = std::fs::read_to_string(scan.with_extension("truth.json")).ok()?;
    Some(serde_json::from_str(&text).unwrap())
}

fn traced(picture: &Picture, truth: Option<&Truth>, vertices: u32) -> (Traced, Figures) {
    traced_as(picture, truth, &Settings { vertices, ..Settings::default() })
}

fn traced_as(picture: &Picture, truth: Option<&Truth>, settings: &Settings) -> (Traced, Figures) {
    leaf::traced(settings, picture, truth, &Limits::default()).unwrap()
}

fn read(path: &Path) -> Picture {
    scene::read_picture(&Asset::outside(path), &Limits::default()).unwrap()
}

fn figure(figures: &Figures, name: &str) -> f64 {
    figures.values.get(name).and_then(serde_json::Value::as_f64).unwrap_or_else(|| panic!("no {name} in {figures:?}"))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

#[test]
fn a_painted_leaf_is_met_in_every_respect() {
    let scan = Scan { hole: true, ..Scan::default() };
    let truth = Truth { blade: outline(scan), ..Truth::default() };
    let (found, figures) = traced(&painted(scan), Some(&truth), 1000);
    assert_eq!((found.trace.holes.len(), found.trace.others), (1, 0));
    // The truth has no gap; the painted one has half axes of 20 and 30 pixels.
    let gap = std::f64::consts::PI * 600.0 / (found.trace.area() as f64 + std::f64::consts::PI * 600.0);
    assert!((figure(&figures, "iou") - (1.0 - gap)).abs() < 0.01, "{figures:?}");
    assert!(figure(&figures, "outline_hausdorff_px") <= 1.0);
    assert!((figure(&figures, "vertices") / 1000.0 - 1.0).abs() <= 0.05);
    assert!(figure(&figures, "min_angle_deg") >= 33.0, "{figures:?}");
    assert!(figure(&figures, "q_mean") >= 0.98 && figure(&figures, "q_p05") >= 0.92, "{figures:?}");
}

#[test]
fn real_scans_are_traced_as_by_hand() {
    let mut ious = Vec::new();
    let mut f1s = Vec::new();
    for (name, path) in shared(true) {
        let (_, figures) = traced(&read(&path), truth_of(&path).as_ref(), 220);
        let (iou, f1) = (figure(&figures, "iou"), figure(&figures, "vein_f1"));
        println!("{name}: IoU {iou:.4}, veins F1 {f1:.3}");
        assert!(iou >= 0.98, "{name}: {iou}");
        ious.push(iou);
        f1s.push(f1);
    }
    assert!(ious.is_empty() || (mean(&ious) >= 0.985 && mean(&f1s) >= 0.80), "{ious:?} {f1s:?}");
}

#[test]
fn real_scans_have_even_meshes() {
    let names = ["min_angle_deg", "q_mean", "q_p05", "edge_cv", "boundary_hausdorff_px"];
    let mut columns: [Vec<f64>; 5] = Default::default();
    for (name, path) in shared(false) {
        let picture = read(&path);
        let even = Settings { vertices: 1000, joint_edges: 1.0, ..Settings::default() };
        let (_, figures) = traced_as(&picture, None, &even);
        // Finer about the joint they have as many vertices and no worse angles.
        let (_, graded) = traced(&picture, None, 1000);
        assert!(figure(&graded, "min_angle_deg") >= 33.0 && figure(&graded, "q_mean") >= 0.975, "{name}: {graded:?}");
        for vertices in [&figures, &graded].map(|figures| figure(figures, "vertices")) {
            assert!((vertices / 1000.0 - 1.0).abs() <= 0.05, "{name}: {vertices} vertices");
        }
        columns.iter_mut().zip(names).for_each(|(column, key)| column.push(figure(&figures, key)));
    }
    let [angles, q_means, q_lows, variations, distances] = &columns;
    if angles.is_empty() {
        return;
    }
    println!("smallest angles {:.1} in the mean, {:.1} at worst", mean(angles), least(angles));
    println!("q {:.4}, 5th percentile {:.3}, edges {:.4}", mean(q_means), mean(q_lows), mean(variations));
    println!("rim {:.2} px off in the mean", mean(distances));
    assert!(least(angles) >= 33.0, "{angles:?}");
    assert!(mean(angles) >= 37.0 && mean(q_means) >= 0.990 && mean(q_lows) >= 0.94 && mean(variations) <= 0.060);
}

#[test]
fn veins_drawn_from_the_outline_alone_come_near_to_those_traced_by_hand() {
    let (mut f1s, mut correlations) = (Vec::new(), Vec::new());
    for (name, path) in shared(true) {
        let truth = truth_of(&path).unwrap();
        let (found, _) = traced(&read(&path), None, 220);
        let blind = Settings { veins: Vec::new(), mask: None, texture: None, ..found.settings.clone() };
        let (blade, figures) = leaf::model(&blind, leaf::Pictures::default(), &Limits::default()).unwrap();
        assert_eq!(figures.values["veins"], "outline");
        let size: [u32; 2] = found.trace.picture_size().map(|side| side as u32);
        let tolerance = 0.03 * (found.trace.area() as f64).sqrt();
        let pose = &found.trace.pose;
        let f1 = agreement(&blade.veins, pose, &truth.veins, size.into(), tolerance).f1();
        let outline: Vec<DVec2> = truth.blade.iter().map(|&p| DVec2::from(p)).collect();
        let correlation = distance_correlation(&blade.veins, pose, &truth.veins, &outline, size.into());
        println!("{name}: F1 {f1:.3} at 3 %, correlation of distances {correlation:.3}");
        f1s.push(f1);
        correlations.push(correlation);
    }
    assert!(f1s.is_empty() || (mean(&f1s) >= 0.70 && mean(&correlations) >= 0.40), "{f1s:?} {correlations:?}");
}

/// Whether a point lies in a polygon that may cross itself (non-zero rule).
fn is_within(polygon: &[[f64; 2]], x: f64, y: f64) -> bool {
    let turns = |(i, a): (usize, &[f64; 2])| {
        let b = polygon[(i + 1) % polygon.len()];
        let is_left = (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]) > 0.0;
        i32::from(a[1] <= y && b[1] > y && is_left) - i32::from(a[1] > y && b[1] <= y && !is_left)
    };
    polygon.iter().enumerate().map(turns).sum::<i32>() != 0
}

#[test]
fn the_derived_mask_is_white_on_veins_traced_by_hand() {
    for (name, path) in shared(true) {
        let truth = truth_of(&path).unwrap();
        let (found, _) = traced(&read(&path), None, 1000);
        let [width, height] = found.trace.picture_size();
        let grey = |x: usize, y: usize| {
            let plane = found.trace.pose.plane(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            let uv = found.blade.mesh.uv(plane);
            let cell = |t: f32, side: u32| ((t.max(0.0) * side as f32) as u32).min(side - 1);
            let mask = &found.blade.mask;
            f64::from(mask.at(cell(uv.x, mask.width), cell(uv.y, mask.height))[0])
        };
        let (mut veins, mut rest) = (Vec::new(), Vec::new());
        for (x, y) in (0..height).step_by(5).flat_map(|y| (0..width).step_by(5).map(move |x| (x, y))) {
            let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
            if is_within(&truth.blade, px, py) {
                (if is_within(&truth.veins, px, py) { &mut veins } else { &mut rest }).push(grey(x, y));
            }
        }
        rest.sort_by(f64::total_cmp);
        let below = |g: &f64| {
            let less = rest.partition_point(|r| r < g);
            let equal = rest.partition_point(|r| r <= g) - less;
            (less as f64 + 0.5 * equal as f64) / rest.len() as f64
        };
        let area = veins.iter().map(below).sum::<f64>() / veins.len() as f64;
        println!("{name}: {:.0} on veins, {:.0} beside them, ROC area {area:.3}", mean(&veins), mean(&rest));
        assert!(mean(&veins) >= 200.0 && area >= 0.85, "{name}: {} {area}", mean(&veins));
    }
}

/// Vertices at the ends of the main veins, and vertices on the main veins but for their last third.
fn tips_and_veins(blade: &Blade) -> (Vec<usize>, Vec<usize>) {
    let points = &blade.mesh.positions;
    let nearest = |p: DVec2| {
        let distance = |&v: &usize| (points[v] - p).norm();
        (0..points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    let mains = || blade.veins.iter().filter(|vein| vein.order == 1);
    let tips = mains().map(|vein| nearest(vein.points[vein.points.len() - 1])).collect();
    let bodies = mains().flat_map(|vein| vein.points[..vein.points.len() * 2 / 3].iter().copied());
    let mut on_veins: Vec<usize> = bodies.map(nearest).collect();
    on_veins.sort_unstable();
    on_veins.dedup();
    (tips, on_veins)
}

/// Spearman's rank correlation; ties take their order.
fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let ranks = |values: &[f64]| {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&i, &j| values[i].total_cmp(&values[j]).then(i.cmp(&j)));
        let mut ranks = vec![0.0; values.len()];
        order.iter().enumerate().for_each(|(rank, &i)| ranks[i] = rank as f64);
        ranks
    };
    let n = a.len() as f64;
    let squares: f64 = ranks(a).iter().zip(ranks(b)).map(|(x, y)| (x - y) * (x - y)).sum();
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

/// How far each vertex is moved by the paper's mechanics under an even force along the normals, from rest, while the
/// largest displacement is still a few hundredths of the blade.
fn displacements(blade: &Blade) -> Vec<f64> {
    let jobs = [Job { state: "dry".to_owned(), variant: 0, dryness: 1.0 }];
    let settings = deform::Settings {
        model: Model::Paper,
        field: Field::Normal,
        force: 1e-4,
        steps: 60,
        drag: 0.0,
        friction: 0.0,
        ..deform::Settings::default()
    };
    let (meshes, _) = deform::deform(&settings, blade, &jobs, 1, &Limits::default()).unwrap();
    let moved = meshes[0].positions.iter().zip(&blade.mesh.positions);
    moved.map(|(now, before)| (now.cast::<f64>() - before.push(0.0)).norm()).collect()
}

#[test]
fn the_derived_mask_makes_tips_move_and_veins_stay() {
    let painted = (String::from("painted"), painted(Scan::default()));
    let scans = shared(true).into_iter().map(|(name, path)| (name, read(&path))).chain([painted]);
    for (name, picture) in scans {
        let (found, _) = traced(&picture, None, 400);
        let moved = displacements(&found.blade);
        let extent = found.blade.mesh.area().sqrt();
        let largest = moved.iter().copied().fold(0.0, f64::max) / extent;
        assert!((0.002..0.05).contains(&largest), "{name}: {largest} of the blade");
        let (tips, veins) = tips_and_veins(&found.blade);
        let of = |vertices: &[usize]| mean(&vertices.iter().map(|&v| moved[v]).collect::<Vec<f64>>());
        let ratio = of(&tips) / of(&veins);
        let light: Vec<f64> = found.blade.mesh.greys.iter().map(|grey| 255.0 - grey).collect();
        let correlation = rank_correlation(&light, &moved);
        println!("{name}: tips move {ratio:.2} times as far as main veins, rank correlation {correlation:.3}");
        assert!(ratio >= 3.0 && correlation >= 0.7, "{name}: {ratio} {correlation}");
    }
}
