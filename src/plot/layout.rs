//! Where everything stands: margins, the panels' areas, their axes. What is drawn there is told by `axes`, `data` and
//! `legend`.

use super::clip::Area;
use super::legend;
use super::mapping::Mapping;
use super::palette::{INK, nth};
use super::primitive::{Anchor, Drawing, Primitive, Text};
use super::stack::Stack;
use super::ticks::{Room, Ticks, choose};
use super::words::{cleaned, cut, room};
use super::{Axis, Panel, Plot, SIDES, Scale, axes, data, dates, guides, range};

/// The sizes of a chart, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    /// Of captions and legends.
    pub(super) letter: f64,
    /// Of numbers at ticks and of words at guides.
    pub(super) small: f64,
    /// Width of axes and grid, whole.
    pub(super) hair: f64,
    /// Width of a series' line.
    pub(super) line: f64,
    /// Reach of a mark.
    pub(super) mark: f64,
}

impl Sizes {
    fn new(plot: &Plot, width: f64, height: f64) -> Self {
        let usual = (width * height).sqrt() / 54.0;
        let asked = plot.letters.filter(|size| size.is_finite()).unwrap_or(usual.clamp(10.0, 40.0));
        let letter = asked.clamp(6.0, 64.0);
        let hair = (letter / 20.0).round().max(1.0);
        Self { letter, small: letter * 0.92, hair, line: letter * 0.125, mark: letter * 0.3 }
    }
}

/// How a series is told from others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) colour: [u8; 3],
    /// In line widths.
    pub(super) dashes: Option<[f64; 2]>,
}

/// A panel with its place.
pub(super) struct Placed<'a> {
    pub(super) panel: &'a Panel,
    pub(super) sizes: Sizes,
    pub(super) area: Area,
    pub(super) x: Mapping,
    pub(super) y: Mapping,
    pub(super) stack: Stack,
    pub(super) x_ticks: Ticks,
    pub(super) y_ticks: Ticks,
    /// Whether the lower axis has its numbers here, or farther down.
    pub(super) is_numbered: bool,
    /// Of each series.
    pub(super) looks: Vec<Look>,
}

impl Placed<'_> {
    /// The pixel column of a value.
    pub(super) fn column(&self, value: f64) -> Option<f64> {
        Some(settled(self.area.left + self.x.share(value)? * self.area.width()))
    }

    /// The pixel row of a value.
    pub(super) fn row(&self, value: f64) -> Option<f64> {
        Some(settled(self.area.bottom - self.y.share(value)? * self.area.height()))
    }
}

/// A place to a thousandth of a pixel: sums of shares that miss 1 by their rounding still end at the edge.
fn settled(place: f64) -> f64 {
    (place * 1024.0).round() / 1024.0
}

/// Lays out a chart.
pub(super) fn lay_out(plot: &Plot) -> Drawing {
    let (width, height) =
        (plot.width.clamp(*SIDES.start(), *SIDES.end()), plot.height.clamp(*SIDES.start(), *SIDES.end()));
    let sizes = Sizes::new(plot, f64::from(width), f64::from(height));
    let title = cleaned(&plot.title);
    let mut items = vec![];
    if !title.is_empty() {
        items.push(heading(&title, f64::from(width), sizes));
    }
    let noted = notes(plot, sizes, [f64::from(width), f64::from(height)], &mut items);
    let mut placed = place_rows(plot, sizes, f64::from(height) - noted, !title.is_empty());
    place_columns(&mut placed, sizes, f64::from(width));
    for panel in &placed {
        axes::draw(panel, &mut items);
        guides::draw(panel, &mut items);
        data::draw_areas(panel, &mut items);
        axes::draw_lines(panel, &mut items);
        data::draw_lines(panel, &mut items);
        legend::draw(panel, f64::from(width), &mut items);
    }
    Drawing { width, height, title, description: description(plot), items }
}

/// How much wider than plain letters bold ones may be.
const BOLDNESS: f64 = 1.1;

