//! The blades that are bent and the ways that are tried on them, each row with a name by which its work can be done alone.

use crate::base::flat_mesh::FlatMesh;
use crate::deform::DeformError;
use crate::deform::integrators::{Method, Run, run};
use crate::deform::shell::Settings;
use crate::study::numbers::shown;
use crate::study::problems::{OVATE_EXTENT, ovate};

/// The drynesses of the eight states.
pub const STATES: [f64; 8] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];
/// The solver's tolerances, extents.
const TOLERANCES: [f64; 7] = [1e-1, 1e-2, 3e-3, 1e-3, 3e-4, 1e-5, 1e-7];
/// Those of a quick study.
const FEW_TOLERANCES: [f64; 5] = [1e-1, 1e-2, 1e-3, 3e-4, 1e-5];
/// A blade and how it dries.
#[derive(Clone, Debug)]
pub struct Problem {
    /// For the table.
    pub name: String,
    /// The blade.
    pub mesh: FlatMesh,
    /// Metres that the integrators' unit of length stands for.
    pub extent: f64,
    /// How it dries.
    pub settings: Settings,
    /// The ways that are tried.
    pub ways: Vec<Way>,
}

/// A way to the shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// The method.
    pub method: Method,
    /// Newton's tolerance, extents.
    pub tolerance: f64,
}

impl Way {
    /// Newton's method to a tolerance, extents.
    pub fn newton(tolerance: f64) -> Self {
        Self { method: Method::Newton, tolerance }
    }

    /// The method's name.
    pub fn name(&self) -> &'static str {
        match self.method {
            Method::Newton => "Newton",
            Method::Implicit { .. } => "implicit Euler",
            Method::Explicit { .. } => "equation (1)",
            Method::PositionBased { .. } => "XPBD",
        }
    }

    /// What the method is set to.
    pub fn setting(&self) -> String {
        match self.method {
            Method::Newton => format!("tolerance {}", shown(self.tolerance)),
            Method::Implicit { steps } | Method::Explicit { steps } | Method::PositionBased { steps } => {
                format!("{steps} steps")
            }
        }
    }

    /// Whether it takes many seconds; a quick study has fewer of them.
    pub fn is_heavy(&self, quick: bool) -> bool {
        let share = if quick { 8 } else { 1 };
        match self.method {
            Method::Explicit { steps } => steps >= 8000 / share,
            Method::PositionBased { steps } => steps >= 800 / share,
            Method::Implicit { steps } => steps >= 128 / share,
            Method::Newton => false,
        }
    }

    /// Runs it.
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(&self, problem: &Problem) -> Result<Run, DeformError> {
        let settings = Settings { tolerance: self.tolerance, ..problem.settings.clone() };
        run(&settings, &problem.mesh, &STATES, 1, self.method)
    }
}

/// The blade on which solvers are measured: a hundred times as long as thick, curled to a tenth of its length.
fn base(rings: u32) -> Problem {
    let settings = Settings { curl: 10.0, thickness: 0.01, ..Settings::default() };
    let mesh = ovate(rings);
    let name = "h/L 0.01, curl 10".to_owned();
    Problem { name, mesh, extent: OVATE_EXTENT, settings, ways: Vec::new() }
}

fn all_ways(quick: bool) -> Vec<Way> {
    let tolerance = Settings::default().tolerance;
    let way = |method| Way { method, tolerance };
    let tolerances: &[f64] = if quick { &FEW_TOLERANCES } else { &TOLERANCES };
    let mut ways: Vec<Way> = tolerances.iter().copied().map(Way::newton).collect();
    let implicit: &[u32] = if quick { &[8, 16] } else { &[4, 8, 16, 32, 64] };
    ways.extend(implicit.iter().map(|&steps| way(Method::Implicit { steps })));
    let explicit: &[u32] = if quick { &[500, 3000] } else { &[500, 2000, 8000, 32_000] };
    ways.extend(explicit.iter().map(|&steps| way(Method::Explicit { steps })));
    let position_based: &[u32] = if quick { &[200] } else { &[200, 800, 3200] };
    ways.extend(position_based.iter().map(|&steps| way(Method::PositionBased { steps })));
    ways
}

/// The ways that are tried on a blade of the user's, the scene's own tolerance among them.
pub fn ways_around(tolerance: f64) -> Vec<Way> {
    let mut ways = all_ways(true);
    if !ways.iter().any(|way| way.method == Method::Newton && way.tolerance.total_cmp(&tolerance).is_eq()) {
        ways.insert(0, Way::newton(tolerance));
    }
    ways
}

/// The problems, the measured one first.
pub fn problems(quick: bool) -> Vec<Problem> {
    let few = || if quick { vec![Way::newton(3e-4)] } else { [1e-2, 3e-4, 1e-7].map(Way::newton).to_vec() };
    let mut problems = vec![Problem { ways: all_ways(quick), ..base(14) }];
    let sizes: &[u32] = if quick { &[26] } else { &[10, 20, 26] };
    for &rings in sizes {
        let mut ways = few();
        ways.extend((!quick).then_some(Way { method: Method::Implicit { steps: 16 }, tolerance: 3e-4 }));
        problems.push(Problem { ways, ..base(rings) });
    }
    for thickness in if quick { &[0.05][..] } else { &[0.05, 0.02, 0.005] } {
        let mut problem = Problem { ways: few(), ..base(14) };
        problem.settings.thickness = *thickness;
        problem.name = format!("h/L {thickness}, curl 10");
        problems.push(problem);
    }
    for curl in if quick { &[25.0][..] } else { &[1.0, 4.0, 25.0] } {
        let mut problem = Problem { ways: few(), ..base(14) };
        problem.settings.curl = *curl;
        problem.name = format!("h/L 0.01, curl {curl}");
        problems.push(problem);
    }
    problems
}

/// The name of a row.
pub fn counted_name(problem: &Problem, way: Way) -> String {
    format!("deform/{}/{}/{}/{}", problem.mesh.positions.len(), problem.name, way.name(), way.setting())
}

/// Does the work of a row by its name, once; whether there is such a row.
pub fn do_row(name: &str) -> bool {
    let all = problems(false);
    let named = |problem: &Problem| problem.ways.iter().copied().find(|&way| counted_name(problem, way) == name);
    let found = all.iter().find_map(|problem| named(problem).map(|way| (problem, way)));
    found.is_some_and(|(problem, way)| {
        let _ = std::hint::black_box(way.run(problem));
        true
    })
}
