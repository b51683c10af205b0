//! Tables of a study as comma-separated values, and which of their columns may differ from run to run.

use super::numbers::shown;

/// Beginnings of the names of columns that depend on the machine and the moment; all other columns are the same in every run.
pub const VOLATILE: [&str; 6] = ["cpu_", "ratio_", "instructions", "load", "memory_", "seconds"];

/// Whether a column may differ between two runs.
#[must_use]
pub fn is_volatile(column: &str) -> bool {
    VOLATILE.iter().any(|beginning| column.starts_with(beginning))
}

/// One field of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Field {
    /// Words; quoted where they need it.
    Text(String),
    /// A figure; empty when there is none.
    Number(Option<f64>),
    /// A count.
    Count(u64),
}

impl From<&str> for Field {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Field {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Field {
    fn from(value: f64) -> Self {
        Self::Number(Some(value))
    }
}

impl From<Option<f64>> for Field {
    fn from(value: Option<f64>) -> Self {
        Self::Number(value)
    }
}

impl From<u64> for Field {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<usize> for Field {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<u32> for Field {
    fn from(count: u32) -> Self {
        Self::Count(u64::from(count))
    }
}

impl From<bool> for Field {
    fn from(is: bool) -> Self {
        Self::Text(is.to_string())
    }
}

impl Field {
    /// The field as it stands in a file.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::Text(text) if text.contains([',', '"', '\n', '\r']) => format!("\"{}\"", text.replace('"', "\"\"")),
            Self::Text(text) => text.clone(),
            Self::Number(value) => value.map_or_else(String::new, shown),
            Self::Count(count) => count.to_string(),
        }
    }
}

/// Rows under named columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The names of the columns.
    pub columns: Vec<&'static str>,
    /// The rows, each as long as `columns`.
    pub rows: Vec<Vec<Field>>,
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new(columns: &[&'static str]) -> Self {
        Self { columns: columns.to_vec(), rows: Vec::new() }
    }

    /// Adds a row; missing fields at its end are empty.
    pub fn push(&mut self, mut row: Vec<Field>) {
        row.resize(self.columns.len(), Field::Number(None));
        self.rows.push(row);
    }

    /// As comma-separated values with a header.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = self.columns.join(",") + "\n";
        for row in &self.rows {
            text.push_str(&row.iter().map(Field::text).collect::<Vec<_>>().join(","));
            text.push('\n');
        }
        text
    }

    /// As a table for people, in Markdown, of some of the columns.
    #[must_use]
    pub fn markdown(&self, columns: &[&str]) -> String {
        let places: Vec<usize> =
            columns.iter().filter_map(|name| self.columns.iter().position(|known| known == name)).collect();
        let line = |fields: Vec<String>| format!("| {} |\n", fields.join(" | "));
        let mut text = line(places.iter().map(|&place| self.columns[place].to_owned()).collect());
        text.push_str(&line(vec!["---".to_owned(); places.len()]));
        for row in &self.rows {
            text.push_str(&line(places.iter().map(|&place| row[place].text().replace('|', "/")).collect()));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_quoted_where_they_must_be() {
        let mut table = Table::new(&["a", "cpu_ms", "c"]);
        table.push(vec!["x, \"y\"".into(), 1.5.into()]);
        assert_eq!(table.csv(), "a,cpu_ms,c\n\"x, \"\"y\"\"\",1.5,\n");
        assert_eq!(table.markdown(&["a", "c"]), "| a | c |\n| --- | --- |\n| \"x, \"\"y\"\"\" |  |\n");
    }

    #[test]
    fn columns_of_time_are_known_by_their_names() {
        assert!(is_volatile("cpu_ms_median") && is_volatile("ratio_to_baseline") && !is_volatile("error"));
    }
}