fn heading(title: &str, width: f64, sizes: Sizes) -> Primitive {
    let (size, edge) = (sizes.letter * 1.2, sizes.letter);
    let text = cut(title, size, (width - 2.0 * edge) / BOLDNESS);
    Primitive::Text(Text { is_bold: true, ..Text::plain([edge, sizes.letter * 1.9], text, size, Anchor::Start, INK) })
}

/// Height of a line of the notes, in small letters.
const NOTE_LINE: f64 = 1.35;

/// Writes the notes at the foot of the chart; gives the height that they take, at most two fifths of it.
fn notes(plot: &Plot, sizes: Sizes, [width, height]: [f64; 2], items: &mut Vec<Primitive>) -> f64 {
    let line = sizes.small * NOTE_LINE;
    let most = (height * 0.4 / line) as usize;
    let lines: Vec<String> = plot.notes.iter().map(|note| cleaned(note)).filter(|note| !note.is_empty()).collect();
    let shown = lines.iter().take(most);
    let taken = shown.len() as f64 * line + if shown.len() > 0 { sizes.small } else { 0.0 };
    for (number, note) in shown.enumerate() {
        let base = height - taken + line * (number as f64 + 0.75);
        let text = cut(note, sizes.small, width - 2.0 * sizes.letter);
        items.push(Primitive::Text(Text::plain([sizes.letter, base], text, sizes.small, Anchor::Start, INK)));
    }
    taken
}

fn description(plot: &Plot) -> String {
    let given = cleaned(&plot.description);
    if !given.is_empty() {
        return given;
    }
    let panel = |panel: &Panel| {
        let names: Vec<String> = panel.series.iter().map(|series| cleaned(&series.name)).collect();
        format!("{} against {}: {}.", caption(&panel.y), caption(&panel.x), names.join(", "))
    };
    plot.panels.iter().map(panel).collect::<Vec<_>>().join(" ")
}

/// The quantity with its unit.
pub(super) fn caption(axis: &Axis) -> String {
    let (label, unit) = (cleaned(&axis.label), cleaned(&axis.unit));
    match (label.is_empty(), unit.is_empty()) {
        (_, true) => label,
        (true, false) => unit,
        (false, false) => format!("{label} ({unit})"),
    }
}

/// The caption of a lower axis; one of dates tells its years.
pub(super) fn lower_caption(axis: &Axis, range: [f64; 2]) -> String {
    let Scale::Dates { origin } = axis.scale else { return caption(axis) };
    match (dates::years(origin, range), cleaned(&axis.label)) {
        (Some(years), label) if label.is_empty() => years,
        (Some(years), label) => format!("{label} ({years})"),
        (None, _) => caption(axis),
    }
}

/// The panels with their rows and all that depends on the height alone; their columns are still 0.
fn place_rows(plot: &Plot, sizes: Sizes, height: f64, has_title: bool) -> Vec<Placed<'_>> {
    let mut placed = vec![];
    for sharing in plot.panels.chunk_by(|one, next| one.x == next.x) {
        let x = Mapping { scale: sharing[0].x.scale, range: range::shared(sharing) };
        for (at, panel) in sharing.iter().enumerate() {
            placed.push(unplaced(panel, sizes, x, at + 1 == sharing.len()));
        }
    }
    let letter = sizes.letter;
    let mut top = letter * if has_title { 2.4 } else { 0.7 };
    let taken: f64 = placed.iter().map(|panel| above(panel) + below(panel)).sum();
    let free = (height - top - letter * 0.7 - taken).max(4.0 * placed.len() as f64);
    let weights: Vec<f64> = placed.iter().map(|panel| weight(panel.panel)).collect();
    let total: f64 = weights.iter().sum();
    for (panel, weight) in placed.iter_mut().zip(weights) {
        top += above(panel);
        panel.area.top = top.round();
        panel.area.bottom = (top + free * weight / total).round().max(panel.area.top + 2.0);
        top = panel.area.bottom + below(panel);
        let extent = |_: &str| sizes.small * 0.8;
        let room = Room { length: panel.area.height(), extent: &extent, gap: sizes.small, most: 6 };
        panel.y_ticks = choose(&panel.y, &room);
    }
    placed
}

