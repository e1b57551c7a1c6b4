//! CSV tables: quoting as RFC 4180, numbers that read back to the same bits.

use std::path::Path;

use crate::OutputError;
use crate::atomic::write_text;
use crate::text::number;

/// One entry of a [`Table`].
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A real number; `NaN`, `inf` and `-inf` are written so.
    Number(f64),
    /// A count.
    Count(u64),
    /// Words, quoted where needed.
    Text(String),
    /// Nothing.
    Empty,
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<u64> for Cell {
    fn from(value: u64) -> Self {
        Self::Count(value)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::Count(value as u64)
    }
}

impl From<&str> for Cell {
    fn from(value: &str) -> Self {
        Self::Text(value.into())
    }
}

impl From<String> for Cell {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

/// A table with named columns, kept as text and written whole or not at all.
#[derive(Debug, Clone)]
pub struct Table {
    columns: usize,
    rows: usize,
    text: String,
}

impl Table {
    /// A table without rows. Put units into the column names, for example `time [s]`.
    pub fn new(columns: &[&str]) -> Self {
        let names: Vec<String> = columns.iter().map(|c| quoted(c)).collect();
        Self { columns: columns.len(), rows: 0, text: names.join(",") + "\n" }
    }

    /// Appends a row.
    ///
    /// # Errors
    /// [`OutputError::Request`] unless there is one cell per column.
    pub fn push<const N: usize>(&mut self, row: [Cell; N]) -> Result<(), OutputError> {
        self.push_slice(&row)
    }

    /// Appends a row whose length is known only at run time.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    pub fn push_slice(&mut self, row: &[Cell]) -> Result<(), OutputError> {
        if row.len() != self.columns {
            let reason = format!("row {} has {} cells for {} columns", self.rows, row.len(), self.columns);
            return Err(OutputError::request("table", reason));
        }
        let cells: Vec<String> = row
            .iter()
            .map(|cell| match cell {
                Cell::Number(value) => number(*value),
                Cell::Count(value) => value.to_string(),
                Cell::Text(text) => quoted(text),
                Cell::Empty => String::new(),
            })
            .collect();
        self.text += &cells.join(",");
        self.text.push('\n');
        self.rows += 1;
        Ok(())
    }

    /// Number of rows, the names not counted.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The table as CSV text, lines ended by `\n`.
    pub fn csv(&self) -> &str {
        &self.text
    }

    /// Writes the CSV text.
    ///
    /// # Errors
    /// As [`write_atomic`](crate::write_atomic).
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        write_text(path, &self.text)
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) || text.trim() != text {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_only_where_needed() {
        let mut table = Table::new(&["time [s]", "a,b", "note"]);
        table.push([0.1.into(), 3_usize.into(), "say \"x\",\nthen".into()]).unwrap();
        table.push([f64::NAN.into(), Cell::Empty, " padded".into()]).unwrap();
        let expected = "time [s],\"a,b\",note\n0.1,3,\"say \"\"x\"\",\nthen\"\nNaN,,\" padded\"\n";
        assert_eq!(table.csv(), expected);
        assert_eq!(table.rows(), 2);
    }

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        let mut table = Table::new(&["x"]);
        let values = [0.1 + 0.2, 1e-300, f64::MAX, -0.0, 1.0 / 3.0];
        for v in values {
            table.push([v.into()]).unwrap();
        }
        for (line, v) in table.csv().lines().skip(1).zip(values) {
            assert_eq!(line.parse::<f64>().unwrap().to_bits(), v.to_bits());
        }
    }

    #[test]
    fn rows_of_the_wrong_length_are_refused() {
        let mut table = Table::new(&["x", "y"]);
        assert!(table.push([1.0.into()]).unwrap_err().to_string().contains("2 columns"));
        assert_eq!(table.rows(), 0);
    }
}
