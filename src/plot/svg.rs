//! The chart as an SVG document with real text.

use super::palette::PAPER;
use super::primitive::{Anchor, Drawing, Pen, Pixel, Primitive, Text};
use super::raster::HALO;
use super::words::{POWER_RISE, POWER_SIZE, Run, runs};
use std::fmt::Write;

/// Writes a chart.
pub(super) fn write(drawing: &Drawing) -> String {
    let (width, height) = (drawing.width, drawing.height);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"sans-serif\" stroke-linejoin=\"round\">\n"
    );
    for (element, text) in [("title", &drawing.title), ("desc", &drawing.description)] {
        if !text.is_empty() {
            put(&mut svg, format_args!("<{element}>{}</{element}>\n", escaped(text)));
        }
    }
    put(&mut svg, format_args!("<rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n", colour(PAPER)));
    drawing.items.iter().for_each(|item| write_item(item, &mut svg));
    svg.push_str("</svg>\n");
    svg
}

/// Writing to a string does not fail.
fn put(svg: &mut String, text: std::fmt::Arguments<'_>) {
    let _ = svg.write_fmt(text);
}

fn write_item(item: &Primitive, svg: &mut String) {
    match item {
        Primitive::Polyline { points, pen } => write_polyline(points, pen, svg),
        Primitive::Polygon { points, fill } => {
            put(svg, format_args!("<polygon points=\"{}\" fill=\"{}\"/>\n", listed(points), colour(*fill)));
        }
        Primitive::Text(text) => write_text(text, svg),
        Primitive::Group { name, items } => {
            put(svg, format_args!("<g>\n<title>{}</title>\n", escaped(name)));
            items.iter().for_each(|item| write_item(item, svg));
            svg.push_str("</g>\n");
        }
    }
}

fn write_polyline(points: &[Pixel], pen: &Pen, svg: &mut String) {
    let (points, stroke, width) = (listed(points), colour(pen.colour), short(pen.width));
    put(svg, format_args!("<polyline points=\"{points}\" fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{width}\""));
    if let Some([dash, gap]) = pen.dashes {
        put(svg, format_args!(" stroke-dasharray=\"{} {}\"", short(dash), short(gap)));
    }
    svg.push_str("/>\n");
}

fn write_text(text: &Text, svg: &mut String) {
    let (x, y) = (short(text.at[0]), short(text.at[1]));
    put(svg, format_args!("<text x=\"{x}\" y=\"{y}\" font-size=\"{}\"", short(text.size)));
    put(svg, format_args!(" fill=\"{}\"", colour(text.colour)));
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => svg.push_str(" text-anchor=\"middle\""),
        Anchor::End => svg.push_str(" text-anchor=\"end\""),
    }
    if text.is_bold {
        svg.push_str(" font-weight=\"600\"");
    }
    if text.halo {
        let (stroke, width) = (colour(PAPER), short(text.size * HALO));
        put(svg, format_args!(" stroke=\"{stroke}\" stroke-width=\"{width}\" paint-order=\"stroke\""));
    }
    if text.direction != [1.0, 0.0] {
        put(svg, format_args!(" transform=\"{}\"", turned(text)));
    }
    svg.push('>');
    write_runs(&runs(&text.text), text.size, svg);
    svg.push_str("</text>\n");
}

/// The turn about the text's place that lays it in its direction.
fn turned(text: &Text) -> String {
    let ([right, down], [x, y]) = (text.direction, text.at);
    let back = [x - right * x + down * y, y - down * x - right * y];
    format!("matrix({right:.5} {down:.5} {:.5} {right:.5} {} {})", -down, short(back[0]), short(back[1]))
}

/// Powers are raised, and the base line comes back after them.
fn write_runs(runs: &[Run], size: f64, svg: &mut String) {
    let mut rise = 0.0;
    for run in runs {
        let wanted = if run.is_power { size * POWER_RISE } else { 0.0 };
        let words = escaped(&run.text);
        if run.is_power {
            let (shift, small) = (short(rise - wanted), short(size * POWER_SIZE));
            put(svg, format_args!("<tspan dy=\"{shift}\" font-size=\"{small}\">{words}</tspan>"));
        } else if rise == wanted {
            svg.push_str(&words);
        } else {
            put(svg, format_args!("<tspan dy=\"{}\">{words}</tspan>", short(rise - wanted)));
        }
        rise = wanted;
    }
}

fn listed(points: &[Pixel]) -> String {
    points.iter().map(|point| format!("{},{}", short(point[0]), short(point[1]))).collect::<Vec<_>>().join(" ")
}

/// A hundredth of a pixel is enough.
fn short(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn colour([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Text as it may stand between tags and in attributes. The layout has taken out what XML forbids.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            letter => safe.push(letter),
        }
    }
    safe
}
