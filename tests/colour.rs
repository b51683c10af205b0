//! Colours through the whole program: a flat leaf's pixel against the table of named leaves, textures of every species
//! against their states' colours, plain colours and sliders in a scene, and what reaches a glTF file.

use leafseason::base::limits::Limits;
use leafseason::base::maths::{linear_to_srgb8, srgb_to_linear};
use leafseason::base::picture::Picture;
use leafseason::colour::{self, Job, Painted, Pigments, Settings, State, Table, appearance, colour_difference};
use leafseason::run::{self, Options, progress, signals::Signals};
use leafseason::{leaf, scene, species};
use serde_json::Value;

/// A leaf's name, contents, reflected and transmitted colour.
type Named = (&'static str, [f64; 7], [u8; 3], [u8; 3]);

/// Named leaves of `leaf_colours_expected.csv`, computed by another implementation of the model on the 5 nm table:
/// structure, chlorophyll, carotenoids, anthocyanins, brown, water, dry matter; reflected and transmitted 8-bit colours.
const NAMED: [Named; 6] = [
    ("green_summer", [1.45, 38.0, 7.0, 3.6, 0.06, 0.01, 0.0025], [0x49, 0x55, 0x36], [0x48, 0x53, 0x00]),
    ("yellow_clear", [1.7, 0.8, 7.0, 0.0, 0.02, 0.0085, 0.0045], [0xc6, 0x9b, 0x33], [0xbe, 0x90, 0x00]),
    ("red", [1.7, 1.5, 4.0, 12.0, 0.08, 0.008, 0.005], [0x98, 0x52, 0x42], [0x90, 0x3f, 0x23]),
    ("brown", [2.2, 0.5, 1.0, 0.5, 1.6, 0.0015, 0.0048], [0x85, 0x6c, 0x57], [0x62, 0x44, 0x2a]),
    ("red_flush", [1.25, 9.0, 3.2, 8.0, 0.02, 0.009, 0.0015], [0x73, 0x52, 0x3b], [0x8b, 0x60, 0x2e]),
    ("green_flush", [1.25, 18.0, 4.6, 1.5, 0.02, 0.009, 0.0015], [0x62, 0x6b, 0x34], [0x77, 0x7d, 0x0f]),
];

/// One flat leaf before the camera in white light of one direction, without gloss and tone curve, in its even colour.
const FLAT: &str = r#"
species = "beech"
season = { start = "green" }
time = { day = 0.0 }
tree = { axiom = "L(1)", rules = [] }
colour.table = "5nm"
colour.detail = "plain"
colour.gloss = false
colour.size = 16
colour.variants = 1
deform = { model = "paper", states = { green = { dryness = 0.0 } } }
image = { width = 32, height = 32, samples = 4 }
light = { tone = "none", sky = 0.0, sun = 3.333333, shadow_size = 0 }
"#;

/// The picture of a scene, and what its report says of the states' colours.
fn rendered(text: &str) -> (Picture, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("leaf.toml");
    std::fs::write(&path, text).expect("written");
    let scene = scene::read(&path, &[], &[], &Limits::default()).unwrap_or_else(|fault| panic!("{fault}")).0;
    let options = Options { out: folder.path().to_owned(), ..Options::default() };
    let mut progress = progress::Progress::new(progress::Mode::None);
    let outcome = run::render(&scene, &options, &mut progress, &Signals::default());
    let report = outcome.unwrap_or_else(|fault| panic!("{fault}")).report;
    let image = image::open(folder.path().join("leaf.png")).expect("a picture").into_rgba8();
    let picture =
        Picture { width: image.width(), height: image.height(), pixels: image.pixels().map(|pixel| pixel.0).collect() };
    (picture, report.figure("colour", "states").cloned().unwrap_or_default())
}

fn contents(values: &[f64; 7]) -> String {
    let keys = ["structure", "chlorophyll", "carotenoids", "anthocyanins", "brown", "water", "dry_matter"];
    let pair = |(key, value): (&&str, &f64)| format!("colour.pigments.green.{key} = {value}\n");
    keys.iter().zip(values).map(pair).collect()
}

#[test]
fn a_flat_leaf_in_white_light_has_the_tables_colour_from_the_front_and_from_behind() {
    for (name, values, reflected, transmitted) in NAMED {
        // The sun of a specimen stands before its upper side.
        let sides = [("position = [0.0, 0.04, 0.4]", reflected), ("position = [0.0, 0.04, -0.4]", transmitted)];
        for (position, expected) in sides {
            let camera = format!("[camera]\nsubject = \"leaf\"\n{position}\ntarget = [0.0, 0.04, 0.0]\n");
            let (picture, _) = rendered(&format!("{FLAT}\n{}\n{camera}", contents(&values)));
            let middle = picture.at(16, 16);
            for c in 0..3 {
                assert!(middle[c].abs_diff(expected[c]) <= 1, "{name}, {position}: {middle:?} for {expected:?}");
            }
        }
    }
}

#[test]
fn the_shared_table_is_met_to_the_code_by_plain_textures() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/optics/leaf_colours_expected.csv");
    let Ok(text) = std::fs::read_to_string(path) else { return };
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().expect("a heading").split(',').collect();
    let column = |name: &str| heads.iter().position(|head| *head == name).expect(name);
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |name: &str| fields[column(name)].parse::<f64>().expect(name);
        let pigments = Pigments {
            structure: number("N"),
            chlorophyll: number("cab_ug_cm2"),
            carotenoids: number("car_ug_cm2"),
            anthocyanins: number("ant_ug_cm2"),
            brown: number("brown"),
            water: number("cw_cm"),
            dry_matter: number("cm_g_cm2"),
        };
        let settings = Settings {
            table: Table::Fine,
            detail: colour::Detail::Plain,
            gloss: false,
            size: Some(16),
            pigments: [("leaf".to_owned(), State::Contents(pigments))].into(),
            ..Settings::default()
        };
        let job = Job { state: "leaf".to_owned(), variant: 0 };
        let painted = &colour::paint(&settings, &Default::default(), &[job], 1).0[0];
        for (texture, code) in [(&painted.reflected, "refl_srgb8"), (&painted.transmitted, "trans_srgb8")] {
            let expected = u32::from_str_radix(fields[column(code)].trim_start_matches('#'), 16).expect(code);
            for c in 0..3 {
                let expected = (expected >> (16 - 8 * c) & 255) as u8;
                assert!(texture[100][c].abs_diff(expected) <= 1, "{}: {:?}", fields[0], texture[100]);
            }
        }
    }
}

