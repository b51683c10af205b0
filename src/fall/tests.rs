//! What must hold of many leaves together.

use super::*;
use crate::base::mesh::Mesh;
use crate::base::random::{Purpose, Stream, hash};
use crate::base::vector::{DVec2, Vec2, Vec3};
use nalgebra::UnitQuaternion;

/// An elliptic blade of 6 by 8 cm with its joint at the origin, bent upwards with this curvature, 1/m.
pub(super) fn blade(curvature: f32) -> Mesh {
    let mut mesh = Mesh::default();
    let (rings, sides) = (6u32, 20u32);
    let mut push = |x: f32, y: f32| {
        mesh.positions.push(Vec3::new(x, y + 0.04, 0.5 * curvature * (x * x + y * y)));
        mesh.uvs.push(Vec2::new(x * 10.0 + 0.5, y * 10.0 + 0.5));
    };
    push(0.0, 0.0);
    for (ring, side) in (1..=rings).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
        let (angle, part) = (side as f64 / sides as f64 * std::f64::consts::TAU, ring as f64 / rings as f64);
        let (sine, cosine) = crate::base::maths::sincos(angle);
        push((0.03 * part * cosine) as f32, (0.04 * part * sine) as f32);
    }
    let vertex = |ring: u32, side: u32| if ring == 0 { 0 } else { 1 + (ring - 1) * sides + side % sides };
    for (ring, side) in (0..rings).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
        mesh.triangles.push([vertex(ring, side), vertex(ring + 1, side), vertex(ring + 1, side + 1)]);
        if ring > 0 {
            mesh.triangles.push([vertex(ring, side), vertex(ring + 1, side + 1), vertex(ring, side + 1)]);
        }
    }
    mesh.recompute_normals();
    mesh
}

pub(super) fn leaf(id: u64, height: f64) -> Fallen {
    let mut stream = Stream::new(1, Purpose::LeafSite, id, 77);
    let mass_per_area = stream.range(45.0, 130.0);
    let twig = DVec3::new(0.0, height, 0.0);
    Fallen { leaf: hash(id, 5), year: 0, day: stream.range(0.0, 30.0), twig, mass_per_area, length: 0.075 }
}

fn settings(wind: f64) -> Settings {
    Settings { wind, direction: Some(0.0), ..Settings::default() }
}

