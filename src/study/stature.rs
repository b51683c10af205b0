//! What a forester, a botanist and an artist would measure on a tree.

use super::silhouette::silhouette;
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::acos;
use crate::base::vector::DVec3;
use crate::tree::{Segment, Settings, Tree};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A shoot of one year shorter than this is a short shoot, metres.
const SHORT_SHOOT: f64 = 0.02;
/// An axis with a year's shoot at least this long counts when orders of long shoots are counted, metres.
const LONG_SHOOT: f64 = 0.05;
/// Branches of the trunk at least this long are limbs, as a share of the tree's height.
const LIMB: f64 = 0.12;
/// Where foresters measure a trunk, metres.
const BREAST: f64 = 1.3;

/// A year's shoot: the youngest segments of one axis with their leaves.
#[derive(Clone, Copy, Debug, Default)]
struct Shoot {
    length: f64,
    segments: u32,
    leaves: u32,
    order: u32,
}

/// Figures by name; see `trees.toml` for their meaning and units. What a tree has none of is absent.
#[must_use]
pub fn stature(tree: &Tree, blade: &FlatMesh, settings: &Settings) -> BTreeMap<&'static str, f64> {
    let mut figures = BTreeMap::new();
    let mut note = |name, value: Option<f64>| {
        if let Some(value) = value.filter(|value| value.is_finite()) {
            figures.insert(name, value);
        }
    };
    let length = 100.0 * blade.positions.iter().map(|p| p.y).fold(0.0, f64::max);
    let area = blade.area() * mean(tree.sites.iter().map(|site| site.scale * site.scale)).unwrap_or(1.0);
    let leaves = tree.sites.len() as f64;
    let projection = tree.crown_projection;
    note("height_m", Some(tree.height));
    let trunk = trunk_diameter(tree);
    note("trunk_cm", trunk.map(|metres| metres * 100.0));
    note("height_over_diameter", trunk.map(|metres| tree.height / metres));
    note("crown_m", Some(2.0 * (projection / PI).sqrt()));
    note("leaves_thousands", Some(leaves * 1e-3));
    note("blade_cm", Some(length));
    note("blade_area_cm2", Some(area * 1e4));
    note("petiole_cm", mean(tree.sites.iter().map(|site| settings.petiole * 0.1 * site.scale * site.petiole_length)));
    note("leaf_area_index", Some(leaves * area / projection));
    let inclination = |normal: DVec3| acos(normal.y.abs().min(1.0)).to_degrees();
    note("inclination_deg", mean(tree.sites.iter().map(|site| inclination(site.normal))));
    note("size_cv", variation(tree));
    let shoots = current_shoots(tree);
    let long = || shoots.values().filter(|shoot| shoot.length >= SHORT_SHOOT && shoot.leaves > 0);
    let short = || shoots.values().filter(|shoot| shoot.length < SHORT_SHOOT && shoot.leaves > 0);
    let side = || long().filter(|shoot| shoot.order >= 2);
    let leaves_of = |shoot: &Shoot| f64::from(shoot.leaves);
    note("leaves_a_shoot", mean(long().map(leaves_of)));
    note("leaves_a_short_shoot", mean(short().map(leaves_of)));
    note("short_shoot_share", Some(short().map(leaves_of).sum::<f64>() / leaves));
    let internode =
        side().map(|shoot| shoot.length).sum::<f64>() / side().map(|shoot| f64::from(shoot.segments)).sum::<f64>();
    note("internode_cm", Some(internode * 100.0));
    note("blade_over_internode", Some(length / (internode * 100.0)));
    note("leaves_a_node", leaves_a_node(tree, &shoots));
    note("orders", Some(f64::from(orders(tree))));
    note("limb_deg", limb_angle(tree));
    note("twig_mm", mean(tips(tree).map(|segment| segment.radius * 2000.0)));
    note("radius_exponent", Some(settings.radius_exponent));
    let old_wood = tree.sites.iter().filter(|site| segment(tree, site.segment).is_none_or(|s| s.birth < tree.youngest));
    note("leaves_on_old_wood", Some(old_wood.count() as f64));
    let summer = silhouette(tree, blade, settings);
    note("sky_percent", Some(summer.sky * 100.0));
    note("lumpiness", Some(summer.lumpiness));
    figures
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Standard deviation of the blades' lengths over their mean.
fn variation(tree: &Tree) -> Option<f64> {
    let average = mean(tree.sites.iter().map(|site| site.scale))?;
    let square = mean(tree.sites.iter().map(|site| (site.scale - average) * (site.scale - average)))?;
    Some(square.sqrt() / average)
}

