//! What must hold of leaves that lie on one another.

use super::tests::{blade, leaf};
use super::*;
use crate::base::maths::{cos, sin};
use crate::base::mesh::Mesh;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DVec2, DVec3, Vec3};
use std::sync::Arc;

/// Side of the squares on which surfaces are compared, metres.
const SIDE: f64 = 1e-3;

/// A blade of 6 by 8 cm rolled about its midrib, as dry leaves are, with this radius in metres.
fn rolled(radius: f64) -> Mesh {
    let mut mesh = blade(0.0);
    for p in &mut mesh.positions {
        let angle = f64::from(p.x) / radius;
        let twist = 4.0 * f64::from(p.y);
        let height = radius * (1.0 - cos(angle)) + 0.004 * sin(60.0 * f64::from(p.y)) * twist;
        *p = Vec3::new((radius * sin(angle)) as f32, p.y, height as f32);
    }
    mesh.recompute_normals();
    mesh
}

/// Shapes as they fell, then the same pressed.
fn shapes() -> Vec<Mesh> {
    let fell = [blade(0.0), blade(9.0), rolled(0.03), rolled(0.018)];
    let pressed = fell.clone().map(|mut mesh| {
        mesh.positions.iter_mut().for_each(|p| p.z *= 0.2);
        mesh.recompute_normals();
        mesh
    });
    fell.into_iter().chain(pressed).collect()
}

/// Leaves of four shapes over a square of so many metres from its middle, in the order in which they landed.
fn heap(count: u64, half: f64) -> Vec<Landed> {
    let landed = |id: u64| {
        let mut stream = Stream::new(4, Purpose::Litter, id, 0);
        let mut within = || stream.range(-half, half);
        let place = DVec2::new(within(), within());
        let fallen = leaf(id, 5.0);
        let (side, yaw) = lot(4, &fallen);
        let (shape, scale) = ((id % 4) as u32, 0.8 + 0.1 * (id % 5) as f64);
        Landed { leaf: fallen.leaf, day: id as f64 * 1e-3, place, shape, pressed: shape + 4, scale, side, yaw }
    };
    (0..count).map(landed).collect()
}

fn settled(meshes: &[Mesh], landed: &[Landed], ground: &Ground) -> (Vec<Shape>, Vec<Laid>) {
    let shapes: Vec<Shape> = meshes.iter().map(|mesh| Shape::new(mesh, Stalk::default())).collect();
    let laid = settle(ground, &shapes.iter().collect::<Vec<_>>(), landed);
    (shapes, laid)
}

#[test]
fn the_list_may_come_in_any_order_and_what_is_pressed_by_nothing_rests_on_earlier_leaves_only() {
    let landed: Vec<Landed> = heap(500, 0.75).iter().map(|l| Landed { pressed: l.shape, ..*l }).collect();
    let (_, laid) = settled(&shapes(), &landed, &Ground::default());
    let backwards: Vec<Landed> = landed.iter().rev().copied().collect();
    let again: Vec<Laid> = settled(&shapes(), &backwards, &Ground::default()).1.into_iter().rev().collect();
    assert_eq!(laid, again);
    let (_, alone) = settled(&shapes(), &landed[..200], &Ground::default());
    assert!(laid.iter().zip(&alone).all(|(all, one)| all.middle == one.middle && all.attitude == one.attitude));
    assert!(laid.iter().any(|laid| laid.is_pressed) && laid.iter().any(|laid| !laid.is_pressed));
}

#[test]
fn litter_that_is_laid_from_day_to_day_lies_as_if_it_were_laid_at_once() {
    let shapes: Vec<Shape> = shapes().iter().map(|mesh| Shape::new(mesh, Stalk::default())).collect();
    let shapes: Vec<&Shape> = shapes.iter().collect();
    let (ground, all) = (Ground::default(), heap(900, 0.9));
    let mut litter = Litter::default();
    let mut laid = Vec::new();
    for (from, to) in
        [(0, 500), (0, 530), (0, 530), (20, 530), (20, 900), (21, 900), (300, 880), (880, 900), (0, 0), (0, 9)]
    {
        let mut landed = all[from..to].to_vec();
        // some are flat by now, and the list comes in another order
        landed.iter_mut().filter(|leaf| leaf.day * 3e3 < from as f64).for_each(|leaf| leaf.shape = leaf.pressed);
        landed.reverse();
        let before = litter.settled;
        assert!(litter.settle(&ground, &shapes, &landed) == settle(&ground, &shapes, &landed), "{from} to {to}");
        laid.push(litter.settled - before);
    }
    assert!(laid[0] == 500 && laid[1] < 250 && laid[2] == 0 && laid[5] < 250 && laid[9] == 9, "{laid:?}");
}

