//! Line charts: shares, temperatures and errors as pictures and as SVG.
//!
//! A [`Plot`] is plain data: panels one below another, each with axes, series, guides and bands. [`svg`] and [`picture`]
//! write the same list of primitives, which one layout makes, so that a point stands at the same pixel in both. Letters in
//! a picture are strokes of a small font of our own, since no font file is at hand on every machine.
//!
//! ```
//! use leafseason::base::calendar::Date;
//! use leafseason::plot::{Axis, Panel, Plot, Scale, Series, Style};
//!
//! let origin = Date::new(2017, 8, 15).unwrap();
//! let time = Axis { scale: Scale::Dates { origin }, ..Axis::default() };
//! let shares = Panel {
//!     x: time.clone(),
//!     y: Axis { label: "share of leaves".into(), unit: "%".into(), range: Some([0.0, 100.0]), ..Axis::default() },
//!     share: 2.0,
//!     series: vec![
//!         Series::new("green", Style::Area, vec![[0.0, 100.0], [60.0, 20.0]]).coloured([70, 120, 50]),
//!         Series::new("red", Style::Area, vec![[0.0, 0.0], [60.0, 80.0]]).coloured([190, 50, 40]),
//!     ],
//!     ..Panel::default()
//! };
//! let plot = Plot { title: "Red maple, 2017".into(), panels: vec![shares], ..Plot::default() };
//! assert!(leafseason::plot::svg(&plot).starts_with("<svg"));
//! assert_eq!(leafseason::plot::picture(&plot).width, plot.width);
//! ```

mod axes;
mod clip;
mod data;
mod dates;
mod guides;
mod label;
mod layout;
mod legend;
mod lettering;
mod letters;
mod mapping;
mod marks;
mod palette;
mod primitive;
mod range;
mod raster;
mod stack;
mod svg;
#[cfg(test)]
mod tests;
mod ticks;
mod words;

pub use label::label;
pub use palette::PALETTE;

use crate::base::calendar::Date;
use crate::base::picture::Picture;

/// The sides that a plot may have, in pixels; others are brought to the nearest.
pub const SIDES: std::ops::RangeInclusive<u32> = 64..=4096;

/// A chart: panels one below another.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Width in pixels, within [`SIDES`].
    pub width: u32,
    /// Height in pixels, within [`SIDES`].
    pub height: u32,
    /// What stands above; may be empty.
    pub title: String,
    /// A sentence for those who cannot see the chart (SVG's `desc`); empty: made from the series' names.
    pub description: String,
    /// From the top. Neighbours with equal `x` share one axis: one range, one row of numbers.
    pub panels: Vec<Panel>,
    /// Size of the letters in pixels (6 to 64); `None`: after the size of the chart.
    pub letters: Option<f64>,
    /// Lines of text below the panels: what is not in the chart, and why.
    pub notes: Vec<String>,
}

impl Default for Plot {
    fn default() -> Self {
        Self {
            width: 960,
            height: 640,
            title: String::new(),
            description: String::new(),
            panels: vec![],
            letters: None,
            notes: vec![],
        }
    }
}

/// One pair of axes and what is drawn over them.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// The axis below.
    pub x: Axis,
    /// The axis at the left.
    pub y: Axis,
    /// Height in relation to the other panels', above 0.
    pub share: f64,
    /// What is drawn, the later over the earlier, lines over areas; areas are stacked from the first upwards.
    pub series: Vec<Series>,
    /// Lines to compare with, below the series.
    pub guides: Vec<Guide>,
    /// Grey ranges, below everything.
    pub bands: Vec<Band>,
    /// Where the series are named.
    pub legend: Legend,
}

impl Default for Panel {
    fn default() -> Self {
        Self {
            x: Axis::default(),
            y: Axis::default(),
            share: 1.0,
            series: vec![],
            guides: vec![],
            bands: vec![],
            legend: Legend::Right,
        }
    }
}

