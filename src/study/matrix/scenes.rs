//! Cases of whole scenes: what is not there is not done, and what is wrong is told.

use super::bench::SMALL;
use super::{Bench, Case, Seen, case};

pub const CASES: &[Case] = &[
    case("S01a", "a tree without leaves", "no leaf, shape or texture is made", |bench| {
        let scene = "tree = { axiom = \"F(1)F(1)\", rules = [], iterations = 0 }\n";
        without(bench, "s01a", scene, &["leaf", "deform", "colour", "season", "fall"])
    }),
    case("S01b", "a leaf without a tree", "a picture of the leaf", |bench| {
        let scene = "species = \"red-maple\"\ntree = { axiom = \"L(1)\", rules = [], iterations = 0 }\n";
        without(bench, "s01b", scene, &[])
    }),
    case("S01c", "no climate", "drawn in the default climate", |bench| without(bench, "s01c", SMALL, &["gltf"])),
    case("S01d", "no picture: glTF only", "nothing is rasterised", |bench| {
        let scene = format!("{SMALL}output = {{ png = false, gltf = \"merged\" }}\n");
        let ended = bench.render("s01d", &scene, &[]);
        let stages = bench.stages("s01d");
        let passes = ended.code == Some(0) && !stages.iter().any(|stage| stage == "raster" || stage == "png");
        (passes, format!("stages: {}", stages.join(" ")))
    }),
    case("S01e", "every leaf has fallen", "no leaf, shape or texture is made", |bench| {
        let ended = bench.render("s01e", SMALL, &["time.day=400", "ground.kind=none"]);
        stages_without(bench, "s01e", ended.code, &["leaf", "deform", "colour"])
    }),
    case("S02a", "an unknown key", "error with its place and the nearest known key", |bench| {
        bench
            .render("s02a", &format!("{SMALL}[climate]\nhumidty = 0.5\n"), &[])
            .is_refusal(&["s02a.toml:4:1", "humidity"])
    }),
    case("S02b", "a value of the wrong type", "error with its place", |bench| {
        bench
            .render("s02b", &format!("{SMALL}[climate]\nhumidity = \"wet\"\n"), &[])
            .is_refusal(&["s02b.toml:4:12", "climate.humidity"])
    }),
    case("S02c", "a scene that is not there", "error that names it", |bench| {
        let arguments = ["render", "none.toml", "--out", "none-out"].map(str::to_owned);
        bench.run(&arguments).is_refusal(&["none.toml"])
    }),
    case("S02d", "a PNG that cannot be read", "error that names it", |bench| {
        bench.put("broken.png", b"\x89PNG\r\n\x1a\nnonsense");
        bench
            .render("s02d", &format!("{SMALL}[leaf]\nvertices = 40\nmask = \"broken.png\"\n"), &[])
            .is_refusal(&["broken.png"])
    }),
    case("S02e", "an output folder that cannot be made", "error that names it", |bench| {
        bench.put("plain", b"a file");
        bench.put("s02e.toml", SMALL.as_bytes());
        let arguments = ["render", "s02e.toml", "--out", "plain/below", "--set", "tree.age=3"].map(str::to_owned);
        bench.run(&arguments).is_refusal(&["plain"])
    }),
];

fn without(bench: &Bench, name: &str, scene: &str, absent: &[&str]) -> Seen {
    let ended = bench.render(name, scene, &[]);
    let (drawn, observed) = ended.is_drawn();
    let (passes, stages) = stages_without(bench, name, ended.code, absent);
    (drawn && passes, if drawn { stages } else { observed })
}

fn stages_without(bench: &Bench, name: &str, code: Option<i32>, absent: &[&str]) -> Seen {
    let stages = bench.stages(name);
    let none = !stages.iter().any(|stage| absent.contains(&stage.as_str()));
    (code == Some(0) && none && !stages.is_empty(), format!("stages: {}", stages.join(" ")))
}

#[cfg(test)]
mod tests {
    use super::super::Bench;

    #[test]
    fn without_a_program_cases_fail_and_do_not_panic() {
        let folder = tempfile::tempdir().unwrap();
        let bench = Bench::new(folder.path(), None);
        assert!(super::CASES.iter().all(|case| !(case.run)(&bench).0));
        bench.clean();
        assert!(!folder.path().join("matrix-scratch").exists());
    }
}
