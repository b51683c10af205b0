//! The rows of the stiff and extreme matrix of the deformation, each with the tests that hold it.

use std::fs;
use std::path::Path;

/// Row, what happens to the leaf, and the tests.
const ROWS: &[(&str, &str, &[&str])] = &[
    (
        "D01",
        "stiffest springs, half and nine tenths of the step",
        &["the_stiffest_springs_keep_their_energy_within_its_bound"],
    ),
    (
        "D02",
        "a step ten times too long",
        &["the_step_that_the_program_chooses_is_converged", "unstable_steps_and_limits_are_refused"],
    ),
    ("D03", "the step left to the program", &["the_step_that_the_program_chooses_is_converged"]),
    (
        "D04",
        "softest springs under a force",
        &["the_papers_strain_bound_holds_from_nought_to_none_and_over_eight_decades_of_stiffness"],
    ),
    ("D05", "masses of 1 to 10,000", &["masses_of_a_ratio_of_ten_thousand_take_up_the_impulse"]),
    ("D06", "a black mask", &["black_and_checkered_masks_are_no_trouble"]),
    ("D07", "a white mask", &["a_white_mask_stays_flat_and_a_wholly_held_leaf_too"]),
    ("D08", "greys 0, 1 and 255", &["greys_have_the_papers_masses", "black_and_checkered_masks_are_no_trouble"]),
    ("D09", "masks of other kinds", &["a_mask_is_read_between_its_pixels", "a_mask_of_any_size_bends_alike"]),
    (
        "D10",
        "no stretch at all",
        &["the_papers_strain_bound_holds_from_nought_to_none_and_over_eight_decades_of_stiffness"],
    ),
    (
        "D11",
        "bounds from a millionth to none",
        &["the_papers_strain_bound_holds_from_nought_to_none_and_over_eight_decades_of_stiffness"],
    ),
    ("D12", "a negative bound", &["settings_out_of_range_are_refused_by_their_key"]),
    ("D14", "no force, no dryness", &["no_dryness_and_no_force_give_the_input_bits", "no_force_gives_the_input_bits"]),
    ("D15", "steps of nought, less, or without end", &["settings_out_of_range_are_refused_by_their_key"]),
    (
        "D16",
        "no steps, ten million steps",
        &["no_dryness_and_no_force_give_the_input_bits", "ten_million_steps_stay_finite_and_within_the_bound"],
    ),
    ("D17", "a blade as thin as a ten-thousandth", &["thickness_over_three_decades"]),
    ("D18", "a blade as thick as a fifth", &["thickness_over_three_decades"]),
    ("D19", "overcurled", &["an_overcurled_leaf_is_finite_or_refused_and_told_of"]),
    ("D21", "a saddle", &["a_saddle_curvature_gives_a_symmetric_shape", "a_flat_start_that_wants_to_buckle_is_left"]),
    ("D23", "nothing holds", &["a_free_leaf_keeps_its_place", "a_moved_blade_comes_back"]),
    ("D24", "everything held", &["a_white_mask_stays_flat_and_a_wholly_held_leaf_too"]),
    ("D25", "degenerate triangles", &["degenerate_triangles_are_named"]),
    ("D27", "no triangle, one, two", &["smallest_meshes_are_defined_and_none_is_an_error"]),
    ("D28", "100,000 vertices", &["a_hundred_thousand_vertices_settle", "memory_is_refused_before_it_is_taken"]),
    ("D29", "a millionth and a million times the size", &["size_does_not_matter"]),
    ("D31", "an indefinite Hessian", &["an_indefinite_matrix_is_told", "a_flat_start_that_wants_to_buckle_is_left"]),
    (
        "D32",
        "implicit and position-based integrators",
        &["all_ways_lead_to_the_same_shape_and_longer_ones_nearer", "stiff_sheets_do_not_shake_the_implicit_ways"],
    ),
    ("D33", "a million undamped steps", &["a_million_undamped_steps_do_not_drift"]),
    ("D34", "a turning leaf", &["a_turning_leaf_keeps_its_angular_momentum_and_hardly_stretches"]),
];

/// The text of all sources and tests.
fn text(folder: &Path) -> String {
    let mut entries: Vec<_> =
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    entries.sort();
    let one = |path: &std::path::PathBuf| match path.extension() {
        _ if path.is_dir() => text(path),
        Some(extension) if extension == "rs" => fs::read_to_string(path).expect("a text"),
        _ => String::new(),
    };
    entries.iter().map(one).collect()
}

#[test]
fn every_row_has_its_tests() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let all = text(&root.join("src")) + &text(&root.join("tests"));
    for (row, what, tests) in ROWS {
        assert!(!tests.is_empty(), "{row}");
        for test in *tests {
            assert!(all.contains(&format!("fn {test}()")), "{row}, {what}: there is no test {test}");
        }
    }
}
