//! The part that touches disk, clock, threads and signals.

pub mod files;
pub mod frame_list;
pub mod manifest;
pub mod progress;
pub mod signals;
pub mod verify;