fn segment(tree: &Tree, number: Option<u32>) -> Option<&Segment> {
    number.map(|number| &tree.skeleton.segments[number as usize])
}

/// Diameter at breast height, metres.
fn trunk_diameter(tree: &Tree) -> Option<f64> {
    let crossing = |s: &&Segment| s.axis == 0 && s.start.y <= BREAST && s.end.y > BREAST;
    tree.skeleton.segments.iter().find(crossing).map(|segment| segment.radius * 2.0)
}

/// The shoots of the last year, by axis.
fn current_shoots(tree: &Tree) -> BTreeMap<u32, Shoot> {
    let mut shoots: BTreeMap<u32, Shoot> = BTreeMap::new();
    for segment in tree.skeleton.segments.iter().filter(|segment| segment.birth == tree.youngest) {
        let shoot = shoots.entry(segment.axis).or_default();
        shoot.length += segment.length();
        shoot.segments += 1;
        shoot.order = segment.order;
    }
    for site in &tree.sites {
        if let Some(axis) = segment(tree, site.segment).map(|segment| segment.axis) {
            shoots.entry(axis).or_default().leaves += 1;
        }
    }
    shoots
}

/// Leaves at one height of a long shoot: 2 where they are opposite, 1 where they alternate.
fn leaves_a_node(tree: &Tree, shoots: &BTreeMap<u32, Shoot>) -> Option<f64> {
    let mut nodes: BTreeMap<u32, u32> = BTreeMap::new();
    for number in tree.sites.iter().filter_map(|site| site.segment) {
        let axis = tree.skeleton.segments[number as usize].axis;
        if shoots.get(&axis).is_some_and(|shoot| shoot.length >= SHORT_SHOOT) {
            *nodes.entry(number).or_default() += 1;
        }
    }
    mean(nodes.values().map(|&count| f64::from(count)))
}

/// Orders of branching down to the last axis that ever made a long shoot, the trunk being 1.
fn orders(tree: &Tree) -> u32 {
    let mut shoots: BTreeMap<(u32, u32), (f64, u32)> = BTreeMap::new();
    for segment in &tree.skeleton.segments {
        let shoot = shoots.entry((segment.axis, segment.birth)).or_default();
        *shoot = (shoot.0 + segment.length(), segment.order + 1);
    }
    shoots.values().filter(|shoot| shoot.0 >= LONG_SHOOT).map(|shoot| shoot.1).max().unwrap_or(0)
}

/// Mean angle at which limbs leave the trunk, degrees.
fn limb_angle(tree: &Tree) -> Option<f64> {
    let segments = &tree.skeleton.segments;
    let mut reach: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for limb in segments.iter().filter(|segment| segment.order == 1) {
        let angle = segment(tree, limb.parent).map_or(0.0, |parent| parent.direction().dot(&limb.direction()));
        let axis = reach.entry(limb.axis).or_insert((0.0, acos(angle.clamp(-1.0, 1.0)).to_degrees()));
        axis.0 += limb.length();
    }
    mean(reach.values().filter(|limb| limb.0 >= LIMB * tree.height).map(|limb| limb.1))
}

/// Segments that carry no other.
fn tips(tree: &Tree) -> impl Iterator<Item = &Segment> {
    let mut carries = vec![false; tree.skeleton.segments.len()];
    tree.skeleton
        .segments
        .iter()
        .filter_map(|segment| segment.parent)
        .for_each(|parent| carries[parent as usize] = true);
    tree.skeleton.segments.iter().zip(carries).filter(|(_, carries)| !carries).map(|(segment, _)| segment)
}
