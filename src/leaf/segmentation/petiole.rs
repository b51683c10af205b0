//! The petiole: the long thin part of a leaf that keeps its width, where the tip of a lobe or a tooth runs to a point. It is
//! what an opening takes away; its centre line and widths come from how far each of its cells lies from the blade.

use crate::base::vector::DVec2;
use crate::leaf::grid::{Grid, Parts};
use crate::leaf::trace::symmetry::Symmetry;

/// Radius of the opening, share of the square root of the leaf's area.
const RADIUS: f64 = 0.035;
/// A part is long from this many radii on.
const LONG: f64 = 1.5;
/// Mean width of a petiole's outer half, at least these shares of its inner half's: what may be one, and what is one wherever
/// it hangs.
const PARALLEL: f64 = 0.55;
const EVEN: f64 = 0.85;
/// Near the blade a petiole begins where it is at most this many times as wide as farther out.
const FLARE: f64 = 1.5;
/// A strand is the end of a petiole folded over the blade, not its beginning, if the blade is less symmetric about the line
/// from it than this share of the best, unless it is longer than so many radii.
const SYMMETRIC: f64 = 0.93;
const FAR: f64 = 4.0;
/// A stump is at least so many radii of its opening long, and the blade nearly as symmetric about it as about its best axis.
const STUMP: f64 = 0.5;
const BALANCED: f64 = 0.975;
/// Steps between two points of the centre line, cells.
const STEP: usize = 4;

/// The petiole that was cut from a blade.
#[derive(Clone, Debug, PartialEq)]
pub struct Petiole {
    /// The centre line from the joint outward, a point every few pixels; pixels.
    pub line: Vec<DVec2>,
    /// Width at each point of the line, pixels.
    pub widths: Vec<f64>,
}

impl Petiole {
    /// Length of the centre line, pixels.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.line.windows(2).map(|w| (w[1] - w[0]).norm()).sum()
    }
}

/// A leaf without its petiole.
pub struct Cut {
    /// The blade.
    pub blade: Grid<bool>,
    /// The petiole, when there is one.
    pub petiole: Option<Petiole>,
    /// Where the blade hangs on it: also known where only a stump is left.
    pub joint: Option<DVec2>,
}

/// Cuts the petiole off. `wide` is the leaf with all that hangs on it and is not paper: it is asked when the leaf itself has
/// no long petiole.
pub fn cut(leaf: &Grid<bool>, wide: &Grid<bool>) -> Cut {
    let radius = (RADIUS * (leaf.area() as f64).sqrt()).max(2.0);
    let balance = Balance::of(leaf);
    let long = |whole| strands(whole, radius).into_iter().filter(|s| s.is_long(radius)).collect::<Vec<Strand>>();
    let is_petiole = |s: &Strand| !balance.is_end(s, radius) && balance.is_base(s);
    let own = long(leaf);
    let mut faint = Vec::new();
    if !own.iter().any(|s| s.length() > FAR * radius && is_petiole(s)) {
        faint = long(wide);
        // the lines of ruled paper come in numbers
        faint.truncate(if faint.len() > 1 { 0 } else { 1 });
    }
    let all: Vec<Strand> = own.into_iter().chain(faint).collect();
    let longest = (0..all.len())
        .filter(|&i| is_petiole(&all[i]))
        .max_by(|&i, &j| all[i].length().total_cmp(&all[j].length()).then(j.cmp(&i)));
    let mut blade = leaf.clone();
    for (_, strand) in all.iter().enumerate().filter(|(i, s)| Some(*i) == longest || balance.is_end(s, radius)) {
        strand.beyond_flare().for_each(|cell| blade.cells[cell] = false);
    }
    let petiole = longest.map(|i| all[i].petiole());
    let joint = petiole.as_ref().map(|p| p.line[0]).or_else(|| balance.stump(leaf, radius * 0.5));
    Cut { blade: blade.largest_part(), petiole, joint }
}

/// Judges strands by how symmetric the blade is about the line from where they hang.
struct Balance<'a> {
    symmetry: Symmetry<'a>,
    /// Symmetry about the best axis.
    best: f64,
}

impl<'a> Balance<'a> {
    fn of(leaf: &'a Grid<bool>) -> Self {
        let symmetry = Symmetry::of(leaf);
        let best = symmetry.along(symmetry.best()).max(1e-9);
        Self { symmetry, best }
    }

    /// Symmetry about the line from a strand, share of the best.
    fn about(&self, strand: &Strand) -> f64 {
        self.symmetry.along(self.symmetry.heading(strand.line[0])) / self.best
    }

    /// Whether a strand is the far end of a petiole folded over the blade.
    fn is_end(&self, strand: &Strand, radius: f64) -> bool {
        strand.length() < FAR * radius && self.about(strand) < SYMMETRIC
    }

    /// Whether a strand hangs at the base of the blade, or can be no tip.
    fn is_base(&self, strand: &Strand) -> bool {
        strand.is_even() || self.symmetry.is_base(self.symmetry.heading(strand.line[0]))
    }

