//! Grows the trees of a scene: each form once, however many trees have it.

use super::preparation::KEPT_BYTES;
use super::{fault, prediction};
use crate::base::diagnostic::Diagnostics;
use crate::base::figures::Figures;
use crate::base::limits::{Limit, Limits, Refusal};
use crate::compose::{Form, Stand};
use crate::scene::{Scene, Standing};
use crate::tree::{self, Tree, TreeError};
use rayon::prelude::*;
use serde_json::Value;
use std::collections::BTreeMap;

/// Forms that are grown at once; fixed, so that what is refused does not depend on the threads.
const AT_ONCE: usize = 4;
/// Memory that a vertex of wood comes to when it is drawn, bytes (measured: 150 to 190).
pub(super) const WOOD_BYTES: f64 = 220.0;
/// Memory that a leaf of a form comes to, bytes: its site.
pub(super) const SITE_BYTES: f64 = 200.0;
/// Memory that a leaf of any tree comes to, bytes: id, states, garment, instance and what the rasteriser sorts (measured:
/// 320 to 400).
pub(super) const LEAF_BYTES: f64 = 450.0;
/// How much larger than the forms that have grown the others may be.
const MARGIN: f64 = 1.2;
/// Figures of the tree stage that are the largest of any tree; other numbers are summed over all trees.
const LARGEST: [&str; 3] = ["age_years", "height_m", "max_order"];

/// A form that is to be grown.
struct Wanted {
    /// Number of the entry of `[[trees]]` that asks for it first.
    entry: usize,
    seed: u64,
    /// Trees that have it.
    trees: usize,
}

/// Grows all forms and gathers the stand.
///
/// # Errors
/// A grove without room, what the rules of a tree or the limits refuse.
pub fn grow(scene: &Scene, limits: &Limits) -> Result<(Stand, Figures), Diagnostics> {
    let standing = scene.standing().map_err(|crowded| -> Diagnostics {
        let table = format!("trees.{}", crowded.entry);
        scene.places.diagnostic(&table, crowded.complaint()).1.into()
    })?;
    let (wanted, trees) = forms(scene, standing);
    let mut forms: Vec<Form> = Vec::new();
    let mut figures: Vec<Figures> = Vec::new();
    // The first tells how large the others will be.
    let (first, others) = wanted.split_at(wanted.len().min(1));
    for batch in std::iter::once(first).chain(others.chunks(AT_ONCE)) {
        let grown: Vec<Result<(Tree, Figures), TreeError>> =
            batch.par_iter().map(|form| tree::grow(&scene.trees[form.entry].tree, form.seed, limits)).collect();
        for (form, grown) in batch.iter().zip(grown) {
            let species = scene.trees[form.entry].species;
            let (tree, of_form) = grown.map_err(|error| fault::tree(&scene.species[species], &error))?;
            forms.push(Form::new(species, tree));
            figures.push(of_form);
        }
        if trees.len() > 1 {
            allow(scene, &wanted, &forms, limits)?;
        }
    }
    let figures = summed(&wanted, &figures);
    Ok((Stand::new(forms, trees).on(scene.ground.map()), figures))
}

/// The forms of the trees, in the order in which trees ask for them, and each tree with its form's number.
fn forms(scene: &Scene, standing: Vec<Standing>) -> (Vec<Wanted>, Vec<(usize, Standing)>) {
    let mut numbers: BTreeMap<(usize, String, u64), usize> = BTreeMap::new();
    let mut wanted: Vec<Wanted> = Vec::new();
    let mut trees = Vec::with_capacity(standing.len());
    for tree in standing {
        let planted = &scene.trees[tree.entry];
        let age = planted.age.as_ref().map_or_else(String::new, Value::to_string);
        let number = *numbers.entry((planted.species, age, tree.seed)).or_insert_with(|| {
            wanted.push(Wanted { entry: tree.entry, seed: tree.seed, trees: 0 });
            wanted.len() - 1
        });
        wanted[number].trees += 1;
        trees.push((number, tree));
    }
    (wanted, trees)
}

