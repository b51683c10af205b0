//! Golden pictures and plans. Each shows one subject, small, and must be met exactly: the picture's pixels (not the file's
//! bytes, which a newer encoder may change) and the plan's text.
//!
//! To bless a change: look at the new picture under `target/golden/`, then `LEAFSEASON_BLESS=NAME cargo test --test golden`
//! (`all` for every one). Blessing writes the golden and still fails, so that no automatic run can bless.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use leafseason::base::limits::Limits;
use leafseason::base::picture::Picture;
use leafseason::run::{self, Options, progress, signals::Signals};
use leafseason::scene;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Scenes under `scenes/golden/`, or small pictures of those under `scenes/`, and what would break each.
const PICTURES: &[(&str, &str)] = &[
    ("maple", "anything that changes the look of a whole tree in autumn"),
    ("winter", "wood: branching, radii, bark, shadow on the ground"),
    ("fork", "the joint of a limb seen near: collar, smooth sides, bark's scale"),
    ("shoot", "a current shoot: leaves on petioles, opposite pairs, two-sided light"),
    ("leaf_red", "one blade: outline, curl, veins and colour of a red leaf"),
    ("leaf_charts", "a leaf by itself: wireframe and mask; cells of a sheet"),
    ("abop-monopodial", "Honda's tree: turns, brackets and `$` of the turtle, wood without leaves"),
    ("abop-sympodial", "the tree of Aono and Kunii: the same with every apex ending in a fork"),
    ("abop-ternary", "rules on F and `!`, and wood that bends by its weight"),
    ("leaf_backlit", "light through a blade: transmission, veins against the sun"),
    ("habits", "the built-in rules: a birch, an oak, a ginkgo and a maple without leaves"),
    ("grove", "several trees: places, turns, forms that stand again, the camera that holds all"),
    ("sheet", "a contact sheet: cells, and the numbers of their seeds"),
];

/// Scenes whose plan is golden.
const PLANS: &[(&str, &str)] = &[
    ("maple", "what a usual scene runs"),
    ("winter", "what a leafless scene leaves out"),
    ("film", "frames that equal another"),
];

const LARGEST_PICTURE: u64 = 22 * 1024; // grass is noise to an encoder: 120 x 120 pixels of it take 20 KiB
const LARGEST_FOLDER: u64 = 4 << 20;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn blessed(name: &str) -> bool {
    std::env::var("LEAFSEASON_BLESS").is_ok_and(|wanted| wanted == "all" || wanted == name)
}

/// What a scene that is not made for it needs to become a small picture.
const SMALL: [&str; 4] = ["image.width=112", "image.height=112", "image.samples=8", "light.shadow_size=1024"];

fn read_scene(name: &str) -> scene::Scene {
    let (own, shown) = (root().join(format!("scenes/golden/{name}.toml")), root().join(format!("scenes/{name}.toml")));
    let (path, sets) = if own.exists() { (own, Vec::new()) } else { (shown, SMALL.map(str::to_owned).to_vec()) };
    scene::read(&path, &sets, &[], &Limits::default()).unwrap_or_else(|fault| panic!("{name}: {fault}")).0
}

fn rendered(name: &str) -> Picture {
    let out = tempfile::tempdir().expect("a folder");
    let options = Options { out: out.path().to_owned(), ..Options::default() };
    let mut progress = progress::Progress::new(progress::Mode::None);
    let outcome = run::render(&read_scene(name), &options, &mut progress, &Signals::default());
    outcome.unwrap_or_else(|fault| panic!("{name}: {fault}"));
    decoded(&out.path().join(format!("{name}.png")))
}

fn decoded(path: &Path) -> Picture {
    let image = image::open(path).unwrap_or_else(|fault| panic!("{}: {fault}", path.display())).into_rgba8();
    let (width, height) = image.dimensions();
    Picture { width, height, pixels: image.pixels().map(|pixel| pixel.0).collect() }
}

fn write_png(path: &Path, picture: &Picture) {
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    // As small as can be, for the repository.
    let opaque = picture.pixels.iter().all(|pixel| pixel[3] == 255);
    let (kind, channels) = if opaque { (ExtendedColorType::Rgb8, 3) } else { (ExtendedColorType::Rgba8, 4) };
    let bytes: Vec<u8> = picture.pixels.iter().flat_map(|pixel| &pixel[..channels]).copied().collect();
    let file = fs::File::create(path).expect("a file");
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(&bytes, picture.width, picture.height, kind).expect("written");
}

