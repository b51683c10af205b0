//! A traced leaf as TOML: the keys of `[leaf]` that a scene reads with `leaf.file`. Lengths are rounded to a tenth of a
//! micrometre, those of a leaf that is taken straight from its scan as well, so that both ways give the same blade.

use crate::base::message::shown;
use crate::leaf::{Settings, VeinLine};
use std::fmt::Write;

/// Places behind the point of a length in millimetres.
const PLACES: usize = 4;
/// Points of a line of the file.
const A_LINE: usize = 6;

/// Names of the pictures beside the file.
pub const MASK: &str = "mask.png";
/// The blade's upper side.
pub const TEXTURE: &str = "texture.png";

/// A length in millimetres as the file holds it.
#[must_use]
pub fn rounded(millimetres: f64) -> f64 {
    // No negative zero: it would be written.
    (millimetres * 1e4).round() / 1e4 + 0.0
}

/// The file's text for settings that hold an outline. `scan` names the picture.
#[must_use]
pub fn text(settings: &Settings, scan: &str) -> String {
    let mut text = format!(
        "# A leaf traced from {}. In a scene: leaf.file = \"leaf.toml\"\n# Lengths are millimetres from the petiole's joint, \
         x to the right, y towards the tip, key points counter-clockwise.\n[leaf]\n",
        shown(scan, 200)
    );
    let _ = writeln!(
        text,
        "length = {:?}  # from the joint to the farthest tip; another one scales the leaf",
        settings.length
    );
    text.push_str(&changed(settings));
    if let Some([x, y]) = settings.joint {
        let _ = writeln!(text, "joint = [{x:.2}, {y:.2}]  # pixels of the scan, from its upper left corner");
    }
    let _ = writeln!(text, "mask = \"{MASK}\"  # white stays, black moves most: paint over it as you like");
    let _ = writeln!(text, "texture = \"{TEXTURE}\"");
    if !settings.petiole.is_empty() {
        let _ = writeln!(text, "petiole = [{}]  # x, y, width", points(&settings.petiole));
    }
    let _ = writeln!(text, "outline = [{}]", points(settings.outline.as_deref().unwrap_or_default()));
    if !settings.holes.is_empty() {
        let holes: Vec<String> = settings.holes.iter().map(|hole| format!("[{}]", points(hole))).collect();
        let _ = writeln!(text, "# gaps that are seen through the blade\nholes = [\n{},\n]", holes.join(",\n"));
    }
    for vein in &settings.veins {
        let VeinLine { order, width, end_width, points: line } = vein;
        let _ = writeln!(text, "\n[[leaf.veins]]\norder = {order}");
        let _ = writeln!(text, "width = {:?}\nend_width = {:?}", rounded(*width), rounded(*end_width));
        let _ = writeln!(text, "points = [{}]", points(line));
    }
    text
}

/// Keys that decide the blade and differ from their defaults.
fn changed(settings: &Settings) -> String {
    let json = |settings: &Settings| serde_json::to_value(settings).unwrap_or_default();
    let (own, default) = (json(settings), json(&Settings::default()));
    let keys = ["corner", "venation", "meshing", "vertices", "iterations"];
    // Numbers and plain words are written alike in JSON and TOML.
    keys.iter().filter(|key| own[**key] != default[**key]).map(|key| format!("{key} = {}\n", own[*key])).collect()
}

fn points<const N: usize>(points: &[[f64; N]]) -> String {
    let number = |x: &f64| format!("{:.PLACES$}", rounded(*x));
    let point = |p: &[f64; N]| format!("[{}]", p.iter().map(number).collect::<Vec<_>>().join(", "));
    let lines: Vec<String> =
        points.chunks(A_LINE).map(|line| line.iter().map(point).collect::<Vec<_>>().join(", ")).collect();
    format!("\n    {},\n", lines.join(",\n    "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(serde::Deserialize)]
    struct File {
        leaf: Settings,
    }

    #[test]
    fn what_is_written_is_read_back() {
        let outline: Vec<[f64; 2]> = (0..20).map(|i| [f64::from(i) * 1.23456, f64::from(i * i) * -0.1]).collect();
        let outline: Vec<[f64; 2]> = outline.iter().map(|p| p.map(rounded)).collect();
        let written = Settings {
            outline: Some(outline),
            holes: vec![vec![[1.0, 2.0], [2.0, 2.0], [2.0, 3.0]], vec![[4.0, 2.0], [5.0, 2.0], [5.0, 3.0]]],
            petiole: vec![[0.0, -1.0, 1.5], [0.5, -20.0, 1.25]],
            veins: vec![
                VeinLine { order: 1, points: vec![[0.0, 0.0], [0.0, 30.25]], width: 1.1, end_width: 0.3 },
                VeinLine { order: 2, points: vec![[0.0, 10.0], [5.0, 14.0]], width: 0.4, end_width: 0.1 },
            ],
            joint: Some([100.25, 30.5]),
            length: 81.5,
            corner: 100.0,
            vertices: 777,
            venation: crate::leaf::Venation::Pinnate,
            mask: Some(MASK.to_owned()),
            texture: Some(TEXTURE.to_owned()),
            ..Settings::default()
        };
        let text = text(&written, "a\u{1b}[2J.png");
        assert!(!text.contains('\u{1b}'));
        let read: File = toml::from_str(&text).unwrap();
        assert_eq!(read.leaf, written);
    }
}
