//! The falls that a frame's leaf states tell of, and what has become of them.

use crate::compose::{Dropped, Falls, Stand, Ways};
use crate::plan;
use crate::scene::Scene;
use crate::season::{FALLEN, LeafStates};

/// What has become of every leaf that has fallen by a frame's time; `None` where fallen leaves are not asked for. `ways` are
/// those that other frames have found.
pub fn falls((scene, stand): (&Scene, &Stand), states: &LeafStates, index: i64, ways: &mut Ways) -> Option<Falls> {
    if !scene.leaves_fall() {
        return None;
    }
    let hangs: Vec<bool> = states.names.iter().map(|name| !plan::is_off_the_tree(name)).collect();
    let hangs = |state: u16| hangs.get(usize::from(state)).copied().unwrap_or(false);
    let attached = states.states.iter().filter(|&&state| hangs(state)).count() as u64;
    let fallen = states.names.iter().position(|name| name == FALLEN).map(|place| place as u16);
    let sites = states.states.iter().zip(&states.before).zip(&states.since).enumerate();
    let now = scene.time.at(index);
    let sites = sites
        .filter(|(_, ((state, before), _))| Some(**state) == fallen && hangs(**before))
        .map(|(site, ((_, &state), &day))| (site, day, state));
    let year = |day: f64| scene.weather.date(day).map_or(0, |date| date.year() as u64);
    // A leaf's way is keyed by the year it fell in: the same before and after a new leaf has taken its site.
    let dropped: Vec<Dropped> = sites
        .chain(states.shed.iter().copied().filter(|&(_, day, state)| hangs(state) && day <= now))
        .map(|(site, day, state)| Dropped { site, year: year(day), day, state })
        .collect();
    Some(Falls::new((scene, stand, &states.names), &dropped, attached, now, ways))
}
