//! Tables of text, written for terminals, spreadsheets or Markdown.

use crate::{Error, Result, escape};

/// How a table is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Format {
    /// Columns in line, for terminals.
    #[default]
    Text,
    /// Comma separated, with a header line.
    Csv,
    /// A Markdown table.
    Markdown,
}

/// A table of text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Headings.
    pub columns: Vec<String>,
    /// This many columns hold names; the rest hold numbers.
    pub names: usize,
    /// Rows of as many cells as there are columns.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// One object per row with the headings as keys; names are text, numbers are numbers or `null`.
    pub fn records(&self) -> Vec<serde_json::Value> {
        let value = |i: usize, cell: &String| match cell.parse::<f64>() {
            Ok(number) if i >= self.names => number.into(),
            _ if cell == "–" => serde_json::Value::Null,
            _ => cell.as_str().into(),
        };
        let record = |row: &Vec<String>| {
            let cells = self.columns.iter().zip(row).enumerate();
            cells
                .map(|(i, (column, cell))| (column.clone(), value(i, cell)))
                .collect::<serde_json::Map<_, _>>()
                .into()
        };
        self.rows.iter().map(record).collect()
    }

    /// The table as text that ends with a line break.
    ///
    /// # Errors
    /// [`Error::Internal`] when the CSV writer fails.
    pub fn render(&self, format: Format) -> Result<String> {
        Ok(match format {
            Format::Csv => return self.csv(),
            Format::Markdown => {
                let escaped = |cells: &[String]| {
                    cells
                        .iter()
                        .map(|c| escape::markdown(c))
                        .collect::<Vec<_>>()
                        .join(" | ")
                };
                let mut text = format!(
                    "| {} |\n|{}\n",
                    self.columns.join(" | "),
                    "---|".repeat(self.columns.len())
                );
                for row in &self.rows {
                    text += &format!("| {} |\n", escaped(row));
                }
                text
            }
            Format::Text => self.aligned(),
        })
    }

    fn csv(&self) -> Result<String> {
        let failed = |e: &dyn std::fmt::Display| Error::Internal(format!("table: {e}"));
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.columns).map_err(|e| failed(&e))?;
        for row in &self.rows {
            // What a dash stands for is an empty cell to a spreadsheet.
            let row = row.iter().map(|cell| match cell.as_str() {
                "–" => String::new(),
                cell => escape::cell(cell),
            });
            writer.write_record(row).map_err(|e| failed(&e))?;
        }
        let bytes = writer.into_inner().map_err(|e| failed(&e))?;
        String::from_utf8(bytes).map_err(|e| failed(&e))
    }

    /// Names to the left, numbers to the right.
    fn aligned(&self) -> String {
        let width = |i: usize| {
            let cells = self.rows.iter().map(|r| r[i].chars().count());
            cells
                .chain([self.columns[i].chars().count()])
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |cells: Vec<&str>| {
            let padded: Vec<String> = cells
                .iter()
                .zip(&widths)
                .enumerate()
                .map(|(i, (cell, &w))| {
                    if i < self.names {
                        format!("{cell:<w$}")
                    } else {
                        format!("{cell:>w$}")
                    }
                })
                .collect();
            padded.join("  ").trim_end().to_string() + "\n"
        };
        let mut text = line(self.columns.iter().map(String::as_str).collect());
        for row in &self.rows {
            text += &line(row.iter().map(String::as_str).collect());
        }
        text
    }
}