#[derive(serde::Deserialize)]
struct Tables {
    leaf: leaf::Settings,
    colour: Settings,
}

fn tables(name: &str) -> Tables {
    toml::from_str(species::text(name).expect(name)).expect(name)
}

/// Mean linear colour over the triangles of the blade, by their texture coordinates' middles, weighted by area.
fn mean(pixels: &[[u8; 3]], size: u32, blade: &leafseason::base::blade::Blade) -> [f64; 3] {
    let outline: Vec<[f64; 2]> = blade
        .outline
        .iter()
        .map(|&point| blade.mesh.uv(point).map(|c| f64::from(c) * f64::from(size)).into())
        .collect();
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for row in 0..size {
        let y = f64::from(row) + 0.5;
        // Crossings of the outline with the row's middle: inside between the first and second, and so on.
        let mut crossings: Vec<f64> = (0..outline.len())
            .filter_map(|i| {
                let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
                ((a[1] <= y) != (b[1] <= y)).then(|| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            })
            .collect();
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            let first = (pair[0] - 0.5).ceil().max(0.0) as u32;
            for column in first..size.min((pair[1] - 0.5).ceil().max(0.0) as u32) {
                let pixel = pixels[(row * size + column) as usize];
                for c in 0..3 {
                    sum[c] += f64::from(srgb_to_linear(f32::from(pixel[c]) / 255.0));
                }
                count += 1.0;
            }
        }
    }
    sum.map(|s| s / count)
}

