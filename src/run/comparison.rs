//! Whether two pictures can be compared in the memory that there is.

use super::memory;
use crate::base::diagnostic::{Diagnostic, Fault};
use crate::base::picture::Picture;

/// Memory for each pixel of FLIP's planes, bytes (measured: 98).
const PIXEL_BYTES: f64 = 105.0;

/// Refuses pictures of this size when their comparison would not fit into memory.
///
/// # Errors
/// More than there is.
pub fn allow(picture: &Picture) -> Result<(), Diagnostic> {
    let wanted = f64::from(picture.width) * f64::from(picture.height) * PIXEL_BYTES;
    if wanted <= memory::available(1) && memory::is_granted(wanted) {
        return Ok(());
    }
    let what = format!("to compare these pictures takes {:.0} MB of memory, more than there is", wanted / 1e6);
    Err(Diagnostic::error(Fault::Limit, what, "compare parts of them, or run it where more memory is free"))
}
