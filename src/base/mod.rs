//! What every stage stands on: vectors and portable mathematics, keyed random numbers, meshes and pictures, settings that
//! describe themselves, diagnostics with places, limits and figures. Imports no other folder of the crate.

pub mod blade;
pub mod calendar;
pub mod diagnostic;
pub mod encoding;
pub mod family;
pub mod figures;
pub mod flat_mesh;
pub mod limits;
pub mod maths;
pub mod mesh;
pub mod message;
pub mod noise;
pub mod picture;
pub mod random;
pub mod settings;
pub mod vector;
