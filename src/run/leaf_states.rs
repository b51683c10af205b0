//! The states of all leaves of a stand, species by species: each has its own chain, the leaves their own clocks.

use crate::base::figures::Figures;
use crate::compose::Stand;
use crate::scene::{Scene, time::Time};
use crate::season::{self, Crown, Law, LeafStates, Moment, Population, Position};
use std::collections::BTreeMap;

/// State of a leaf whose species has no seasons.
const NO_STATE: u16 = u16::MAX;
/// Chance of a jump in a step of the paper's rule from which its law is off by more than a hundredth.
const LONG_STEP: f64 = 0.14;
/// Share of a weather's days outside the chain's corners above which the person is told.
const NOTED: f64 = 0.5;

/// The leaves of all species of a scene, with what is expected of them.
pub struct Seasons {
    time: Time,
    /// Names of the states of all species, sorted.
    names: Vec<String>,
    parts: Vec<Part>,
    leaves: usize,
    /// The law of all leaves at frames whose days are known.
    laws: BTreeMap<i64, Law>,
}

/// The leaves of one species.
struct Part {
    /// Number of the species.
    species: usize,
    population: Population,
    /// Number of each of its leaves among those of the stand.
    places: Vec<usize>,
    /// Number of each of its states among all.
    common: Vec<u16>,
}

