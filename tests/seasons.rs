//! Seasons of whole trees in real and made weather: dates against observed ones, the same leaves at any step, crowns that turn
//! together, and what weather does to colour.
//!
//! The climate and the observations of Harvard Forest are read from beside the repository; tests that need them pass
//! without.

mod common;

use common::{render, small};
use leafseason::base::limits::Limits;
use leafseason::report::Report;
use leafseason::run::Options;
use leafseason::scene::{self, Scene};
use leafseason::season::Moment;
use leafseason::tree;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

const GREEN: [&str; 3] = ["flush", "green", "late-green"];

fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
    path.exists().then_some(path)
}

/// A scene that draws nothing, beside files of the given contents.
fn read(text: &str, files: &[(&str, String)]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        fs::write(folder.path().join(name), content).unwrap();
    }
    let path = folder.path().join("season.toml");
    fs::write(&path, format!("{text}\n[output]\npng = false\n[fall]\non = false\n")).unwrap();
    scene::read(&path, &[], &[], &Limits::default()).unwrap_or_else(|fault| panic!("{text}: {fault}")).0
}

/// State and its first day, by frame and leaf.
type States = BTreeMap<(i64, String), (String, f64)>;

/// The report of a scene, and the state and its first day of each leaf in each frame.
fn run(scene: &Scene) -> (Report, States) {
    let folder = tempfile::tempdir().unwrap();
    let states = folder.path().join("states.csv");
    let options = Options { out: folder.path().to_owned(), states: Some(states.clone()), ..Options::default() };
    let report = render(scene, &options).report;
    let text = fs::read_to_string(states).unwrap();
    let line = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        ((fields[0].parse().unwrap(), fields[2].to_owned()), (fields[3].to_owned(), fields[4].parse().unwrap()))
    };
    (report, text.lines().skip(1).map(line).collect())
}

fn reported(scene: &Scene) -> Report {
    let folder = tempfile::tempdir().unwrap();
    render(scene, &Options { out: folder.path().to_owned(), ..Options::default() }).report
}

/// Day of the frame and the expected share of some states, frame by frame.
fn shares(report: &Report, wanted: &[&str]) -> Vec<(f64, f64)> {
    let share = |states: &BTreeMap<String, f64>| wanted.iter().filter_map(|name| states.get(*name)).sum();
    report.frames.iter().map(|frame| (frame.day, share(&frame.expected))).collect()
}

fn leaves(report: &Report) -> Vec<(f64, f64)> {
    shares(report, &["fallen", "bud"]).into_iter().map(|(day, gone)| (day, 1.0 - gone)).collect()
}

fn at(curve: &[(f64, f64)], day: f64) -> f64 {
    let after = curve.partition_point(|(known, _)| *known < day).clamp(1, curve.len() - 1);
    let [(a, low), (b, high)] = [curve[after - 1], curve[after]];
    low + (high - low) * ((day - a) / (b - a)).clamp(0.0, 1.0)
}

/// The last day on which a falling curve passes a level.
fn crossing(curve: &[(f64, f64)], level: f64) -> f64 {
    let place = (1..curve.len()).rev().find(|&k| curve[k - 1].1 >= level && curve[k].1 < level).expect("a crossing");
    let [(a, high), (b, low)] = [curve[place - 1], curve[place]];
    a + (high - level) / (high - low) * (b - a)
}

/// Visits of a year: day of the series (0 for 1 January), green and leaf shares.
fn observed(species: &str, year: &str) -> Option<Vec<[f64; 3]>> {
    let text = fs::read_to_string(shared(&format!("phenology/{species}_harvard.csv"))?).ok()?;
    let visit = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |at: usize| fields[at].parse::<f64>().unwrap();
        (fields[0] == year).then(|| [number(1) - 1.0, number(5), number(3)])
    };
    Some(text.lines().skip(1).filter_map(visit).collect())
}

