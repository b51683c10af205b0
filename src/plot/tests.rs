//! Whole charts: both writers agree, documents are well formed, nothing that is asked for panics.

use super::layout::lay_out;
use super::primitive::{Drawing, Primitive, Text};
use super::*;

fn wave() -> Vec<[f64; 2]> {
    (0..=60).map(|day| [f64::from(day), f64::from(day * (60 - day)) / 9.0]).collect()
}

fn panel(series: Vec<Series>) -> Panel {
    Panel { series, ..Panel::default() }
}

fn season() -> Plot {
    let origin = Date::new(2016, 2, 1).unwrap();
    let time = Axis { scale: Scale::Dates { origin }, ..Axis::default() };
    let falling = wave().iter().map(|&[x, y]| [x, 100.0 - y]).collect();
    let shares = Panel {
        x: time.clone(),
        y: Axis { label: "share".into(), unit: "%".into(), range: Some([0.0, 100.0]), ..Axis::default() },
        share: 2.0,
        ..panel(vec![
            Series::new("red", Style::Area, wave()).coloured([190, 40, 30]),
            Series::new("green", Style::Area, falling).coloured([60, 120, 40]),
        ])
    };
    let line = Series::new("t", Style::Line, wave()).coloured([200, 0, 250]);
    let temperature =
        Panel { x: time, guides: vec![Guide::Level { y: 0.0, label: "frost".into() }], ..panel(vec![line]) };
    Plot { title: "A <season> & its \"leaves\"".into(), panels: vec![shares, temperature], ..Plot::default() }
}

fn study() -> Plot {
    let points = |order: f64| (0..6).map(|k| f64::from(1u32 << k)).map(|n| [n, (n * order).recip()]).collect();
    let axis = |label: &str| Axis { label: label.into(), scale: Scale::Log, ..Axis::default() };
    let euler = Series { diverged: vec![1.0, 2.0], ..Series::new("Euler", Style::Marked(Mark::Circle), points(1.0)) };
    let panel = Panel {
        x: axis("work"),
        y: axis("error"),
        guides: vec![Guide::Slope { order: -1.0, through: [4.0, 1.0], label: String::new() }],
        bands: vec![Band { along: Along::Y, from: 0.0, to: 1.0e-2, label: "reference".into() }],
        ..panel(vec![euler, Series::new("Newton", Style::Marks(Mark::Plus), points(9.0))])
    };
    Plot { panels: vec![panel], ..Plot::default() }
}

/// Element names in their order; every one is closed, in the right order.
fn elements(svg: &str) -> Vec<String> {
    let (mut open, mut seen) = (vec![], vec![]);
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "a bare > in {:?}", &rest[..start]);
        let end = start + rest[start..].find('>').expect("tags end");
        let tag = &rest[start + 1..end];
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap().to_owned();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else {
            seen.push(name.clone());
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "{open:?}");
    seen
}

/// The attribute of every element of this kind.
fn attributes<'a>(svg: &'a str, element: &str, name: &str) -> Vec<&'a str> {
    let of_tag = |tag: &'a str| tag.split_once(&format!("{name}=\"")).and_then(|(_, rest)| rest.split('"').next());
    svg.split(&format!("<{element} ")).skip(1).map(|rest| rest.split('>').next().unwrap()).filter_map(of_tag).collect()
}

fn texts<'a>(drawing: &'a Drawing) -> Vec<&'a Text> {
    let text = |item: &'a Primitive| if let Primitive::Text(text) = item { Some(text) } else { None };
    drawing.items.iter().filter_map(text).collect()
}

