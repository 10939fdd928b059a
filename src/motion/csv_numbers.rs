//! CSV files of plain numbers, with every problem named by line and column.

use crate::{Problem, Problems};

/// Most rows of a file.
const MAX_ROWS: usize = 100_000;

/// Longest line, bytes.
const MAX_LINE: usize = 10_000;

/// A row of numbers and the line that it is on.
pub(super) type Line = (u64, Vec<f64>);

/// Rows of as many numbers as there are `columns`. A first line with the column names is optional, lines that
/// begin with `#` and empty lines are skipped.
pub(super) fn parse(text: &str, name: &str, columns: &[&str]) -> Result<Vec<Vec<f64>>, Problems> {
    let lines = parse_lines(text, name, columns)?;
    Ok(lines.into_iter().map(|(_, row)| row).collect())
}

/// [`parse`], with the line of every row.
pub(super) fn parse_lines(text: &str, name: &str, columns: &[&str]) -> Result<Vec<Line>, Problems> {
    let hint = format!("the columns are {}", columns.join(","));
    let hint = hint.as_str();
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if let Some((index, line)) = text
        .split('\n')
        .enumerate()
        .find(|(_, line)| line.len() > MAX_LINE)
    {
        let what = format!(
            "has {} characters, allowed {MAX_LINE}",
            line.chars().count()
        );
        return Err(vec![Problem::new(
            format!("{name} line {}", index + 1),
            what,
            hint,
        )]
        .into());
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut rows = Vec::new();
    let mut problems = Problems::default();
    for (index, record) in reader.records().enumerate() {
        let record = match record {
            Ok(record) => record,
            Err(e) => {
                problems.push(Problem::new(name, format!("is not CSV: {e}"), hint));
                break;
            }
        };
        let line = record.position().map_or(0, csv::Position::line);
        if index > MAX_ROWS {
            let what = format!("the file has more than {MAX_ROWS} rows");
            problems.push(Problem::new(
                name,
                what,
                "some hundred rows describe a motion well",
            ));
            break;
        }
        let place = || format!("{name} line {line}");
        let is_header = index == 0 && record.iter().all(|field| field.parse::<f64>().is_err());
        if is_header {
            if !record.iter().eq(columns.iter().copied()) {
                let found = record.iter().collect::<Vec<_>>().join(",");
                let what = format!("the columns are `{found}`");
                problems.push(Problem::new(place(), what, hint));
            }
            continue;
        }
        if record.len() != columns.len() {
            problems.add(|| {
                let what = format!("has {} values, {} are needed", record.len(), columns.len());
                Problem::new(place(), what, hint)
            });
            continue;
        }
        let mut row = Vec::with_capacity(columns.len());
        for (field, column) in record.iter().zip(columns) {
            match field.parse::<f64>() {
                Ok(value) if value.is_finite() => row.push(value),
                _ => problems.add(|| {
                    let what = format!("{column} is `{field}`, not a finite number");
                    Problem::new(place(), what, "")
                }),
            }
        }
        rows.push((line, row));
    }
    if problems.is_empty() {
        Ok(rows)
    } else {
        Err(problems)
    }
}