fn harvard(year: &str) -> Option<String> {
    fs::read_to_string(shared(&format!("climate/harvard_{year}.csv"))?).ok()
}

/// Root mean square error of green and leaf shares over all visits, and the largest error of their 75, 50 and 25 % dates.
fn scored(species: &str, table: &str, year: &str) -> Option<(f64, f64)> {
    let visits = observed(table, year)?;
    let text = format!(
        "species = \"{species}\"\nclimate = {{ series = \"weather.csv\" }}\ntree = {{ age = 12 }}\n\
         time = {{ from = \"{year}-07-20\", to = \"{year}-12-20\" }}"
    );
    let report = reported(&read(&text, &[("weather.csv", harvard(year)?)]));
    let curves = [shares(&report, &GREEN), leaves(&report)];
    let (mut squares, mut latest) = (0.0, 0.0);
    for (curve, column) in curves.iter().zip([1, 2]) {
        let seen: Vec<(f64, f64)> = visits.iter().map(|visit| (visit[0], visit[column])).collect();
        squares += seen.iter().map(|(day, share)| (at(curve, *day) - share) * (at(curve, *day) - share)).sum::<f64>();
        for level in [0.75, 0.5, 0.25] {
            latest = f64::max(latest, (crossing(curve, level) - crossing(&seen, level)).abs());
        }
    }
    Some(((squares / (2 * visits.len()) as f64).sqrt(), latest))
}

#[test]
fn maples_and_oaks_of_harvard_forest_turn_when_they_did() {
    for (species, table) in [("red-maple", "red_maple"), ("red-oak", "red_oak")] {
        let years = ["2016", "2017", "2018"].map(|year| scored(species, table, year));
        let [Some(a), Some(b), Some(c)] = years else { return };
        let errors = [a, b, c];
        assert!(errors.iter().all(|(error, days)| *error <= 0.10 && *days <= 10.0), "{species}: {errors:?}");
        let mean = errors.iter().map(|(error, _)| error).sum::<f64>() / 3.0;
        assert!(mean <= 0.08, "{species}: {errors:?}");
    }
}

/// Shares of a red maple of mean leaves at Harvard Forest in 2017 by another program, which exponentiates each day's matrix: day of the year, then green, late-green, turning, yellow, red, brown, fallen.
const REFERENCE: [(f64, [f64; 7]); 4] = [
    (250.0, [0.99438404913, 0.005293147386, 1.2125e-08, 7.5e-11, 4.9e-11, 0.0003070769, 1.5714193e-05]),
    (
        270.0,
        [0.639787687771, 0.325767199921, 0.005843827876, 0.000510782359, 0.00027365539, 0.017228576789, 0.010588269893],
    ),
    (
        285.0,
        [0.111952642712, 0.462427629086, 0.19592236493, 0.052287120106, 0.044769099287, 0.039097683314, 0.093543460566],
    ),
    (
        300.0,
        [0.002571175303, 0.036234227407, 0.122821858508, 0.06289809828, 0.07913703433, 0.099137244058, 0.597200362114],
    ),
];

#[test]
fn the_law_is_that_of_another_program() {
    let Some(weather) = harvard("2017") else { return };
    let names = ["green", "late-green", "turning", "yellow", "red", "brown", "fallen"];
    for (day, expected) in REFERENCE {
        // All leaves are of the mean class.
        let text = format!(
            "species = \"red-maple\"\nclimate = {{ series = \"weather.csv\" }}\ntree = {{ age = 2 }}\n\
             season = {{ crown = {{ rate = 0.0, limb = 0.0, shoot = 0.0, height = 0.0 }} }}\ntime = {{ day = {} }}",
            day - 1.0
        );
        let report = reported(&read(&text, &[("weather.csv", weather.clone())]));
        for (name, share) in names.iter().zip(expected) {
            let found = report.frames[0].expected[*name];
            assert!((found - share).abs() < 1e-9, "day {day}, {name}: {found}, not {share}");
        }
    }
}

