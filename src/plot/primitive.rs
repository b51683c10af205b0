//! What both writers draw: lines, polygons and words at pixels, in the order of drawing.

/// A point in pixels: right and down from the upper left corner of the chart.
pub(super) type Pixel = [f64; 2];

/// A chart that is laid out.
#[derive(Clone, Debug)]
pub(super) struct Drawing {
    pub(super) width: u32,
    pub(super) height: u32,
    /// For those who cannot see it; cleaned of what is no letter.
    pub(super) title: String,
    pub(super) description: String,
    pub(super) items: Vec<Primitive>,
}

/// One thing to draw.
#[derive(Clone, Debug)]
pub(super) enum Primitive {
    Polyline {
        points: Vec<Pixel>,
        pen: Pen,
    },
    Polygon {
        points: Vec<Pixel>,
        fill: [u8; 3],
    },
    Text(Text),
    /// What belongs to one series.
    Group {
        name: String,
        items: Vec<Primitive>,
    },
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen {
    pub(super) colour: [u8; 3],
    /// In pixels.
    pub(super) width: f64,
    /// Lengths of dash and gap in pixels.
    pub(super) dashes: Option<[f64; 2]>,
}

/// A line of letters.
#[derive(Clone, Debug)]
pub(super) struct Text {
    /// On the base line, where `anchor` says.
    pub(super) at: Pixel,
    pub(super) text: String,
    /// In pixels, as fonts count: from the deepest descender to the highest accent, about.
    pub(super) size: f64,
    pub(super) anchor: Anchor,
    /// The direction of reading, of length 1.
    pub(super) direction: [f64; 2],
    pub(super) colour: [u8; 3],
    /// Whether paper is laid around the letters.
    pub(super) halo: bool,
    pub(super) is_bold: bool,
}

/// Which part of a text stands at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Text {
    /// Level and plain.
    pub(super) fn plain(at: Pixel, text: impl Into<String>, size: f64, anchor: Anchor, colour: [u8; 3]) -> Self {
        let text = text.into();
        Self { at, text, size, anchor, direction: [1.0, 0.0], colour, halo: false, is_bold: false }
    }
}

/// The middle of the pixel, or the edge between two, so that a level or upright line of `width` pixels is crisp.
pub(super) fn crisp(at: f64, width: f64) -> f64 {
    if width.round() % 2.0 == 1.0 { at.floor() + 0.5 } else { at.round() }
}