#[test]
fn documents_are_well_formed_and_hold_one_line_for_each_series() {
    let document = svg(&season());
    let groups = document.split("<g>").skip(1).map(|rest| rest.split("</g>").next().unwrap());
    let counts: Vec<usize> = groups.map(|group| group.matches("<polyline").count()).collect();
    assert_eq!(counts, [1, 1, 1]);
    let names = elements(&document);
    assert_eq!(names.iter().filter(|name| *name == "g").count(), 3);
    assert!(document.contains("<title>A &lt;season&gt; &amp; its &quot;leaves&quot;</title>"));
    assert!(document.contains(">1 Mar</text>") && document.contains(">2016</text>"));
    elements(&svg(&study()));
}

#[test]
fn names_cannot_break_a_document() {
    let name = "</text><script>alert('x')</script>\u{0}\u{1b}[31m\u{ffff}\u{202e}&#0;";
    let axis = Axis { label: name.into(), unit: name.into(), ..Axis::default() };
    let guides = vec![Guide::Level { y: 1.0, label: name.into() }];
    let bands = vec![Band { along: Along::X, from: 0.0, to: 50.0, label: name.into() }];
    let series = vec![Series::new(name, Style::Line, wave())];
    let panels = vec![Panel { x: axis.clone(), y: axis, series, guides, bands, ..Panel::default() }];
    let plot = Plot { title: name.into(), description: name.into(), panels, ..Plot::default() };
    let document = svg(&plot);
    assert!(!elements(&document).contains(&"script".to_owned()));
    assert!(document.chars().all(|c| c == '\n' || !c.is_control() && c != '\u{ffff}' && c != '\u{202e}'));
    assert!(!document.contains("&#0;"));
}

#[test]
fn both_writers_place_a_line_at_the_same_pixels() {
    let plot = season();
    let (document, picture) = (svg(&plot), picture(&plot));
    let at = attributes(&document, "polyline", "stroke").iter().position(|&colour| colour == "#c800fa").unwrap();
    let points = attributes(&document, "polyline", "points")[at];
    let mut seen = 0;
    for pair in points.split(' ') {
        let (x, y) = pair.split_once(',').unwrap();
        let (x, y) = (x.parse::<f64>().unwrap(), y.parse::<f64>().unwrap());
        let around = [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)].map(|(right, down)| {
            let inside = |at: f64, side: u32| (at.max(0.0) as u32).min(side - 1);
            picture.at(inside(x + right, picture.width), inside(y + down, picture.height))
        });
        // The nearest of the four pixels around the point is the line's own colour, or nearly.
        let is_line = |[red, green, blue, _]: [u8; 4]| red > 170 && green < 120 && blue > 200;
        assert!(around.into_iter().any(is_line), "{x} {y}: {around:?}");
        seen += 1;
    }
    assert_eq!(seen, 61);
}

#[test]
fn areas_fill_what_lies_between_their_edges() {
    let picture = picture(&season());
    let count = |[r, g, b]: [u8; 3]| picture.pixels.iter().filter(|pixel| **pixel == [r, g, b, 255]).count() as f64;
    let (red, green) = (count([190, 40, 30]), count([60, 120, 40]));
    // The mean of x (60 - x) / 9 over the 61 samples' polygon is 66.65.
    assert!((red / (red + green) - 0.6665).abs() < 0.01, "{red} {green}");
}

#[test]
fn every_diverged_run_has_a_cross_at_the_upper_edge() {
    let without = |plot: &Plot| {
        let mut plot = plot.clone();
        plot.panels[0].series[0].diverged.clear();
        plot
    };
    let crosses = |plot: &Plot| attributes(&svg(plot), "polyline", "points").len();
    // Two strokes with two edges of paper each: for two runs and in the legend.
    assert_eq!(crosses(&study()) - crosses(&without(&study())), 3 * 4);
}