#[test]
fn frames_a_quarter_day_apart_agree_with_those_a_day_apart_alone_and_in_a_run() {
    let frames = |step: f64, from: f64| {
        let text = format!(
            "species = \"sugar-maple\"\nclimate = {{ latitude = 44.0 }}\ntree = {{ age = 5 }}\n\
             time = {{ from = {from}, to = 283, step = {step} }}"
        );
        run(&read(&text, &[])).1
    };
    let (daily, quarters, last) = (frames(1.0, 279.0), frames(0.25, 279.0), frames(1.0, 283.0));
    for ((frame, leaf), state) in &daily {
        assert_eq!(quarters[&(frame * 4, leaf.clone())], *state);
        if *frame == 4 {
            assert_eq!(last[&(0, leaf.clone())], *state);
        }
    }
    assert!(daily.len() > 500 && daily.values().map(|(state, _)| state).any(|state| state == "red"));
}

#[test]
fn a_tree_more_changes_no_leaf_of_the_first() {
    let of = |trees: &str| {
        let text = format!(
            "species = \"red-maple\"\nclimate = {{ latitude = 44.0 }}\ntime = {{ day = 281 }}\n\
             [[trees]]\nplace = [0.0, 0.0]\nage = 4\n{trees}"
        );
        run(&read(&text, &[])).1
    };
    let (one, two) = (of(""), of("[[trees]]\nplace = [9.0, 0.0]\nage = 4\n"));
    assert!(two.len() > one.len());
    assert!(one.iter().all(|(leaf, state)| two[leaf] == *state));
}

#[test]
fn a_sugar_maple_turns_from_the_top_and_its_shoots_turn_together() {
    let scene = read(
        "species = \"sugar-maple\"\nclimate = { latitude = 44.0 }\ntree = { age = 20 }\ntime = { from = 250, to = 300 }",
        &[],
    );
    let (report, states) = run(&scene);
    let green = shares(&report, &GREEN);
    let frame = green.iter().position(|(_, share)| *share < 0.5).unwrap() as i64;
    let (tree, _) = tree::grow(&scene.trees[0].tree, scene.seed, &Limits::default()).unwrap();
    let distance = |site: &tree::LeafSite| (site.base.x * site.base.x + site.base.z * site.base.z).sqrt();
    let third = |values: &mut Vec<f64>, part: usize| {
        values.sort_unstable_by(f64::total_cmp);
        values[values.len() * part / 3]
    };
    let mut heights: Vec<f64> = tree.sites.iter().map(|site| site.base.y).collect();
    let mut distances: Vec<f64> = tree.sites.iter().map(distance).collect();
    let (low, high) = (third(&mut heights, 1), third(&mut heights, 2));
    let (inner, outer) = (third(&mut distances, 1), third(&mut distances, 2));
    let state = |site: &tree::LeafSite| states[&(frame, format!("{:016x}", site.id))].0.as_str();
    let coloured = |wanted: &dyn Fn(&tree::LeafSite) -> bool| {
        let of: Vec<&str> = tree.sites.iter().filter(|site| wanted(site)).map(state).collect();
        let coloured = of.iter().filter(|state| !GREEN.contains(state) && **state != "fallen").count();
        coloured as f64 / of.len() as f64
    };
    let top = coloured(&|site| site.base.y > high && distance(site) > outer);
    let bottom = coloured(&|site| site.base.y < low && distance(site) < inner);
    assert!(top >= 2.0 * bottom, "{top} of the top outer third, {bottom} of the bottom inner third");
    // Beyond exposure: within slices of height and distance.
    let slice = |site: &tree::LeafSite| {
        let part = |value: f64, all: &[f64]| all.partition_point(|known| *known < value) * 8 / all.len();
        (part(site.base.y, &heights), part(distance(site), &distances))
    };
    let mut slices: BTreeMap<(usize, usize), (f64, f64)> = BTreeMap::new();
    let turned = |site: &tree::LeafSite| f64::from(u8::from(!GREEN.contains(&state(site))));
    for site in &tree.sites {
        let sum = slices.entry(slice(site)).or_default();
        *sum = (sum.0 + turned(site), sum.1 + 1.0);
    }
    let mut shoots: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for site in &tree.sites {
        let (sum, count) = slices[&slice(site)];
        shoots.entry(site.shoot).or_default().push(turned(site) - sum / count);
    }
    let all = || shoots.values().flatten();
    let variance = all().map(|rest| rest * rest).sum::<f64>() / all().count() as f64;
    let (mut products, mut pairs) = (0.0, 0.0);
    for rests in shoots.values() {
        let sum: f64 = rests.iter().sum();
        products += sum * sum - rests.iter().map(|rest| rest * rest).sum::<f64>();
        pairs += (rests.len() * (rests.len() - 1)) as f64;
    }
    let correlation = products / pairs / variance;
    assert!(correlation >= 0.3, "correlation {correlation}");
}

