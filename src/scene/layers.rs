//! Lays tables over one another: species below, scene on it, `--set` above all. Tables merge key by key; everything else is
//! replaced. Where keys exclude one another, naming one above takes the others away from below.

use serde_json::{Map, Value};

/// Groups of keys of which one is meant: a scene's `time.day` replaces the run of days below it.
const ALTERNATIVES: [(&str, &[&[&str]]); 2] =
    [("time", &[&["day"], &["from", "to", "step"]]), ("tree", &[&["age"], &["height"], &["iterations"]])];

/// Ways to give a blade, and what belongs to the one that was given: another blade takes all of it away.
const BLADES: [&str; 3] = ["outline", "picture", "file"];
const OF_A_BLADE: [&str; 10] =
    ["outline", "teeth", "holes", "petiole", "veins", "joint", "picture", "file", "mask", "texture"];

/// What describes growth: an L-system of the scene's own takes all of it away from the species, whose constants and age
/// belong to other rules.
const GROWTH: [&str; 8] = ["age", "height", "axiom", "rules", "ignored", "constants", "iterations", "angle"];

/// Lays `above` over `below`.
pub fn lay(below: &mut Value, above: Value) {
    if let (Value::Object(below), Value::Object(above)) = (&mut *below, &above) {
        make_room(below, above);
    }
    merge(below, above);
}

/// Merges key by key without taking anything away: both tables mean the same thing.
pub fn merge(below: &mut Value, above: Value) {
    match (below, above) {
        (Value::Object(below), Value::Object(above)) => {
            for (key, value) in above {
                match below.get_mut(&key) {
                    Some(old) => merge(old, value),
                    None => {
                        below.insert(key, value);
                    }
                }
            }
        }
        (below, above) => *below = above,
    }
}

/// Takes from `below` what the keys of `above` exclude.
fn make_room(below: &mut Map<String, Value>, above: &Map<String, Value>) {
    for (table, groups) in ALTERNATIVES {
        let (Some(Value::Object(old)), Some(Value::Object(new))) = (below.get_mut(table), above.get(table)) else {
            continue;
        };
        let named = |group: &&&[&str]| group.iter().any(|key| new.contains_key(*key));
        if groups.iter().any(|group| named(&group)) {
            for key in groups.iter().filter(|group| !named(group)).copied().flatten() {
                old.remove(*key);
            }
        }
    }
    for (name, other) in [("seed", "seeds"), ("seeds", "seed")] {
        if above.contains_key(name) && !above.contains_key(other) {
            below.remove(other);
        }
    }
    if let (Some(Value::Object(old)), Some(Value::Object(new))) = (below.get_mut("leaf"), above.get("leaf"))
        && BLADES.iter().any(|key| new.contains_key(*key))
    {
        old.retain(|key, _| !OF_A_BLADE.contains(&key.as_str()));
    }
    if let (Some(Value::Object(old)), true) = (below.get_mut("tree"), is_whole_tree(above)) {
        old.retain(|key, _| !GROWTH.contains(&key.as_str()));
    }
}

/// Whether a layer has an L-system of its own: an axiom and a list of rules, which is empty when nothing is rewritten.
#[must_use]
pub fn is_whole_tree(layer: &Map<String, Value>) -> bool {
    let tree = |key: &str| layer.get("tree").and_then(|tree| tree.get(key));
    let axiom = tree("axiom").and_then(Value::as_str).is_some_and(|axiom| !axiom.trim().is_empty());
    axiom && tree("rules").is_some_and(Value::is_array)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn laid(mut below: Value, above: Value) -> Value {
        lay(&mut below, above);
        below
    }

    #[test]
    fn tables_merge_and_lists_are_replaced() {
        let below = json!({"season": {"states": {"green": {"half_life": 5.0, "next": ["red", "brown"]}}}});
        let above = json!({"season": {"states": {"green": {"next": ["fallen"]}}}});
        let green = json!({"half_life": 5.0, "next": ["fallen"]});
        assert_eq!(laid(below, above), json!({"season": {"states": {"green": green}}}));
    }

    #[test]
    fn a_day_replaces_a_run_and_a_step_refines_it() {
        let run = json!({"time": {"from": 0.0, "to": 9.0}});
        assert_eq!(laid(run.clone(), json!({"time": {"day": 3.0}})), json!({"time": {"day": 3.0}}));
        let finer = laid(run, json!({"time": {"step": 0.5}}));
        assert_eq!(finer, json!({"time": {"from": 0.0, "to": 9.0, "step": 0.5}}));
    }

    #[test]
    fn a_seed_above_a_sheet_chooses_one_of_it() {
        let sheet = json!({"seed": 1, "seeds": [1, 2, 3]});
        assert_eq!(laid(sheet.clone(), json!({"seed": 2})), json!({"seed": 2}));
        assert_eq!(laid(sheet, json!({"image": {}})), json!({"seed": 1, "seeds": [1, 2, 3], "image": {}}));
        assert_eq!(laid(json!({"seed": 5}), json!({"seeds": [7, 8]})), json!({"seeds": [7, 8]}));
    }

    #[test]
    fn another_blade_takes_the_mask_and_holes_of_the_first_away_but_not_its_mesh() {
        let teeth = json!({"belly": 0.1});
        let traced =
            json!({"leaf": {"outline": [[0.0, 0.0]], "teeth": teeth, "holes": [], "mask": "m.png", "vertices": 300}});
        let scan = json!({"leaf": {"picture": "a.png"}});
        assert_eq!(laid(traced.clone(), scan), json!({"leaf": {"picture": "a.png", "vertices": 300}}));
        let finer = laid(traced, json!({"leaf": {"vertices": 900}}));
        assert_eq!((&finer["leaf"]["mask"], &finer["leaf"]["vertices"]), (&json!("m.png"), &json!(900)));
    }

    #[test]
    fn a_whole_l_system_takes_the_species_growth_away_but_not_its_petioles() {
        let species = json!({"tree": {"age": 30, "axiom": "B", "constants": {"r": 1.0}, "petiole": 60.0}});
        let scene = json!({"tree": {"axiom": "A", "rules": ["A -> F"]}});
        let tree = json!({"axiom": "A", "rules": ["A -> F"], "petiole": 60.0});
        assert_eq!(laid(species, scene), json!({"tree": tree}));
    }
}