    /// Where a stump stands out: a thin part, however short, at the base of the axis of symmetry.
    fn stump(&self, leaf: &Grid<bool>, radius: f64) -> Option<DVec2> {
        let at_base = |s: &Strand| self.symmetry.is_base(self.symmetry.heading(s.line[0]));
        let stands_out = |s: &Strand| s.length() > STUMP * radius && at_base(s);
        let found = strands(leaf, radius).into_iter().filter(stands_out).map(|s| (self.about(&s), s.line[0]));
        found.filter(|f| f.0 > BALANCED).max_by(|a, b| a.0.total_cmp(&b.0)).map(|f| f.1)
    }
}

/// A thin part: its cells in the order of their steps from the core.
struct Strand {
    cells: Vec<usize>,
    /// Steps from the core, from 0.
    levels: Vec<usize>,
    /// Middles of the bands of `STEP` levels.
    line: Vec<DVec2>,
    /// Cells of each band for each pixel of the line's way through it.
    widths: Vec<f64>,
}

/// The parts that a disc of this radius cannot get into, where they hang on the rest.
fn strands(whole: &Grid<bool>, radius: f64) -> Vec<Strand> {
    let core = whole.opened(radius).largest_part();
    let thin = whole.joined(&core, |whole, core| whole && !core);
    let parts = Parts::of(&thin);
    let mut seeds: Vec<Vec<usize>> = vec![Vec::new(); parts.areas.len()];
    for (cell, part) in parts.cells().filter(|(cell, _)| core.neighbours(*cell).any(|n| core.cells[n])) {
        seeds[part as usize].push(cell);
    }
    let mut seen = thin.map(|thin| !thin);
    seeds.into_iter().filter(|seeds| !seeds.is_empty()).map(|seeds| Strand::grown(seeds, &mut seen)).collect()
}

impl Strand {
    fn grown(seeds: Vec<usize>, seen: &mut Grid<bool>) -> Self {
        let mut levels = vec![0; seeds.len()];
        let mut cells = seeds;
        cells.iter().for_each(|&cell| seen.cells[cell] = true);
        let mut rank = 0;
        while rank < cells.len() {
            for next in seen.neighbours(cells[rank]) {
                if !seen.cells[next] {
                    seen.cells[next] = true;
                    cells.push(next);
                    levels.push(levels[rank] + 1);
                }
            }
            rank += 1;
        }
        let (line, widths) = profile(&cells, &levels, seen.width);
        Self { cells, levels, line, widths }
    }

    fn length(&self) -> f64 {
        self.line.windows(2).map(|w| (w[1] - w[0]).norm()).sum()
    }

    /// Mean width of the bands from one share of the length to another.
    fn width(&self, from: f64, to: f64) -> f64 {
        let rank = |share: f64| (share * self.widths.len() as f64) as usize;
        let (from, to) = (rank(from), rank(to).max(rank(from) + 1).min(self.widths.len()));
        let part = &self.widths[from.min(to - 1)..to];
        part.iter().sum::<f64>() / part.len() as f64
    }

    /// Long, and as wide at its end as near the blade.
    fn is_long(&self, radius: f64) -> bool {
        self.length() > LONG * radius && self.width(0.55, 0.9) > PARALLEL * self.width(0.2, 0.55)
    }

    /// Hardly narrower at its end than near the blade, as the tip of a blade never is.
    fn is_even(&self) -> bool {
        self.width(0.55, 0.9) > EVEN * self.width(0.2, 0.55)
    }

    /// The band where the petiole begins: before it lies the flare of the blade.
    fn start(&self) -> usize {
        let usual = self.width(0.25, 0.75);
        self.widths.iter().position(|&w| w < FLARE * usual).unwrap_or(0)
    }

    fn beyond_flare(&self) -> impl Iterator<Item = usize> + '_ {
        let start = self.start() * STEP;
        self.cells.iter().zip(&self.levels).filter(move |(_, level)| **level >= start).map(|(cell, _)| *cell)
    }

    fn petiole(&self) -> Petiole {
        let start = self.start();
        Petiole { line: self.line[start..].to_vec(), widths: self.widths[start..].to_vec() }
    }
}

/// Middles and widths of the bands of a strand.
fn profile(cells: &[usize], levels: &[usize], columns: usize) -> (Vec<DVec2>, Vec<f64>) {
    let bands = levels.last().map_or(0, |last| last / STEP + 1);
    let mut sums = vec![(DVec2::zeros(), 0.0); bands];
    for (&cell, &level) in cells.iter().zip(levels) {
        let sum = &mut sums[level / STEP];
        sum.0 += DVec2::new((cell % columns) as f64 + 0.5, (cell / columns) as f64 + 0.5);
        sum.1 += 1.0;
    }
    let line: Vec<DVec2> = sums.iter().map(|(sum, count)| sum / *count).collect();
    let pace = |band: usize| {
        let (low, high) = (band.saturating_sub(1), (band + 1).min(bands - 1));
        ((line[high] - line[low]).norm() / (high - low).max(1) as f64).max(1.0)
    };
    let widths = (0..bands).map(|band| sums[band].1 / pace(band)).collect();
    (line, widths)
}