#[test]
fn a_guide_has_the_slope_that_it_names() {
    let mut plot = study();
    let panel = &mut plot.panels[0];
    (panel.x.range, panel.y.range) = (Some([1.0, 100.0]), Some([1.0e-4, 1.0]));
    let none = String::new;
    // y = x^-1 from the corner (1, 1) ends on the right edge at the height of 0.01.
    panel.guides = vec![
        Guide::Slope { order: -1.0, through: [10.0, 0.1], label: none() },
        Guide::Level { y: 0.01, label: none() },
        Guide::Upright { x: 1.0, label: none() },
    ];
    let drawing = lay_out(&plot);
    let guides: Vec<Vec<[f64; 2]>> = drawing
        .items
        .iter()
        .filter_map(|item| match item {
            Primitive::Polyline { points, pen } if pen.dashes.is_some() => Some(points.clone()),
            _ => None,
        })
        .collect();
    let [slope, level, upright] = &guides[..] else { panic!("three guides: {guides:?}") };
    for (end, corner) in [(slope[0], upright[1]), (slope[1], level[1])] {
        assert!((0..2).all(|axis| (end[axis] - corner[axis]).abs() < 0.01), "{end:?} {corner:?}");
    }
    assert!(texts(&drawing).iter().any(|text| text.text == "slope \u{2212}1"));
}

/// The box of a level text: left, top, right, bottom.
fn extent(text: &Text) -> [f64; 4] {
    let wide = words::width(&text.text, text.size);
    let left = text.at[0]
        - match text.anchor {
            primitive::Anchor::Start => 0.0,
            primitive::Anchor::Middle => wide / 2.0,
            primitive::Anchor::End => wide,
        };
    [left, text.at[1] - 0.7 * text.size, left + wide, text.at[1]]
}

#[test]
fn words_stay_apart_and_inside_at_every_size() {
    for (width, height) in [(320, 240), (480, 360), (640, 900), (960, 640), (1600, 500), (1920, 1080)] {
        for plot in [season(), study(), many()] {
            let drawing = lay_out(&Plot { width, height, ..plot });
            let level: Vec<[f64; 4]> =
                texts(&drawing).iter().filter(|text| text.direction[1] == 0.0).map(|text| extent(text)).collect();
            for (at, a) in level.iter().enumerate() {
                assert!(
                    a[0] >= 0.0 && a[1] >= 0.0 && a[2] <= f64::from(width) && a[3] <= f64::from(height),
                    "{width} {a:?}"
                );
                for b in &level[at + 1..] {
                    let is_apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
                    assert!(is_apart, "{width} x {height}: {a:?} {b:?}");
                }
            }
        }
    }
}

/// More series than a legend holds, with long names, over wide numbers.
fn many() -> Plot {
    let line = |nth: u32| {
        let points = (0..9).map(|at| [f64::from(at) * 1.0e9, f64::from(at * nth) * -1.0e-7]).collect();
        Series::new(format!("a method with a long name, the number {nth} of forty"), Style::Line, points)
    };
    let panel = Panel { legend: Legend::Ends, ..panel((0..40).map(line).collect()) };
    Plot { title: "t".repeat(500), panels: vec![panel], ..Plot::default() }
}

#[test]
fn names_at_ends_keep_the_order_of_the_ends() {
    let level = |height: f64| Series::new(height.to_string(), Style::Line, vec![[0.0, height], [1.0, height]]);
    let panel = Panel { legend: Legend::Ends, ..panel([1.0, 3.0, 2.0, 2.9].map(level).to_vec()) };
    let drawing = lay_out(&Plot { panels: vec![panel], ..Plot::default() });
    let row = |name: &str| {
        texts(&drawing).iter().filter(|text| text.text == name).map(|text| text.at).next_back().unwrap()[1]
    };
    assert!(row("3") < row("2.9") && row("2.9") < row("2") && row("2") < row("1"));
}