/// Uneven ground over six metres.
fn hills() -> Ground {
    let rows: Vec<Vec<f64>> = (0..4).map(|z| (0..4).map(|x| 0.4 * f64::from((3 * x + 5 * z) % 4)).collect()).collect();
    Ground { heights: HeightMap::smoothed(&rows, 2.0).map(Arc::new), ..Ground::default() }
}

#[test]
fn litter_that_is_laid_in_windows_lies_as_if_it_were_laid_at_once() {
    let shapes: Vec<Shape> = shapes().iter().map(|mesh| Shape::new(mesh, Stalk::default())).collect();
    let shapes: Vec<&Shape> = shapes.iter().collect();
    for (ground, half) in [(Ground::default(), 4.0), (Ground::default(), 1.4), (hills(), 2.2)] {
        let all = heap(2500, half);
        let (mut cut, mut whole) = (Litter::within(4 << 20), Litter::default());
        for count in [2000, 2300, 2500] {
            let landed = &all[count - 2000..count];
            assert!(cut.settle(&ground, &shapes, landed) == whole.settle(&ground, &shapes, landed), "{half} {count}");
        }
        assert!(cut.settled == whole.settled && cut.field_bytes < whole.field_bytes, "{half}");
    }
}

#[test]
fn the_field_takes_what_is_foretold_and_no_more_however_far_leaves_are_scattered() {
    let shapes: Vec<Shape> = shapes().iter().map(|mesh| Shape::new(mesh, Stalk::default())).collect();
    let shapes: Vec<&Shape> = shapes.iter().collect();
    let taken = |count: u64, half: f64| {
        let mut litter = Litter::default();
        litter.settle(&Ground::default(), &shapes, &heap(count, half));
        (litter.field_bytes as f64, most_field_bytes(count as f64))
    };
    for (count, half, of_foretold) in
        [(1, 0.1, 0.1), (300, 7.0, 0.4), (3000, 7.0, 0.4), (300, 60.0, 0.0), (3000, 120.0, 0.0), (900, 0.8, 0.0)]
    {
        let (bytes, foretold) = taken(count, half);
        assert!(bytes <= foretold && bytes >= of_foretold * foretold, "{count} over {half} m: {bytes} of {foretold}");
    }
}

/// Surfaces over a square of ground: the top of what has been added.
struct Tops {
    side: usize,
    tops: Vec<f64>,
}

impl Tops {
    fn new(half: f64) -> Self {
        let side = 2 * ((half + 0.1) / SIDE) as usize;
        Self { side, tops: vec![0.0; side * side] }
    }

    fn at(&self, place: usize, x: i64, z: i64) -> f64 {
        self.tops.get((place as i64 + x + z * self.side as i64) as usize).copied().unwrap_or(0.0)
    }

    /// A leaf's surface: the lowest and the highest point over each square that it meets.
    fn surface(&self, mesh: &Mesh, shape: &Shape, scale: f64, laid: &Laid) -> Vec<(usize, f64, f64)> {
        let point = |p: &Vec3| laid.middle + laid.attitude * ((p.cast::<f64>() - shape.middle) * scale);
        let points: Vec<DVec3> = mesh.positions.iter().map(point).collect();
        let mut met: Vec<(usize, f64)> = Vec::new();
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| points[v as usize])) {
            let steps = ((b - a).norm().max((c - a).norm()).max((c - b).norm()) / SIDE) as usize + 2;
            for (i, j) in (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j))) {
                let (u, v) = (i as f64 / steps as f64, j as f64 / steps as f64);
                let p = a * u + b * v + c * (1.0 - u - v);
                let cell = |metres: f64| (metres / SIDE + 0.5 * self.side as f64) as usize;
                met.push((cell(p.z) * self.side + cell(p.x), p.y));
            }
        }
        met.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        met.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same[0].1, same[same.len() - 1].1)).collect()
    }

    /// The distance in space from a leaf to what lies beneath it, metres, up to 5 mm.
    fn gap(&self, surface: &[(usize, f64, f64)]) -> f64 {
        let mut least = 5e-3f64;
        for &(place, low, _) in surface {
            for (x, z) in (-3..=3i64).flat_map(|x| (-3..=3i64).map(move |z| (x, z))) {
                // squares that touch may hold points that touch
                let aside = ((x.abs() - 1).max(0).pow(2) + (z.abs() - 1).max(0).pow(2)) as f64 * SIDE * SIDE;
                let over = (low - self.at(place, x, z)).max(0.0);
                least = least.min((aside + over * over).sqrt());
            }
        }
        least
    }

    /// How deep a leaf lies within what lies beneath it, metres: the shortest way out.
    fn depth(&self, surface: &[(usize, f64, f64)]) -> f64 {
        let mut deepest = 0.0f64;
        for &(place, low, _) in surface {
            let mut out = self.at(place, 0, 0) - low;
            if out > deepest {
                for (x, z) in (-5..=5i64).flat_map(|x| (-5..=5i64).map(move |z| (x, z))) {
                    let below = (self.at(place, x, z) - low).max(0.0);
                    out = out.min(((x * x + z * z) as f64 * SIDE * SIDE + below * below).sqrt());
                }
                deepest = deepest.max(out);
            }
        }
        deepest
    }

    fn add(&mut self, surface: &[(usize, f64, f64)]) {
        for &(place, _, high) in surface {
            self.tops[place] = self.tops[place].max(high);
        }
    }
}