#[test]
fn colder_is_redder_and_drier_is_browner() {
    let largest = |climate: &str, state: &str| {
        let text = format!(
            "species = \"red-maple\"\nclimate = {{ {climate} }}\ntree = {{ age = 4 }}\ntime = {{ from = 0, to = 120 }}"
        );
        let curve = shares(&reported(&read(&text, &[])), &[state]);
        curve.into_iter().map(|(_, share)| share).fold(0.0, f64::max)
    };
    assert!(
        largest("temperature = 3.0, humidity = 0.8", "red")
            > 1.5 * largest("temperature = 20.0, humidity = 0.8", "red")
    );
    assert!(
        largest("temperature = 12.0, humidity = 0.3", "brown")
            > 1.3 * largest("temperature = 12.0, humidity = 0.9", "brown")
    );
}

#[test]
fn a_warm_summer_brings_autumn_forward_and_a_warm_autumn_puts_it_off() {
    let Some(weather) = harvard("2017") else { return };
    let warmed = |from: &str, to: &str| {
        let mut lines = weather.lines();
        let header = lines.next().unwrap().to_owned();
        let mean = header.split(',').position(|name| name == "tmean_c").unwrap();
        let line = |line: &str| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            if fields[0][5..] >= *from && fields[0][5..] <= *to {
                fields[mean] = format!("{}", fields[mean].parse::<f64>().unwrap() + 2.0);
            }
            fields.join(",")
        };
        let text = [header].into_iter().chain(lines.map(line)).collect::<Vec<String>>().join("\n");
        let scene = "species = \"red-maple\"\nclimate = { series = \"weather.csv\" }\ntree = { age = 8 }\n\
                     time = { from = \"2017-08-15\", to = \"2017-12-01\" }";
        crossing(&leaves(&reported(&read(scene, &[("weather.csv", text)]))), 0.5)
    };
    let usual = warmed("99", "99");
    assert!(warmed("05-01", "08-31") < usual - 1.0 && warmed("09-01", "10-31") > usual + 1.0);
}

/// A year's weather with three days of frost.
fn frosty() -> String {
    let mean = leafseason::season::Weather::mean_years(
        45.0,
        Some(0.75),
        leafseason::base::calendar::Date::new(2017, 1, 1).unwrap(),
        364,
    );
    let mut text = "date,tmean_c,rh_pct,daylength_h\n".to_owned();
    for day in 0..365 {
        let of = mean.days()[(day - mean.first()) as usize];
        let temperature = if (308..311).contains(&day) { -3.0 } else { of.temperature.max(6.0) };
        let date = mean.date(day as f64).unwrap();
        text += &format!("{date},{temperature},75,{}\n", of.day_length.unwrap());
    }
    text
}