/// Where leaves from one height land.
fn landings(settings: &Settings, height: f64, count: u64) -> Vec<(Flight, DVec2)> {
    let wind = Wind::new(settings, 3);
    let flight = |id| Flight::new(&leaf(id, height), 3, 0.0);
    (0..count).map(flight).map(|flight| (flight, flight.aside(&wind, flight.seconds))).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

#[test]
fn ten_thousand_leaves_come_down_at_the_speed_of_the_formula() {
    let (mut found, mut formula) = (0.0, 0.0);
    for id in 0..10_000 {
        let leaf = leaf(id, 8.0);
        let flight = Flight::new(&leaf, 3, 0.0);
        let speed = flight.height / flight.seconds;
        assert!((0.4..2.5).contains(&speed), "{speed}");
        found += speed;
        formula += terminal_speed(leaf.mass_per_area);
    }
    assert!((found / formula - 1.0).abs() < 0.03, "{}", found / formula);
}

#[test]
fn in_still_air_leaves_land_near_below_their_twigs() {
    for height in [2.0, 6.0, 12.0] {
        let landed = landings(&settings(0.0), height, 4_000);
        for axis in 0..2 {
            let spread = mean(landed.iter().map(|(_, at)| at[axis] * at[axis])).sqrt();
            assert!(spread < 0.35 * height, "{height}: {spread}");
            assert!(mean(landed.iter().map(|(_, at)| at[axis])).abs() < 0.02 * height);
        }
        if height == 2.0 {
            let near = landed.iter().filter(|(_, at)| at.norm() < 1.0).count();
            assert!(near as f64 > 0.95 * landed.len() as f64, "{near}");
        }
    }
}

#[test]
fn wind_carries_leaves_by_height_over_speed() {
    for (wind, height) in [(0.5, 4.0), (2.0, 7.0), (4.0, 12.0)] {
        let landed = landings(&settings(wind), height, 20_000);
        let expected = mean(landed.iter().map(|(flight, _)| wind * height / flight.descent.speed));
        let found = mean(landed.iter().map(|(_, at)| at.x));
        assert!((found / expected - 1.0).abs() < 0.05, "{wind}: {found} {expected}");
        // also against the speed of the formula, whose inverse is not the mean of the leaves' inverses
        let formula = mean((0..20_000).map(|id| wind * height / terminal_speed(leaf(id, height).mass_per_area)));
        assert!((found / formula - 1.0).abs() < 0.05, "{wind}: {found} {formula}");
        assert!(mean(landed.iter().map(|(_, at)| at.y)).abs() < 0.05 * expected);
    }
}

/// Leaves of a crown between 2 and 8 m, 3 m in radius.
fn crown(settings: &Settings, count: u64) -> Vec<DVec2> {
    crown_of(&Wind::new(settings, 9), count, 30.0)
}

fn crown_of(wind: &Wind, count: u64, days: f64) -> Vec<DVec2> {
    let landed = |id: u64| {
        let mut stream = Stream::new(2, Purpose::LeafSite, id, 5);
        let (radius, angle) = (3.0 * stream.uniform().sqrt(), stream.range(0.0, std::f64::consts::TAU));
        let (sine, cosine) = crate::base::maths::sincos(angle);
        let mut leaf = leaf(id, stream.range(2.0, 8.0));
        leaf.day = stream.range(0.0, days);
        let flight = Flight::new(&leaf, 9, 0.0);
        DVec2::new(cosine, sine) * radius + flight.aside(wind, flight.seconds)
    };
    (0..count).map(landed).collect()
}

#[test]
fn litter_thins_out_exponentially_beyond_the_crown() {
    let landed = crown(&Settings::default(), 60_000);
    // ln of the density against the distance, rings of a metre from the crown's edge
    let ring = |number: usize| {
        let (inner, outer) = (3.5 + number as f64, 4.5 + number as f64);
        let count = landed.iter().filter(|at| (inner..outer).contains(&at.norm())).count();
        (inner + 0.5, crate::base::maths::ln(count as f64 / (outer * outer - inner * inner)))
    };
    let rings: Vec<(f64, f64)> = (0..8).map(ring).collect();
    let (mx, my) = (mean(rings.iter().map(|r| r.0)), mean(rings.iter().map(|r| r.1)));
    let product = |f: &dyn Fn(&(f64, f64)) -> f64| rings.iter().map(f).sum::<f64>();
    let (xx, yy) = (product(&|r| (r.0 - mx) * (r.0 - mx)), product(&|r| (r.1 - my) * (r.1 - my)));
    let xy = product(&|r| (r.0 - mx) * (r.1 - my));
    assert!(xy * xy / (xx * yy) > 0.97, "r2 {}", xy * xy / (xx * yy));
    assert!(xy / xx < -0.3, "slope {}", xy / xx);
}

#[test]
fn without_a_direction_litter_lies_about_the_trunk() {
    // The mean of a week's litter and of a month's lies well within the crown of 3 m; still air leaves it at the trunk.
    for (days, bound) in [(7.0, 1.5), (30.0, 0.9)] {
        let offsets = (0..12).map(|seed| {
            let wind = Wind::new(&Settings::default(), seed);
            let landed = crown_of(&wind, 3_000, days);
            landed.iter().sum::<DVec2>() / landed.len() as f64
        });
        let offsets: Vec<f64> = offsets.map(|offset| offset.norm()).collect();
        assert!(mean(offsets.iter().copied()) < 0.6 * bound && offsets.iter().all(|&o| o < bound), "{offsets:?}");
    }
    let still = crown_of(&Wind::new(&settings(0.0), 9), 6_000, 7.0);
    assert!((still.iter().sum::<DVec2>() / still.len() as f64).norm() < 0.15);
}

#[test]
fn stronger_wind_shifts_the_litter_farther() {
    let shift = |wind: f64| mean(crown(&settings(wind), 4_000).iter().map(|at| at.x));
    let shifts = [0.0, 0.3, 0.6, 1.2, 2.4, 5.0].map(shift);
    assert!(shifts.windows(2).all(|pair| pair[0] < pair[1]), "{shifts:?}");
}

#[test]
fn flights_are_smooth_at_24_pictures_a_second_and_end_as_they_should() {
    let shape = Shape::new(&blade(5.0), Stalk { hung: Vec3::new(0.0, -0.05, -0.03), lying: Vec3::zeros() });
    let wind = Wind::new(&settings(2.0), 3);
    let hung = UnitQuaternion::from_euler_angles(0.3, -1.2, 2.0);
    for id in 0..300 {
        let leaf = leaf(id, 6.0);
        let flight = Flight::new(&leaf, 3, 0.0);
        let (side, yaw) = lot(3, &leaf);
        let lying = shape.level(side, yaw);
        assert_eq!(flight.aside(&wind, 0.0), DVec2::zeros());
        assert!(flight.attitude(0.0, &hung, &lying).angle_to(&hung) < 1e-6);
        assert!(flight.attitude(flight.seconds, &hung, &lying).angle_to(&lying) < 1e-5);
        assert_eq!((flight.done(0.0), flight.lift(0.0)), (0.0, 0.0));
        assert!((flight.done(flight.seconds) - 1.0).abs() < 1e-9);
        let step = 1.0 / 24.0;
        let mut before = (DVec2::zeros(), 6.0, hung);
        for picture in 1..=(flight.seconds / step) as u32 {
            let seconds = f64::from(picture) * step;
            let height = 6.0 * (1.0 - flight.done(seconds)) + flight.lift(seconds);
            let now = (flight.aside(&wind, seconds), height, flight.attitude(seconds, &hung, &lying));
            // metres between two pictures, and turns below half a turn: a film can show them
            assert!((now.0 - before.0).norm() < 0.75, "{id} {picture}");
            assert!(now.1 <= 6.0 && now.1 > -1e-9 && (now.1 - before.1).abs() < 0.15);
            assert!(now.2.angle_to(&before.2) < 2.4, "{id} {picture} {}", now.2.angle_to(&before.2));
            before = now;
        }
    }
}

#[test]
fn every_leaf_is_somewhere_at_any_time_and_goes_one_way() {
    let (settings, decay) = (Settings { slow_motion: 3000.0, ..Settings::default() }, Decay::default());
    let rank = |fate: Fate| match fate {
        Fate::Hanging => 0,
        Fate::Air(_) => 1,
        Fate::Fresh(_) => 2,
        Fate::Brown => 3,
        Fate::Flat => 4,
        Fate::Decayed => 5,
    };
    let mut seen = [0u32; 6];
    for id in 0..300 {
        let leaf = leaf(id, 5.0);
        let flight = Flight::new(&leaf, 3, 0.0);
        let mut last = 0;
        for day in 0..1600 {
            let course = Course::new(&settings, &decay, 3, &leaf, &flight);
            let (fate, landed) = (course.fate(&settings, &leaf, &flight, f64::from(day) * 0.25), course.landed);
            assert!(rank(fate) >= last && landed >= leaf.day);
            last = rank(fate);
            seen[last] += 1;
        }
        assert_eq!(last, 5);
    }
    assert!(seen.iter().all(|&count| count > 0), "{seen:?}");
    let at_once = Settings { air: false, ..Settings::default() };
    let flight = Flight::new(&leaf(1, 5.0), 3, 0.0);
    let course = Course::new(&at_once, &decay, 3, &leaf(1, 5.0), &flight);
    assert_eq!(course.fate(&at_once, &leaf(1, 5.0), &flight, leaf(1, 5.0).day), Fate::Fresh(1.0));
}