fn unplaced(panel: &Panel, sizes: Sizes, x: Mapping, is_numbered: bool) -> Placed<'_> {
    let stack = Stack::new(panel, &x);
    let tops: Vec<f64> = if stack.at.is_empty() { vec![] } else { stack.edges.iter().flatten().copied().collect() };
    let y = Mapping { scale: panel.y.scale, range: range::upright(panel, &tops) };
    let (x_ticks, y_ticks) = (Ticks::default(), Ticks::default());
    let area = Area { left: 0.0, top: 0.0, right: 0.0, bottom: 0.0 };
    Placed { panel, sizes, area, x, y, stack, x_ticks, y_ticks, is_numbered, looks: looks(panel) }
}

fn looks(panel: &Panel) -> Vec<Look> {
    let mut uncoloured = 0;
    let look = |series: &super::Series| {
        let (colour, dashes) = match series.colour {
            Some(colour) => (colour, None),
            None => {
                uncoloured += 1;
                nth(uncoloured - 1)
            }
        };
        Look { colour, dashes }
    };
    panel.series.iter().map(look).collect()
}

fn weight(panel: &Panel) -> f64 {
    if panel.share.is_finite() && panel.share > 0.0 { panel.share.clamp(1.0e-3, 1.0e3) } else { 1.0 }
}

fn above(placed: &Placed) -> f64 {
    let has_crosses = placed.panel.series.iter().any(|series| !series.diverged.is_empty());
    let crosses = if has_crosses { placed.sizes.mark } else { 0.0 };
    crosses + placed.sizes.letter * if caption(&placed.panel.y).is_empty() { 0.6 } else { 1.7 }
}

fn below(placed: &Placed) -> f64 {
    if !placed.is_numbered {
        return placed.sizes.letter * 0.5;
    }
    let has_caption = !lower_caption(&placed.panel.x, placed.x.range).is_empty();
    placed.sizes.letter * if has_caption { 3.3 } else { 1.9 }
}

/// The columns: at the left room for the widest number, at the right for the widest legend.
fn place_columns(placed: &mut [Placed], sizes: Sizes, width: f64) {
    let labels = placed.iter().flat_map(|panel| &panel.y_ticks.major);
    let widest = labels.map(|tick| room(&tick.label, sizes.small)).fold(0.0, f64::max);
    let mut left = (widest.min(width * 0.3) + sizes.letter * 1.6).round();
    let legend = placed.iter().map(|panel| legend::width(panel, width)).fold(0.0, f64::max);
    let mut right = (width - legend - sizes.letter * 1.6).round().max(left + 2.0);
    choose_columns(placed, sizes, [left, right]);
    // Numbers at the ends may reach over the chart's edges: then once more with less.
    let [over_left, over_right] = overhang(placed, sizes, width);
    if over_left > 0.0 || over_right > 0.0 {
        left = (left + over_left.min(width / 4.0)).ceil();
        right = (right - over_right.min(width / 4.0)).floor().max(left + 2.0);
        choose_columns(placed, sizes, [left, right]);
    }
}

fn choose_columns(placed: &mut [Placed], sizes: Sizes, [left, right]: [f64; 2]) {
    for panel in placed {
        (panel.area.left, panel.area.right) = (left, right);
        let extent = |label: &str| room(label, sizes.small);
        let room = Room { length: panel.area.width(), extent: &extent, gap: sizes.small * 1.2, most: 10 };
        panel.x_ticks = choose(&panel.x, &room);
    }
}

/// How far numbers at the lower axes reach beyond the left and right edges of the chart, which keep half a letter free.
fn overhang(placed: &[Placed], sizes: Sizes, width: f64) -> [f64; 2] {
    let (mut left, mut right) = (0.0f64, 0.0f64);
    for panel in placed.iter().filter(|panel| panel.is_numbered) {
        for tick in &panel.x_ticks.major {
            let (Some(column), half) = (panel.column(tick.label_at), room(&tick.label, sizes.small) / 2.0) else {
                continue;
            };
            left = left.max(sizes.letter * 0.5 - (column - half));
            right = right.max(column + half + sizes.letter * 0.5 - width);
        }
    }
    [left, right]
}