/// Expected, difference times eight, actual, side by side.
fn strip(expected: &Picture, actual: &Picture) -> Picture {
    let mut strip = Picture::filled(actual.width * 3, actual.height, [0, 0, 0, 255]);
    for (index, &found) in actual.pixels.iter().enumerate() {
        let (x, y) = (index % actual.width as usize, index / actual.width as usize);
        let wanted = expected.pixels[index];
        let gap: [u8; 4] =
            std::array::from_fn(|k| if k == 3 { 255 } else { wanted[k].abs_diff(found[k]).saturating_mul(8) });
        for (part, pixel) in [wanted, gap, found].into_iter().enumerate() {
            strip.pixels[y * strip.width as usize + part * actual.width as usize + x] = pixel;
        }
    }
    strip
}

/// What is wrong with a picture, after writing what helps to see it; `None` when it is met.
fn picture_fault(name: &str) -> Option<String> {
    let golden = root().join("golden").join(format!("{name}.png"));
    let actual = rendered(name);
    let shown = root().join("target/golden").join(format!("{name}.png"));
    let _ = fs::remove_file(root().join("target/golden").join(format!("{name}.strip.png")));
    write_png(&shown, &actual);
    if blessed(name) {
        write_png(&golden, &actual);
        return Some("blessed; run again without LEAFSEASON_BLESS".to_owned());
    }
    if !golden.exists() {
        return Some(format!("has no golden picture; look at {} and bless it", shown.display()));
    }
    let expected = decoded(&golden);
    if (expected.width, expected.height) != (actual.width, actual.height) {
        return Some("has another size".to_owned());
    }
    let gap = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0);
    let gaps: Vec<u8> = expected.pixels.iter().zip(&actual.pixels).map(gap).collect();
    let (place, largest) = gaps.iter().enumerate().max_by_key(|(_, gap)| **gap)?;
    if *largest == 0 {
        return None;
    }
    let count = gaps.iter().filter(|gap| **gap > 0).count();
    let (x, y) = (place % actual.width as usize, place / actual.width as usize);
    let compared = root().join("target/golden").join(format!("{name}.strip.png"));
    write_png(&compared, &strip(&expected, &actual));
    Some(format!("{count} pixels differ, by {largest} at most, at ({x}, {y}); see {}", compared.display()))
}

#[test]
fn pictures_are_met_exactly() {
    let faults: Vec<(&str, &str, String)> =
        PICTURES.iter().filter_map(|(name, guards)| Some((*name, *guards, picture_fault(name)?))).collect();
    let mut page = String::from("<!doctype html><title>golden pictures</title>\n");
    for (name, guards, fault) in &faults {
        let strip = root().join(format!("target/golden/{name}.strip.png"));
        let shown = if strip.exists() { format!("{name}.strip.png") } else { format!("{name}.png") };
        let _ = writeln!(page, "<h2>{name}</h2><p>{guards}<p>{fault}<p><img src=\"{shown}\">");
    }
    if !faults.is_empty() {
        fs::write(root().join("target/golden/index.html"), page).expect("written");
    }
    let lines: Vec<String> = faults.iter().map(|(name, _, fault)| format!("{name}: {fault}")).collect();
    assert!(lines.is_empty(), "\n{}", lines.join("\n"));
}

#[test]
fn plans_are_met_exactly() {
    let mut faults = Vec::new();
    for (name, _) in PLANS {
        let plan = run::plan(&read_scene(name), &Options::default()).unwrap_or_else(|fault| panic!("{name}: {fault}"));
        let text = plan.text();
        let golden = root().join("golden").join(format!("{name}.plan.txt"));
        if blessed(name) {
            fs::write(&golden, &text).expect("written");
            faults.push(format!("{name}: blessed; run again without LEAFSEASON_BLESS"));
        } else if fs::read_to_string(&golden).unwrap_or_default() != text {
            faults.push(format!("{name}: the plan is now\n{text}"));
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn the_golden_folder_holds_what_is_tested_and_stays_small() {
    let mut total = 0;
    let known: Vec<String> = PICTURES
        .iter()
        .map(|(name, _)| format!("{name}.png"))
        .chain(PLANS.iter().map(|(name, _)| format!("{name}.plan.txt")))
        .collect();
    for entry in fs::read_dir(root().join("golden")).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = entry.file_name().to_string_lossy().into_owned();
        let size = entry.metadata().expect("metadata").len();
        assert!(known.contains(&name), "{name} has no test");
        assert!(size <= LARGEST_PICTURE, "{name} has {size} bytes");
        total += size;
    }
    assert!(total <= LARGEST_FOLDER, "{total} bytes");
}
