//! How long a step of equation (1) may be, over stiffnesses and mass ratios, and the orders of integrators.

use super::chart::{self, Curve};
use super::desk::Desk;
use super::numbers::shown;
use super::oscillator;
use super::problems::hexagon;
use super::table::{Field, Table};
use crate::base::diagnostic::Diagnostics;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::DVec3;
use crate::deform::{Settings, Springs};

const COLUMNS: [&str; 7] = ["case", "sweep_var", "value", "method", "dt_max", "dt_max_over_theory", "status"];
const STIFFNESSES: [f64; 5] = [1.0, 1e2, 1e4, 1e6, 1e8];
const MASS_RATIOS: [f64; 4] = [1.0, 10.0, 1e2, 1e4];
/// Steps of a trial; growth beyond this factor of the energy within them is instability.
const STEPS: u32 = 2000;
const GROWTH: f64 = 1e3;
/// The bound of equation (2) that is tried.
const LIMIT: f64 = 0.1;

/// A lattice of a stiffness whose masses alternate by a ratio, at rest but for a small kick. No drag, no friction.
fn lattice(stiffness: f64, ratio: f64) -> Springs {
    let settings = Settings { stiffness, drag: 0.0, friction: 0.0, ..Settings::default() };
    let mut springs = Springs::new(&settings, &hexagon());
    springs.weigh(|number| if number % 2 == 0 { 1e-6 } else { 1e-6 * ratio });
    let speed = 4e-6 / springs.critical_step();
    let mut stream = Stream::new(3, Purpose::Deformation, 0, 0);
    let kicks: Vec<DVec3> = springs
        .masses()
        .iter()
        .map(|_| DVec3::new(stream.range(-speed, speed), stream.range(-speed, speed), 0.0))
        .collect();
    springs.stir(|number, _| kicks[number]);
    springs
}

/// Whether the energy stays bounded at a step of this share of 2 / w_max.
fn is_stable(springs: &Springs, share: f64, limit: Option<f64>) -> bool {
    let mut springs = springs.clone();
    let step = share * springs.critical_step();
    let start = springs.energy();
    (0..STEPS).all(|_| {
        springs.advance(step, limit);
        springs.energy() <= GROWTH * start
    })
}

/// The largest stable share of 2 / w_max, to a hundredth, between half and twice.
fn largest_share(springs: &Springs, limit: Option<f64>) -> f64 {
    let (mut stable, mut unstable) = (0.5, 2.0);
    while unstable - stable > 0.01 {
        let middle = 0.5 * (stable + unstable);
        if is_stable(springs, middle, limit) { stable = middle } else { unstable = middle }
    }
    stable
}

/// Runs the sweeps.
///
/// # Errors
/// Files that cannot be written.
pub fn study(desk: &mut Desk<'_>) -> Result<(), Diagnostics> {
    let mut table = Table::new(&COLUMNS);
    let (mut curves, mut wrong) = (Vec::new(), Vec::new());
    for limit in [None, Some(LIMIT)] {
        let method = if limit.is_none() { "equation (1)" } else { "equations (1) and (2)" };
        let stiff = STIFFNESSES.map(|value| ("stiffness", value, lattice(value, 1.0)));
        let uneven = MASS_RATIOS.map(|value| ("mass_ratio", value, lattice(40.0, value)));
        let mut points = Vec::new();
        for (variable, value, springs) in stiff.iter().chain(&uneven) {
            let (critical, share) = (springs.critical_step(), largest_share(springs, limit));
            let is_right = is_stable(springs, 0.9, limit) && (limit.is_some() || !is_stable(springs, 1.1, limit));
            if !is_right {
                wrong.push(format!("{method}, {variable} {value}"));
            }
            let name = format!("{method}, {variable} {value}");
            desk.tell(&format!("stability {name}: {} s, {share:.3} of 2 / w_max", shown(share * critical)));
            table.push(vec![
                "hexagon".into(),
                (*variable).into(),
                (*value).into(),
                method.into(),
                (share * critical).into(),
                share.into(),
                (if is_right { "ok" } else { "wrong" }).into(),
            ]);
            if *variable == "stiffness" {
                points.push([*value, share * critical]);
            }
        }
        curves.push(Curve::new(method, points));
    }
    let asked = "equation (1) stable at 0.9 and unstable at 1.1 of 2 / w_max, 5 stiffnesses and 4 mass ratios";
    let found = if wrong.is_empty() { "all 9 so".to_owned() } else { wrong.join("; ") };
    desk.judge("P5", wrong.is_empty(), asked, found);
    orders(desk, &mut table);
    strain_bound(desk, &mut table);
    desk.write_table("stability.csv", &table)?;
    let frame = chart::Frame {
        title: "Largest stable step against stiffness",
        x: ["stiffness of a spring", "N/m"],
        y: ["step", "s"],
        orders: &[-0.5],
        floor: None,
        left_out: &["implicit Euler and the shell's solver: no largest step was found (see the matrix, D32)"],
    };
    desk.write_chart("stability", &chart::chart(&frame, &curves))?;
    let text = format!("![largest stable step](stability.png)\n\n{}", table.markdown(&COLUMNS));
    desk.section("Stability", &text);
    Ok(())
}

/// The orders of integrators on an oscillator.
fn orders(desk: &mut Desk<'_>, table: &mut Table) {
    let tried = oscillator::orders();
    for one in &tried {
        let is_right = (one.asked[0]..=one.asked[1]).contains(&one.order);
        let mut row = vec!["oscillator, 0.37 period".into(), "order".into(), one.order.into(), one.name.into()];
        row.extend([Field::Number(None), Field::Number(None), (if is_right { "ok" } else { "wrong" }).into()]);
        table.push(row);
    }
    let passes = tried.iter().all(|one| (one.asked[0]..=one.asked[1]).contains(&one.order));
    let found = tried.iter().map(|one| format!("{} {:.3}", one.name, one.order)).collect::<Vec<_>>().join(", ");
    desk.judge("P4", passes, "orders at 0.37 period: equation (1) 0.9 to 1.1, RK4 3.8 to 4.2, BDF2 1.8 to 2.2", found);
}

/// Equation (2) under a kick that would tear the lattice.
fn strain_bound(desk: &mut Desk<'_>, table: &mut Table) {
    let mut worst: f64 = 0.0;
    for limit in [0.0, 1e-6, 0.01, 0.1, 1.0] {
        let mut springs = lattice(40.0, 1.0);
        let speed = 0.004 / springs.critical_step();
        springs.stir(|number, p| {
            p.try_normalize(1e-9).unwrap_or(DVec3::z()) * if number % 3 == 0 { speed } else { -0.2 * speed }
        });
        let step = 0.7 * springs.critical_step();
        let mut strain: f64 = 0.0;
        for _ in 0..500 {
            springs.advance(step, Some(limit));
            strain = strain.max(springs.strain());
        }
        worst = worst.max(strain - limit);
        let mut row = vec!["strain bound".into(), "limit".into(), limit.into(), "equations (1) and (2)".into()];
        row.extend([step.into(), strain.into(), (if strain <= limit + 0.01 { "ok" } else { "wrong" }).into()]);
        table.push(row);
    }
    let asked = "the largest strain at most 0.01 above the bound of equation (2)";
    desk.judge("P6", worst <= 0.01, asked, format!("{} above it at most", shown(worst)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_of_stability_is_where_the_theory_has_it() {
        for springs in [lattice(1e4, 1.0), lattice(40.0, 1e2)] {
            assert!(is_stable(&springs, 0.9, None) && !is_stable(&springs, 1.1, None));
        }
    }
}
