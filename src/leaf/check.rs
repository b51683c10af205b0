//! What is wrong with well-typed settings, as far as can be told without meshing.

use crate::base::settings::Complaint;
use crate::leaf::{Settings, outline};

/// Everything wrong with well-typed settings. A clockwise outline is no fault.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    let counts = too_many(settings);
    if !counts.is_empty() {
        return counts;
    }
    let mut complaints = of_outline(settings);
    let narrow = settings.petiole.iter().position(|&[.., width]| width <= 0.0);
    complaints.extend(narrow.map(|number| {
        Complaint::new(format!("petiole.{number}"), "the petiole has no width here", "give each point x, y and a width")
    }));
    let short = settings.veins.iter().position(|vein| vein.points.len() < 2);
    complaints.extend(short.map(|number| {
        Complaint::new(format!("veins.{number}"), "this vein has fewer than 2 points", "give it two points or more")
    }));
    complaints
}

/// Most points of a line, gaps, and veins: what is beyond them takes longer than it is worth.
const MOST_POINTS: usize = 20_000;
const MOST_HOLES: usize = 500;
const MOST_VEINS: usize = 5_000;

/// Lists that are too long to work on.
fn too_many(settings: &Settings) -> Vec<Complaint> {
    let lines = settings.outline.iter().map(|line| ("outline".to_owned(), line.len()));
    let holes = settings.holes.iter().enumerate().map(|(number, hole)| (format!("holes.{number}"), hole.len()));
    let veins = settings.veins.iter().enumerate().map(|(number, vein)| (format!("veins.{number}"), vein.points.len()));
    let petiole = [("petiole".to_owned(), settings.petiole.len())];
    let points = lines.chain(holes).chain(veins).chain(petiole).map(|(key, count)| (key, count, MOST_POINTS, "points"));
    let lists = [
        ("holes".to_owned(), settings.holes.len(), MOST_HOLES, "gaps"),
        ("veins".to_owned(), settings.veins.len(), MOST_VEINS, "veins"),
    ];
    let complaint = |(key, count, most, what): (String, usize, usize, &str)| {
        (count > most).then(|| Complaint::new(key, format!("here are {count} {what}"), format!("give at most {most}")))
    };
    lists.into_iter().chain(points).filter_map(complaint).collect()
}

fn of_outline(settings: &Settings) -> Vec<Complaint> {
    let Some(points) = settings.outline.as_deref().filter(|_| settings.picture.is_none()) else { return Vec::new() };
    let corner = settings.corner.to_radians();
    let complaints = outline::complaints(points, corner);
    if complaints.is_empty() { outline::complaints_of_holes(points, &settings.holes, corner) } else { complaints }
}
