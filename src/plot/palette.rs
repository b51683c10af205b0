//! Colours that the common kinds of colour blindness tell apart.

/// The palette of Okabe and Ito, "Color Universal Design" (2008), without its yellow, which is lost on white; the darkest
/// and most distinct first. sRGB.
pub const PALETTE: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [0, 0, 0]];

/// Paper.
pub(super) const PAPER: [u8; 3] = [255, 255, 255];
/// Letters.
pub(super) const INK: [u8; 3] = [38, 38, 38];
/// Axes.
pub(super) const FRAME: [u8; 3] = [96, 96, 96];
/// Lines across the panel at the ticks.
pub(super) const GRID: [u8; 3] = [226, 226, 226];
/// Guides and their letters.
pub(super) const GUIDE: [u8; 3] = [112, 112, 112];
/// Bands.
pub(super) const BAND: [u8; 3] = [232, 232, 232];

/// The colour and the dashes (in line widths; none: unbroken) of the `nth` series without a colour of its own: when the
/// colours are used up, they begin again with other dashes.
pub(super) fn nth(nth: usize) -> ([u8; 3], Option<[f64; 2]>) {
    const DASHES: [Option<[f64; 2]>; 3] = [None, Some([4.0, 2.0]), Some([1.5, 1.5])];
    (PALETTE[nth % PALETTE.len()], DASHES[nth / PALETTE.len() % DASHES.len()])
}

/// A colour a share (0..1) of the way to black.
pub(super) fn darkened(colour: [u8; 3], share: f64) -> [u8; 3] {
    colour.map(|code| (f64::from(code) * (1.0 - share) + 0.5) as u8)
}