#[test]
fn all_of_many_leaves_touch_what_lies_below_and_none_passes_through_it() {
    let (meshes, landed) = (shapes(), heap(700, 0.72));
    let (shapes, laid) = settled(&meshes, &landed, &Ground::default());
    let mut tops = Tops::new(0.72);
    let (mut on_others, mut soft) = (0, 0);
    for (number, (leaf, laid)) in landed.iter().zip(&laid).enumerate() {
        // leaves under several covers are no rigid bodies: see the depth of piles
        soft += u32::from(laid.is_buried && laid.middle.x == leaf.place.x && laid.middle.z == leaf.place.y);
        let worn = if laid.is_pressed { leaf.pressed } else { leaf.shape } as usize;
        let surface = tops.surface(&meshes[worn], &shapes[worn], leaf.scale, laid);
        let lowest = surface.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
        let (gap, depth) = (tops.gap(&surface), tops.depth(&surface));
        assert!(lowest > -1e-4, "leaf {number} lies {lowest} m below the ground");
        assert!(gap <= 2e-3, "leaf {number} hovers by {gap} m");
        assert!(depth <= 2e-3, "leaf {number} lies {depth} m within others");
        on_others += u32::from(lowest > 1e-3);
        tops.add(&surface);
    }
    assert!(soft < 25 && on_others > 300, "{soft} {on_others}");
}

#[test]
fn on_sloping_ground_too_leaves_lie_on_the_ground() {
    let heights = (0..41 * 41).map(|n| 0.1 * f64::from(n % 41) * 0.3).collect();
    let map = HeightMap { origin: DVec2::new(-2.0, -2.0), step: 0.1, columns: 41, heights };
    let ground = Ground { heights: Some(Arc::new(map)), ..Ground::default() };
    let (meshes, landed) = (shapes(), heap(60, 0.9));
    let (shapes, laid) = settled(&meshes, &landed, &ground);
    for (leaf, laid) in landed.iter().zip(&laid) {
        let worn = if laid.is_pressed { leaf.pressed } else { leaf.shape } as usize;
        let over = meshes[worn].positions.iter().map(|p| {
            let p = laid.middle + laid.attitude * ((p.cast::<f64>() - shapes[worn].middle) * leaf.scale);
            p.y - ground.height(DVec2::new(p.x, p.z))
        });
        assert!(over.fold(f64::INFINITY, f64::min) > -1e-4);
    }
}

#[test]
fn piles_are_no_deeper_than_beds_of_litter_are() {
    // Hardwood litter in beds of 0.34 to 0.72 kg/m2 is 6 cm deep (Anderson 1982, fuel models 8 and 9): at 60 g/m2 a leaf, 5
    // to 11 mm for each layer of leaf area. One layer by itself is as high as its leaves are curled.
    let meshes = shapes();
    let area = 0.03 * 0.04 * std::f64::consts::PI * 1.02;
    let depth = |layers: f64| {
        let half = 0.3;
        let landed = heap((layers * 4.0 * half * half / area) as u64, half);
        let (shapes, laid) = settled(&meshes, &landed, &Ground::default());
        let mut tops = Tops::new(half);
        for (leaf, laid) in landed.iter().zip(&laid).filter(|(_, laid)| !laid.is_buried) {
            let worn = if laid.is_pressed { leaf.pressed } else { leaf.shape } as usize;
            let surface = tops.surface(&meshes[worn], &shapes[worn], leaf.scale, laid);
            tops.add(&surface);
        }
        let inner = |n: usize| (n as f64 * SIDE - half - 0.1).abs() < half - 0.1;
        let within = (0..tops.tops.len()).filter(|n| inner(n % tops.side) && inner(n / tops.side));
        let heights: Vec<f64> = within.map(|n| tops.tops[n]).collect();
        let buried = laid.iter().filter(|laid| laid.is_buried).count() as f64 / laid.len() as f64;
        (heights.iter().sum::<f64>() / heights.len() as f64, buried)
    };
    let [(thin, _), (middle, _), (deep, buried)] = [2.0, 5.0, 12.0].map(depth);
    assert!(thin < 0.03 && thin < middle && middle < deep, "{thin} {middle} {deep}");
    assert!((0.005..0.011).contains(&(middle / 5.0)), "{}", middle / 5.0);
    assert!((0.004..0.011).contains(&(deep / 12.0)), "{}", deep / 12.0);
    assert!(buried > 0.5, "{buried}");
}
