//! CSV files of plain numbers, with every problem named by line and column.

use super::rows::cut;
use crate::Problem;

/// Rows of as many numbers as there are `columns`. A first line with the column names is optional, lines that
/// begin with `#` and empty lines are skipped.
pub(super) fn parse(
    text: &str,
    name: &str,
    columns: &[&str],
) -> Result<Vec<Vec<f64>>, Vec<Problem>> {
    let hint = format!("the columns are {}", columns.join(","));
    let hint = hint.as_str();
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut rows = Vec::new();
    let mut problems = Vec::new();
    for (index, record) in reader.records().enumerate() {
        let record = match record {
            Ok(record) => record,
            Err(e) => {
                problems.push(Problem::new(name, format!("is not CSV: {e}"), hint));
                break;
            }
        };
        let line = record.position().map_or(0, csv::Position::line);
        let place = format!("{name} line {line}");
        let is_header = index == 0 && record.iter().all(|field| field.parse::<f64>().is_err());
        if is_header {
            if !record.iter().eq(columns.iter().copied()) {
                let found = record.iter().collect::<Vec<_>>().join(",");
                problems.push(Problem::new(
                    place,
                    format!("the columns are `{found}`"),
                    hint,
                ));
            }
            continue;
        }
        if record.len() != columns.len() {
            let what = format!("has {} values, {} are needed", record.len(), columns.len());
            problems.push(Problem::new(place, what, hint));
            continue;
        }
        let mut row = Vec::with_capacity(columns.len());
        for (field, column) in record.iter().zip(columns) {
            match field.parse::<f64>() {
                Ok(value) if value.is_finite() => row.push(value),
                _ => problems.push(Problem::new(
                    &place,
                    format!("{column} is `{field}`, not a finite number"),
                    "",
                )),
            }
        }
        rows.push(row);
    }
    if problems.is_empty() {
        Ok(rows)
    } else {
        Err(cut(problems))
    }
}
