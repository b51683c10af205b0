//! Cases of outlines and meshes.

use super::{Case, Seen, case};
use crate::base::blade::Blade;
use crate::base::limits::{Limit, Limits};
use crate::base::maths::sincos;
use crate::leaf::{self, LeafError, Pictures, Settings};
use crate::study::numbers::shown;
use std::f64::consts::TAU;

pub const CASES: &[Case] = &[
    case("M01a", "three key points", "a mesh", |_| sound(&keys(3))),
    case("M01b", "two key points", "error", |_| refused(&[[0.0, 0.0], [0.0, 50.0]], "fewer than 3 distinct points")),
    case("M01c", "20,000 key points", "a mesh", |_| sound(&keys(20_000))),
    case("M01d", "100,000 key points", "refused at once, with the most that are taken", |_| {
        refused(&keys(100_000), "100000 points")
    }),
    case("M02a", "every key point twice", "merged: the same mesh", |_| {
        let doubled: Vec<[f64; 2]> = keys(24).into_iter().flat_map(|key| [key, key]).collect();
        same(&keys(24), &doubled)
    }),
    case("M02b", "the first key point again as the last", "merged: the same mesh", |_| {
        let mut closed = keys(24);
        closed.push(closed[0]);
        same(&keys(24), &closed)
    }),
    case("M03", "key points on a line", "error", |_| refused(&[[0.0, 0.0], [0.0, 10.0], [0.0, 30.0], [0.0, 50.0]], "")),
    case("M04a", "an outline that crosses itself", "error that says between which points", |_| {
        refused(&[[0.0, 0.0], [20.0, 30.0], [20.0, 0.0], [0.0, 30.0]], "crosses itself")
    }),
    case("M04b", "a hairpin", "a mesh, or an error that says between which points", |_| hairpin()),
    case("M05", "clockwise", "reversed: the same mesh", |_| {
        let mut reversed = keys(24);
        reversed.reverse();
        same(&keys(24), &reversed)
    }),
    case("M06", "a needle of 1000 to 1", "a finite mesh; excused triangles are counted", |_| needle()),
    case("M08a", "an edge longer than the leaf: three vertices", "at least one triangle", |_| count(3)),
    case("M08b", "an edge of 1e-4 of the leaf: 1e8 vertices", "refused before memory is taken, with the limit", |_| {
        let settings = Settings { vertices: 100_000_000, outline: Some(keys(24)), ..Settings::default() };
        let mut limits = Limits::default();
        limits.set(Limit::Vertices, 1e6);
        match leaf::model(&settings, Pictures::default(), &limits) {
            Err(LeafError::Refused(refusal)) => (refusal.limit == Limit::Vertices, refusal.to_string()),
            other => (false, format!("{:?}", other.map(|made| made.0.mesh.positions.len()))),
        }
    }),
    case("M10a", "coordinates of 1e-12", "scaled: the same mesh", |_| scaled(1e-12)),
    case("M10b", "coordinates of 1e12", "scaled: the same mesh", |_| scaled(1e12)),
    case("M10c", "a coordinate that is no number", "error that names the point", |_| {
        let mut keys = keys(24);
        keys[7][1] = f64::NAN;
        refused(&keys, "point 7 is not finite")
    }),
];

/// Key points of an oval from its joint.
fn keys(count: u32) -> Vec<[f64; 2]> {
    let point = |number: u32| {
        let (sine, cosine) = sincos(TAU * f64::from(number) / f64::from(count));
        [20.0 * sine, 40.0 * (1.0 - cosine)]
    };
    (0..count).map(point).collect()
}

fn made(outline: &[[f64; 2]]) -> Result<(Blade, f64), LeafError> {
    let settings = Settings { outline: Some(outline.to_vec()), ..Settings::default() };
    let (blade, figures) = leaf::model(&settings, Pictures::default(), &Limits::default())?;
    Ok((blade, figures.values.get("excused_triangles").and_then(serde_json::Value::as_f64).unwrap_or(0.0)))
}

fn is_sound(blade: &Blade) -> bool {
    let mesh = &blade.mesh;
    !mesh.triangles.is_empty() && mesh.triangles.iter().all(|&t| mesh.doubled_area(t) > 0.0)
}

fn sound(outline: &[[f64; 2]]) -> Seen {
    match made(outline) {
        Ok((blade, _)) => (is_sound(&blade), format!("{} triangles", blade.mesh.triangles.len())),
        Err(error) => (false, error.to_string()),
    }
}

fn refused(outline: &[[f64; 2]], says: &str) -> Seen {
    match made(outline) {
        Ok((blade, _)) => (false, format!("{} triangles", blade.mesh.triangles.len())),
        Err(error) => (error.to_string().contains(says), error.to_string()),
    }
}

fn same(outline: &[[f64; 2]], other: &[[f64; 2]]) -> Seen {
    match (made(outline), made(other)) {
        (Ok((a, _)), Ok((b, _))) => {
            let same = a.mesh == b.mesh;
            (same, format!("{} vertices, {}", b.mesh.positions.len(), if same { "the same" } else { "not the same" }))
        }
        (Err(error), _) | (_, Err(error)) => (false, error.to_string()),
    }
}

fn hairpin() -> Seen {
    let outline = [[0.0, 0.0], [20.0, 50.0], [0.2, 1.0], [-0.2, 1.0], [-20.0, 50.0]];
    match made(&outline) {
        Ok((blade, _)) => (is_sound(&blade), format!("{} triangles", blade.mesh.triangles.len())),
        Err(error) => (error.to_string().contains("crosses itself"), error.to_string()),
    }
}

fn needle() -> Seen {
    let outline = [[0.0, 0.0], [0.05, 25.0], [0.05, 75.0], [0.0, 100.0], [-0.05, 75.0], [-0.05, 25.0]];
    match made(&outline) {
        Ok((blade, excused)) => {
            let finite = blade.mesh.positions.iter().all(|p| p.x.is_finite() && p.y.is_finite());
            (finite && is_sound(&blade), format!("{} triangles, {excused} excused", blade.mesh.triangles.len()))
        }
        Err(error) => (false, error.to_string()),
    }
}

fn count(vertices: u32) -> Seen {
    let settings = Settings { vertices, outline: Some(keys(24)), ..Settings::default() };
    match leaf::model(&settings, Pictures::default(), &Limits::default()) {
        Ok((blade, _)) => (is_sound(&blade), format!("{} triangles", blade.mesh.triangles.len())),
        Err(error) => (true, error.to_string()),
    }
}

fn scaled(scale: f64) -> Seen {
    let outline: Vec<[f64; 2]> = keys(24).iter().map(|key| key.map(|x| x * scale)).collect();
    match (made(&keys(24)), made(&outline)) {
        (Ok((a, _)), Ok((b, _))) if a.mesh.positions.len() == b.mesh.positions.len() => {
            let apart = a.mesh.positions.iter().zip(&b.mesh.positions).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
            (apart < 1e-9, format!("{} m apart at most", shown(apart)))
        }
        (Ok(_), Ok((b, _))) => (is_sound(&b), format!("{} vertices, sound", b.mesh.positions.len())),
        (Err(error), _) | (_, Err(error)) => (false, error.to_string()),
    }
}
