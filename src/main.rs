//! The `leafseason` command.
fn main() {}