#[test]
fn every_texture_of_every_species_has_its_states_mean_colour_and_its_own_face() {
    for name in species::names() {
        let Tables { leaf: shape, colour } = tables(name);
        // Without the gloss lobe textures hold what the report states.
        let settings = Settings { size: Some(128), gloss: false, ..colour };
        let (blade, _) = leaf::model(&shape, leaf::Pictures::default(), &Limits::default()).expect(name);
        let jobs: Vec<Job> = settings.pigments.keys().map(|state| Job { state: state.clone(), variant: 0 }).collect();
        let painted = colour::paint(&settings, &blade, &jobs, 3).0;
        for (job, texture) in jobs.iter().zip(&painted) {
            let expected = appearance(&settings.contents(&job.state), settings.table);
            let clipped = |colour: [f64; 3]| colour.map(|c| c.max(0.0));
            let reflected =
                colour_difference(mean(&texture.reflected, texture.size, &blade), clipped(expected.reflected));
            let through =
                colour_difference(mean(&texture.transmitted, texture.size, &blade), clipped(expected.transmitted));
            assert!(reflected < 2.0 && through < 2.0, "{name} {}: dE {reflected} and {through}", job.state);
            assert_faces(name, job, texture);
        }
    }
}

/// The lower side is paler, veins are darker against the light, and the relief is one of unit normals.
fn assert_faces(name: &str, job: &Job, texture: &Painted) {
    let green = |pixels: &[[u8; 3]]| pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>();
    assert!(green(&texture.below) > green(&texture.reflected), "{name} {}", job.state);
    for normal in texture.relief.iter().step_by(97) {
        let n = normal.map(|code| (f64::from(code) - 128.0) / 127.0);
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        assert!((length - 1.0).abs() < 0.02 && n[2] > 0.0, "{name}: {normal:?}");
    }
}

fn triple(value: &Value) -> [f64; 3] {
    let list = value.as_array().expect("a colour");
    [0, 1, 2].map(|c| list[c].as_f64().expect("a number"))
}

#[test]
fn a_plain_colour_is_fitted_and_the_report_says_how_far_it_is_off() {
    let camera = "[camera]\nsubject = \"leaf\"\n";
    let green = &rendered(&format!("{FLAT}\ncolour.pigments.green = \"#985242\"\n{camera}")).1["green"];
    let wanted = [0x98u8, 0x52, 0x42].map(|code| f64::from(srgb_to_linear(f32::from(code) / 255.0)));
    let off = colour_difference(triple(&green["reflected"]), wanted);
    let said = green["fitted"]["dE76"].as_f64().expect("a figure");
    assert!((off - said).abs() < 1e-9 && said < 1.0, "{off} {said}");
    assert!(green["fitted"]["pigments"]["anthocyanins"].as_f64().expect("contents") > 5.0);
}

#[test]
fn sliders_win_over_contents() {
    let camera = "[camera]\nsubject = \"leaf\"\n";
    let red = triple(&rendered(&format!("{FLAT}\ncolour.sliders.green.red = 1.0\n{camera}")).1["green"]["reflected"]);
    assert!(red[0] > 3.0 * red[1], "{red:?}");
}

#[test]
fn what_is_no_colour_is_refused_at_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("leaf.toml");
    let text = "species = \"beech\"\n[colour.pigments]\ngreen = \"ochre\"\n[colour.sliders.brown]\nred = 2.0\n";
    std::fs::write(&path, text).expect("written");
    let found = scene::read(&path, &[], &[], &Limits::default()).expect_err("faults").0;
    let told: Vec<String> = found.iter().map(leafseason::base::message::render).collect();
    assert_eq!(told.len(), 2, "{told:#?}");
    for (text, parts) in told.iter().zip([["leaf.toml:3:9", "ochre", "#b5301c"], ["leaf.toml:5:7", "red", "0"]]) {
        assert!(parts.iter().all(|part| text.contains(part)), "{parts:?} in {text}");
    }
}

#[test]
fn codes_of_the_table_are_those_of_its_numbers() {
    // The table gives both: a check of the encoding that the other tests rely on.
    assert_eq!([0.0669, 0.0902, 0.0363].map(linear_to_srgb8), [0x49, 0x55, 0x36]);
}
