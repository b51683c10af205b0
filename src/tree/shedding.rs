//! Shedding while the tree grows: the string is drawn, shoots in the shade are found, and what they were made of is taken out
//! of the string, so that dead wood never branches on and costs nothing.
//!
//! It is done each year. Every other year would make crowns of even and odd ages differ: the leaf area index of a maple then
//! swung by a third from one year to the next.

use super::modules::{Module, Modules};
use super::turtle::Drawing;
use super::{Settings, TreeError, shade, turtle};

/// What sheds; the drawing is kept for its memory.
pub(super) struct Shedding<'a> {
    settings: &'a Settings,
    drawing: Drawing,
}

impl<'a> Shedding<'a> {
    pub fn new(settings: &'a Settings) -> Self {
        Self { settings, drawing: Drawing::default() }
    }

    /// Takes leaves in the shade out of the string, and wood that bears no leaf with everything on it. A string without any
    /// leaf is left as it is: there is nothing to tell light from shade by.
    pub fn shed(&mut self, modules: &mut Modules) -> Result<(), TreeError> {
        let Self { settings, drawing } = self;
        turtle::redraw(drawing, modules, settings, 1.0)?;
        if drawing.shoots.is_empty() {
            return Ok(());
        }
        let lit = shade::lit(&drawing.shoots, &drawing.skeleton, settings.shade);
        let alive = shade::alive(&drawing.skeleton, &drawing.shoots, &lit);
        let mut leaf = 0;
        let mark = |(module, owner): (&Module, &Option<u32>)| {
            let mut kept = owner.is_none_or(|segment| alive[segment as usize]);
            if module.letter == b'L' {
                kept &= lit[leaf];
                leaf += 1;
            }
            kept
        };
        let kept: Vec<bool> = modules.list.iter().zip(&drawing.owners).map(mark).collect();
        modules.retain(&kept);
        Ok(())
    }
}