/// The names of the states of all species that have leaves, sorted.
pub fn names(scene: &Scene, stand: &Stand) -> Vec<String> {
    let with_leaves = with_leaves(scene, stand).into_iter();
    let mut names: Vec<String> =
        with_leaves.flat_map(|number| scene.species[number].season.states.keys().cloned()).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The numbers of the species that have leaves and seasons.
fn with_leaves(scene: &Scene, stand: &Stand) -> Vec<usize> {
    let has_leaves = |number: usize| stand.standing().any(|(form, _)| form.species == number && !form.sites.is_empty());
    let has_seasons = |number: &usize| !scene.species[*number].season.states.is_empty();
    (0..scene.species.len()).filter(has_seasons).filter(|&number| has_leaves(number)).collect()
}

impl Seasons {
    /// The leaves of a stand; `names` are those of [`names`].
    pub fn new(scene: &Scene, stand: &Stand, names: &[String]) -> Self {
        let part = |number| Part::new(scene, stand, names, number);
        let parts = with_leaves(scene, stand).into_iter().map(part).collect();
        Self { time: scene.time, names: names.to_vec(), parts, leaves: stand.leaf_ids.len(), laws: BTreeMap::new() }
    }

    /// Finds the day of the scene's moment, which comes to the first species that has leaves; `None` when it does not come.
    pub fn find(&mut self, moment: Moment) -> Option<Time> {
        self.time = Time::one(self.parts.first()?.population.day_of(moment)?);
        Some(self.time)
    }

    /// Keeps what makes many frames fast, and finds the exact shares of all of them at once.
    pub fn prepare(&mut self, frames: &[i64], keep: bool) {
        if keep {
            self.parts.iter_mut().for_each(|part| part.population.keep());
        }
        let mut order: Vec<i64> = frames.to_vec();
        order.sort_unstable_by(|a, b| self.time.at(*a).total_cmp(&self.time.at(*b)).then(a.cmp(b)));
        let days: Vec<f64> = order.iter().map(|&index| self.time.at(index)).collect();
        self.laws.extend(order.into_iter().zip(self.laws_of(&days)));
    }

    /// The exact shares of all leaves on days that ascend.
    pub fn laws_of(&self, days: &[f64]) -> Vec<Law> {
        let of_parts: Vec<Vec<Law>> = self.parts.iter().map(|part| part.population.laws(days)).collect();
        let at = |day: usize| mixed(self.names.len(), self.parts.iter().zip(of_parts.iter().map(|laws| &laws[day])));
        (0..days.len()).map(at).collect()
    }

    /// The states that leaves of a species can come to, with their numbers among all; none for a species without seasons.
    pub fn reachable(&self, species: usize) -> Vec<(u16, bool)> {
        let part = self.parts.iter().find(|part| part.species == species);
        let states = part.map(|part| part.common.iter().copied().zip(part.population.reachable()));
        states.into_iter().flatten().collect()
    }

    /// The state of every leaf at a frame's time, in the order of the stand's ids.
    pub fn at(&mut self, index: i64) -> (LeafStates, Figures) {
        if !self.laws.contains_key(&index) {
            self.prepare(&[index], false);
        }
        let day = self.time.at(index);
        let law = self.laws.get(&index).cloned().unwrap_or_default();
        let leaves = self.leaves;
        let (mut states, mut before, mut since) = (vec![NO_STATE; leaves], vec![NO_STATE; leaves], vec![0.0; leaves]);
        let (mut from_law, mut shed) = (0, Vec::new());
        for part in &mut self.parts {
            let sample = part.population.at(day);
            from_law += sample.from_law;
            let common = |state: u16| part.common[usize::from(state)];
            shed.extend(sample.shed.iter().map(|&(leaf, day, state)| (part.places[leaf], day, common(state))));
            for (leaf, &place) in part.places.iter().enumerate() {
                states[place] = part.common[usize::from(sample.states[leaf])];
                before[place] = part.common[usize::from(sample.before[leaf])];
                since[place] = sample.since[leaf];
            }
        }
        let mut figures = season::figures(&self.names, &states, &law).with("drawn_from_law", from_law);
        self.note(day, &mut figures);
        (LeafStates { names: self.names.clone(), states, before, since, expected: law.expected, shed }, figures)
    }

    /// What the person should know of weather and rules.
    fn note(&self, day: f64, figures: &mut Figures) {
        let (mut clamped, mut days, mut longest) = (0usize, 0usize, 0.0);
        for part in &self.parts {
            let (outside, all) = part.population.clamped();
            (clamped, days) = (clamped.max(outside), days.max(all));
            longest = f64::max(longest, part.population.largest_step());
        }
        figures.values.insert("climate_clamped".to_owned(), (clamped > 0).into());
        let errors = self.parts.iter().filter_map(|part| part.population.step_error(day));
        if let Some(error) = errors.reduce(f64::max) {
            figures.values.insert("step_error".to_owned(), error.into());
        }
        // Single days beyond the corners are every winter's; the figure says so, a note would only tire.
        if clamped as f64 > NOTED * days as f64 {
            let corners = "outside the corners of [season] (cold to warm, dry to wet)";
            figures.notes.push(match days {
                1 => format!("the climate lies {corners} and counts as the nearest between them"),
                _ => format!(
                    "{clamped} of {days} days of the weather lie {corners} and count as the nearest between them"
                ),
            });
        }
        if longest > LONG_STEP {
            let what = "season.step is long for these half-lives: at most one jump a step makes shares late";
            figures.notes.push(format!("{what}; the report's `step_error` says by how much"));
        }
    }
}

impl Part {
    fn new(scene: &Scene, stand: &Stand, names: &[String], number: usize) -> Self {
        let settings = &scene.species[number].season;
        let mut population = Population::new(settings, &scene.weather, scene.seed);
        let mut places = Vec::new();
        let mut first = 0;
        for (form, standing) in stand.standing() {
            if form.species == number {
                let ids = &stand.leaf_ids[first..first + form.sites.len()];
                let tree = &scene.trees[standing.entry].tree;
                let crown = Crown::new(&settings.crown, tree.age, tree.height);
                let position = |site: &crate::tree::LeafSite| Position {
                    height: site.base.y,
                    distance: (site.base.x * site.base.x + site.base.z * site.base.z).sqrt(),
                    limb: standing.own(site.limb),
                    shoot: standing.own(site.shoot),
                };
                let timing = (standing.key != 0).then_some(standing.key);
                population.add(timing, crown.as_ref(), ids.iter().copied().zip(form.sites.iter().map(position)));
                places.extend(first..first + form.sites.len());
            }
            first += form.sites.len();
        }
        if scene.leaves_fall() {
            population.remember();
        }
        let place = |name: &String| names.binary_search(name).map_or(NO_STATE, |place| place as u16);
        let common = population.names().iter().map(place).collect();
        Self { species: number, population, places, common }
    }
}

/// The law of all leaves: the species' laws, weighted by their leaves.
fn mixed<'a>(states: usize, parts: impl Iterator<Item = (&'a Part, &'a Law)> + Clone) -> Law {
    let all: usize = parts.clone().map(|(part, _)| part.population.count()).sum();
    let mut mixed = Law { expected: vec![0.0; states], variance: vec![0.0; states] };
    for (part, law) in parts {
        let weight = part.population.count() as f64 / all.max(1) as f64;
        for ((&common, expected), variance) in part.common.iter().zip(&law.expected).zip(&law.variance) {
            if let Some(sum) = mixed.expected.get_mut(usize::from(common)) {
                *sum += weight * expected;
                mixed.variance[usize::from(common)] += weight * variance;
            }
        }
    }
    mixed
}