#[test]
fn a_ginkgo_lets_go_within_three_days_of_the_frost() {
    let text = "species = \"ginkgo\"\nclimate = { series = \"weather.csv\" }\ntree = { age = 15 }\n\
                time = { from = 250, to = 340 }";
    let curve = leaves(&reported(&read(text, &[("weather.csv", frosty())])));
    let lost = curve.windows(4).map(|days| days[0].1 - days[3].1).fold(0.0, f64::max);
    assert!(lost >= 0.8, "{lost} lost in three days");
}

#[test]
fn beeches_keep_brown_leaves_until_new_buds_push_them_off() {
    let text = "species = \"beech\"\nclimate = { latitude = 47.0 }\ntree = { age = 15 }\ntime = { from = 0, to = 730, step = 5 }";
    let report = reported(&read(text, &[]));
    let brown = shares(&report, &["brown"]);
    assert!(at(&brown, 365.0) >= 0.10 && at(&brown, 365.0) <= 0.6);
    let green = shares(&report, &GREEN);
    for year in [0.0, 365.0] {
        assert!(at(&green, year + 195.0) > 0.99 && at(&green, year + 100.0) < 0.2);
    }
    assert!(at(&leaves(&report), 560.0) > 0.99 && at(&brown, 555.0) < 1e-6);
}

#[test]
fn every_species_is_green_in_summer_and_turns_in_its_time() {
    let names: Vec<&str> = leafseason::species::names().collect();
    for species in names {
        let text = format!(
            "species = \"{species}\"\nclimate = {{ latitude = 44.0 }}\ntree = {{ age = 7 }}\n\
             time = {{ from = 0, to = 364, step = 2 }}"
        );
        let report = reported(&read(&text, &[]));
        let green = shares(&report, &GREEN);
        assert!(at(&green, 200.0) > 0.98 && at(&green, 212.0) > 0.97, "{species}: {} in July", at(&green, 200.0));
        assert!(at(&leaves(&report), 60.0) < 0.5, "{species} in March");
        let half = crossing(&green, 0.5);
        assert!((255.0..325.0).contains(&half), "{species}: half green on day {half}");
        let error = report.stages.iter().find(|stage| stage.name == "season").unwrap().error.as_ref().unwrap();
        assert!(error.value < 0.06, "{species}: {}", error.value);
    }
}

#[test]
fn moments_are_what_they_say() {
    let seen = |moment: Moment| {
        let word = serde_json::to_value(moment).unwrap();
        let text = format!("species = \"norway-maple\"\ntree = {{ age = 10 }}\ntime = {{ moment = {word} }}");
        let frame = reported(&read(&text, &[])).frames.remove(0);
        let share = |names: &[&str]| names.iter().filter_map(|name| frame.expected.get(*name)).sum::<f64>();
        (frame.date.clone().unwrap(), share(&GREEN), share(&["fallen"]))
    };
    assert!(seen(Moment::Summer).1 > 0.98);
    assert!((0.8..0.9).contains(&seen(Moment::FirstColour).1));
    assert!((0.5..0.6).contains(&seen(Moment::HalfBare).2));
    assert!(seen(Moment::Winter).2 > 0.98);
    assert!(seen(Moment::Flush).0 < seen(Moment::Summer).0);
}

#[test]
fn the_chart_of_shares_is_written_once_for_all_frames() {
    for (form, begins) in [("svg", b"<svg".as_slice()), ("png", b"\x89PNG".as_slice())] {
        let chart = format!("output={{png=false, shares=\"{form}\"}}");
        let scene = small(&["time={from=0, to=20, step=10}", &chart]);
        let folder = tempfile::tempdir().unwrap();
        render(&scene, &Options { out: folder.path().to_owned(), ..Options::default() });
        let written = fs::read(folder.path().join(format!("small.shares.{form}"))).unwrap();
        assert!(written.starts_with(begins));
        if form == "svg" {
            let text = String::from_utf8(written).unwrap();
            for word in ["late-green", "red", "temperature", "humidity", "share of leaves"] {
                assert!(text.contains(word), "{word}");
            }
        }
    }
}