/// An axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// The quantity: `temperature`; may be empty.
    pub label: String,
    /// Its unit, written in parentheses: `°C`; may be empty.
    pub unit: String,
    /// Both ends; `None`, or ends that make no range: what the data need.
    pub range: Option<[f64; 2]>,
    /// How values become lengths.
    pub scale: Scale,
}

/// How values become lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Scale {
    /// In proportion.
    #[default]
    Linear,
    /// Their logarithms in proportion; values that are not positive are left out.
    Log,
    /// Days in proportion, written as months or days.
    Dates {
        /// The day whose beginning (00:00) is the value 0.
        origin: Date,
    },
}

/// A row of points with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// For the legend.
    pub name: String,
    /// sRGB; `None`: the next of [`PALETTE`].
    pub colour: Option<[u8; 3]>,
    /// Lines, areas or marks.
    pub style: Style,
    /// `[x, y]`. One that cannot be drawn (not finite, or not positive on a logarithmic axis) breaks the line.
    pub points: Vec<[f64; 2]>,
    /// The `x` of runs that diverged: crosses at the upper edge.
    pub diverged: Vec<f64>,
}

impl Series {
    /// A series in the next colour of the palette.
    #[must_use]
    pub fn new(name: impl Into<String>, style: Style, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), colour: None, style, points, diverged: vec![] }
    }

    /// The same in this colour (sRGB).
    #[must_use]
    pub fn coloured(self, colour: [u8; 3]) -> Self {
        Self { colour: Some(colour), ..self }
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line.
    Line,
    /// An area on top of the areas of the earlier series. Between its points the height is interpolated, outside them it
    /// is 0; points that cannot be drawn are left out.
    Area,
    /// Marks alone.
    Marks(Mark),
    /// A line with a mark on each point.
    Marked(Mark),
}

/// The form of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A disc.
    Circle,
    /// A square on its side.
    Square,
    /// A square on its corner.
    Diamond,
    /// A triangle that points up.
    Up,
    /// A triangle that points down.
    Down,
    /// An upright cross.
    Plus,
    /// A diagonal cross.
    Cross,
}

impl Mark {
    /// All forms, the most distinct first: the `n`-th for the `n`-th method.
    pub const ALL: [Self; 7] =
        [Self::Circle, Self::Square, Self::Up, Self::Diamond, Self::Down, Self::Plus, Self::Cross];
}

/// A line to compare with.
#[derive(Clone, Debug, PartialEq)]
pub enum Guide {
    /// A straight line on the axes as they are scaled: on two logarithmic axes y = c x^order.
    Slope {
        /// Its slope there.
        order: f64,
        /// A point of it, in the axes' units.
        through: [f64; 2],
        /// Written along it; empty: `slope` and the number.
        label: String,
    },
    /// A level line.
    Level {
        /// Where on the `y` axis.
        y: f64,
        /// Written above it; may be empty.
        label: String,
    },
    /// An upright line.
    Upright {
        /// Where on the `x` axis.
        x: f64,
        /// Written beside it; may be empty.
        label: String,
    },
}

/// A grey range across the panel; an end that is not finite (or not positive on a logarithmic axis) is the panel's edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Which axis `from` and `to` are values of.
    pub along: Along,
    /// One end.
    pub from: f64,
    /// The other.
    pub to: f64,
    /// Written in it where there is room; may be empty.
    pub label: String,
}

/// Which axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// The one below.
    X,
    /// The one at the left.
    Y,
}

/// Where the series are named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legend {
    /// Nowhere.
    Absent,
    /// In a column at the right of the panel, areas from the top of the stack.
    Right,
    /// At the right of the panel, each at the height where its line ends.
    Ends,
}

/// The chart as an SVG document.
#[must_use]
pub fn svg(plot: &Plot) -> String {
    svg::write(&layout::lay_out(plot))
}

/// The chart as a picture, opaque.
#[must_use]
pub fn picture(plot: &Plot) -> Picture {
    raster::draw(&layout::lay_out(plot))
}
