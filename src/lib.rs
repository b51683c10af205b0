//! Trees in season, from a scene file to pictures and glTF, with nobody at the keyboard.
//!
//! ```text
//! scene.toml ─read→ Scene ─plan→ Plan ─┬─grow───→ Tree ────────┐
//!                                      ├─assign─→ LeafStates ──┤   cheap: run first, and narrow the Plan
//!                                      ├─fall───→ Fates ───────┤
//!                                      ├─model──→ Blade ───────┤
//!                                      ├─deform─→ Shapes ──────┤
//!                                      └─paint──→ Textures ────┴─compose→ Frame ─┬─raster→ Picture → PNG
//!                                                                                └─export→ glTF
//!                       every stage also returns its figures ───────────────→ Report
//! ```
//!
//! Each stage is a folder with its `Settings`, a `check` and one public function; stages are pure and know only `base`.
//! [`frame::Frame`] is the waist between what is simulated and what is drawn. `run` alone touches disk, clock and threads.
//!
//! The method is that of Tang, Wu and Fan, "Computational Approach to Seasonal Changes of Living Leaves" (2013).

pub mod base;
pub mod cli;
pub mod colour;
pub mod compare;
pub mod compose;
pub mod deform;
pub mod export;
pub mod fall;
pub mod frame;
pub mod leaf;
pub mod plan;
pub mod plot;
pub mod raster;
pub mod report;
pub mod run;
pub mod scene;
pub mod season;
pub mod species;
pub mod study;
pub mod tree;
