//! Studies: what the program makes, measured and held against what is known, as tables that a command prints.
//!
//! A study is a list of lines; a line is a figure, what is asked of it and whether it is met. Nothing here draws a picture
//! of a scene or is needed by one.

mod expectation;
mod silhouette;
mod stature;
pub mod trees;

/// One figure of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What was measured: `red-maple at 25 years`.
    pub subject: String,
    /// The figure's name, with its unit: `height_m`.
    pub figure: String,
    /// What came out; `None` when there was nothing to measure.
    pub value: Option<f64>,
    /// The range asked for.
    pub asked: [f64; 2],
    /// The range that passes: as asked where a flora or paper says so, wider where it is a judgement.
    pub passes: [f64; 2],
    /// `S` for what is read in a flora or paper, `E` for a judgement, `=` for an identity.
    pub standing: char,
}

impl Line {
    /// Whether the figure is in the range that passes.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.value.is_some_and(|value| (self.passes[0]..=self.passes[1]).contains(&value))
    }
}

/// The lines as a table for people.
#[must_use]
pub fn table(lines: &[Line]) -> String {
    let mut text = String::new();
    let mut subject = "";
    for line in lines {
        if line.subject != subject {
            subject = &line.subject;
            text.push_str(&format!("{subject}\n"));
        }
        let value = line.value.map_or_else(|| "none".to_owned(), figure);
        let asked = format!("{} to {}", figure(line.asked[0]), figure(line.asked[1]));
        let met = match (line.is_met(), line.value) {
            (true, Some(value)) if (line.asked[0]..=line.asked[1]).contains(&value) => "met",
            (true, _) => "met within a fifth",
            (false, _) => "NOT MET",
        };
        text.push_str(&format!("  {:<22} {value:>10}   {}  {asked:<18} {met}\n", line.figure, line.standing));
    }
    let missed = lines.iter().filter(|line| !line.is_met()).count();
    text.push_str(&format!("{} of {} lines met\n", lines.len() - missed, lines.len()));
    text
}

/// The lines as comma-separated values with a header.
#[must_use]
pub fn csv(lines: &[Line]) -> String {
    let mut text = "subject,figure,value,standing,asked_low,asked_high,passes_low,passes_high,met\n".to_owned();
    for line in lines {
        let value = line.value.map_or_else(String::new, |value| value.to_string());
        let ([low, high], [least, most]) = (line.asked, line.passes);
        let subject = format!("\"{}\"", line.subject.replace('"', "\"\""));
        let (name, standing, met) = (&line.figure, line.standing, line.is_met());
        text.push_str(&format!("{subject},{name},{value},{standing},{low},{high},{least},{most},{met}\n"));
    }
    text
}

/// Three significant digits, or a whole number.
fn figure(value: f64) -> String {
    match value.abs() {
        size if value == value.round() && size < 1e6 => format!("{value}"),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