/// Holds what has grown, and what the rest will come to if it is like it, against the limits.
fn allow(scene: &Scene, wanted: &[Wanted], forms: &[Form], limits: &Limits) -> Result<(), Diagnostics> {
    let grown = wanted.iter().zip(forms);
    let wood = |form: &Form| form.wood_vertices() as f64 * WOOD_BYTES;
    let (mut leaves, mut bytes, mut trees) = (0.0, 0.0, 0.0);
    for (form, grown) in grown {
        leaves += grown.sites.len() as f64 * form.trees as f64;
        bytes += wood(grown) + grown.sites.len() as f64 * SITE_BYTES;
        trees += form.trees as f64;
    }
    let all = wanted.iter().map(|form| form.trees as f64).sum::<f64>();
    let leaves = (leaves * all / trees.max(1.0)).ceil();
    let fixed: f64 = prediction::drawing(scene, leaves as usize, all as usize, 1).iter().map(|(_, bytes)| bytes).sum();
    let bytes = bytes * wanted.len() as f64 / forms.len().max(1) as f64 + leaves * LEAF_BYTES + fixed;
    // What leaves wear is not known yet, and other forms may be larger: the limit that a refusal names is enough for both.
    let refused = |refusal: Refusal, more: f64| {
        let refusal = Refusal { wanted: (refusal.wanted * MARGIN + more).ceil(), ..refusal };
        fault::refused(&scene.places, "trees", &refusal)
    };
    limits.allow(Limit::Leaves, "trees", leaves).map_err(|refusal| refused(refusal, 0.0))?;
    let worn = prediction::worn_at_most(scene) + prediction::litter_at_most(scene, leaves) + KEPT_BYTES as f64;
    limits.allow(Limit::Memory, "trees", bytes).map_err(|refusal| refused(refusal, worn))
}

/// The figures of all trees.
fn summed(wanted: &[Wanted], figures: &[Figures]) -> Figures {
    let mut sum = Figures::default();
    for (form, one) in wanted.iter().zip(figures) {
        let trees = form.trees as u64;
        sum.items += one.items * trees;
        for (name, value) in &one.values {
            let before = sum.values.remove(name);
            let value =
                if LARGEST.contains(&name.as_str()) { larger(before, value) } else { added(before, value, trees) };
            sum.values.insert(name.clone(), value);
        }
    }
    let trees: usize = wanted.iter().map(|form| form.trees).sum();
    sum.error = figures.iter().find_map(|one| one.error.clone());
    sum.with("trees", trees as u64).with("forms", wanted.len() as u64)
}

fn larger(before: Option<Value>, value: &Value) -> Value {
    match before {
        Some(before) if before.as_f64() >= value.as_f64() => before,
        _ => value.clone(),
    }
}

/// A sum with `count` times a value; whole numbers stay whole, and what is no number is the last one's.
fn added(before: Option<Value>, value: &Value, count: u64) -> Value {
    if let Some(whole) = value.as_u64() {
        return Value::from(before.and_then(|before| before.as_u64()).unwrap_or(0) + whole * count);
    }
    match value.as_f64() {
        Some(number) if count > 1 || before.is_some() => {
            Value::from(before.and_then(|before| before.as_f64()).unwrap_or(0.0) + number * count as f64)
        }
        _ => value.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(trees: &[usize]) -> Vec<Wanted> {
        trees.iter().map(|&trees| Wanted { entry: 0, seed: 1, trees }).collect()
    }

    #[test]
    fn figures_are_of_all_trees_and_one_tree_keeps_its_own() {
        let figures = |leaves: u64, height: f64| {
            Figures::of(leaves).with("leaves", leaves).with("height_m", height).with("crown_projection_m2", 0.1)
        };
        let all = summed(&wanted(&[3, 2]), &[figures(10, 4.0), figures(7, 5.0)]);
        assert_eq!((all.items, &all.values["leaves"]), (44, &Value::from(44)));
        assert_eq!((&all.values["height_m"], &all.values["trees"]), (&Value::from(5.0), &Value::from(5)));
        assert!((all.values["crown_projection_m2"].as_f64().unwrap() - 0.5).abs() < 1e-12);
        let one = summed(&wanted(&[1]), &[figures(10, 4.0)]);
        assert_eq!((one.values["crown_projection_m2"].as_f64(), one.items), (Some(0.1), 10));
    }
}