#[test]
fn a_value_that_cannot_be_shown_breaks_the_line() {
    let lines = |scale, hole: f64| {
        let mut points: Vec<[f64; 2]> = (1..=9).map(f64::from).map(|x| [x, x]).collect();
        points[4][1] = hole;
        let series = vec![Series::new("a", Style::Line, points)];
        let panel = Panel { y: Axis { scale, ..Axis::default() }, ..panel(series) };
        let document = svg(&Plot { panels: vec![panel], ..Plot::default() });
        document.split("<g>").nth(1).unwrap().split("</g>").next().unwrap().matches("<polyline").count()
    };
    assert_eq!((lines(Scale::Linear, 2.0), lines(Scale::Linear, f64::NAN)), (1, 2));
    assert_eq!((lines(Scale::Linear, -1.0), lines(Scale::Log, -1.0)), (1, 2));
    assert_eq!(lines(Scale::Linear, f64::INFINITY), 2);
}

#[test]
fn pictures_are_opaque_and_not_blank() {
    for plot in [season(), study(), many()] {
        let picture = picture(&plot);
        assert_eq!((picture.width, picture.height), (960, 640));
        assert!(picture.pixels.iter().all(|pixel| pixel[3] == 255));
        let inked = picture.pixels.iter().filter(|pixel| pixel[0] < 100).count();
        assert!(inked > 1000, "{inked}");
    }
}

#[test]
fn extremes_are_drawn_without_a_panic() {
    const VALUES: [f64; 10] =
        [0.0, -0.0, 1.0, f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let scales = [Scale::Linear, Scale::Log, Scale::Dates { origin: Date::new(9999, 12, 31).unwrap() }];
    for scale in scales {
        for (a, b) in VALUES.iter().flat_map(|&a| VALUES.map(|b| (a, b))) {
            let points = vec![[a, b], [b, a], [a, a]];
            let styles = [Style::Line, Style::Area, Style::Marked(Mark::Square)];
            let of_style = |style| Series { diverged: vec![a], ..Series::new("", style, points.clone()) };
            let series = styles.map(of_style).to_vec();
            let axis = |range| Axis { range, scale, ..Axis::default() };
            let bands = vec![Band { along: Along::Y, from: a, to: b, label: "b".into() }];
            let label = || "g".to_owned();
            let guides = vec![
                Guide::Slope { order: a, through: [b, 1.0], label: label() },
                Guide::Level { y: a, label: label() },
                Guide::Upright { x: b, label: label() },
            ];
            let free = Panel { x: axis(None), y: axis(None), share: a, series, bands, guides, legend: Legend::Ends };
            let asked = Panel { x: axis(Some([a, b])), y: axis(Some([b, a])), ..free.clone() };
            let plot = Plot { width: 90, height: 70, letters: Some(b), panels: vec![free, asked], ..Plot::default() };
            let document = svg(&plot);
            assert!(!document.contains("NaN") && !document.contains("inf"), "{a} {b} {scale:?}");
            assert_eq!(picture(&plot).pixels.len(), 90 * 70);
        }
    }
}

#[test]
fn nothing_at_all_and_no_size_give_paper() {
    let picture = picture(&Plot { width: 0, height: 0, ..Plot::default() });
    assert_eq!((picture.width, picture.height), (64, 64));
    assert!(picture.pixels.iter().all(|pixel| *pixel == [255; 4]));
    assert_eq!(elements(&svg(&Plot::default())), ["svg", "rect"]);
}

#[test]
fn notes_stand_below_the_panels_and_take_their_room() {
    let panel = Panel { series: vec![Series::new("a", Style::Line, vec![[0.0, 1.0], [1.0, 2.0]])], ..Panel::default() };
    let bare = Plot { panels: vec![panel], ..Plot::default() };
    let noted = Plot { notes: vec!["left out: one, which diverged".into(), String::new()], ..bare.clone() };
    let text = svg(&noted);
    assert!(text.contains("left out: one, which diverged") && !svg(&bare).contains("left out"));
    assert_ne!(picture(&bare), picture(&noted));
    let many = Plot { notes: vec!["n".into(); 1000], ..bare };
    assert!(svg(&many).matches(">n<").count() < 40, "the panels keep most of the chart");
}
