//! The `[motion]` table of a motion file, with the files it refers to read in.

use std::path::Path;

use serde::Deserialize;
use serde::de::IntoDeserializer;

use super::document::{nearest, unknown_fields};
use super::{MotionSource, file, table};
use crate::{Problem, Result};

/// The kinds of motion, with their fields.
const KINDS: [(&str, &[&str]); 2] = [
    ("table", &["kind", "file", "rows"]),
    (
        "formula",
        &[
            "kind",
            "constants",
            "own_turn",
            "axis",
            "rotation",
            "translation",
        ],
    ),
];

/// Reads `[motion]`; `None` if that is impossible, and why is then among the `problems`.
///
/// # Errors
/// [`crate::Error::Io`] and others if a file it refers to cannot be read.
pub(super) fn read(
    document: &toml::Table,
    folder: &Path,
    problems: &mut Vec<Problem>,
) -> Result<Option<MotionSource>> {
    let before = problems.len();
    let Some(toml::Value::Table(given)) = document.get("motion") else {
        let hint = "write [motion] and, below it, kind = \"…\"";
        problems.push(Problem::new(
            "motion",
            "the table [motion] is missing",
            hint,
        ));
        return Ok(None);
    };
    let Some(kind) = kind(given, problems) else {
        return Ok(None);
    };
    let fields = KINDS.iter().find(|(name, _)| *name == kind);
    let fields = fields.map_or(&[][..], |(_, fields)| fields);
    problems.extend(unknown_fields("motion", given, fields));
    let mut motion = given.clone();
    if let Some(name) = motion.remove("file") {
        match inline(kind, &name, folder)? {
            Ok((field, values)) if !given.contains_key(field) => {
                motion.insert(field.to_owned(), values);
            }
            Ok((field, _)) => {
                let what = format!("has both `file` and `{field}`");
                problems.push(Problem::new("motion", what, "keep one of them"));
            }
            Err(list) => problems.extend(list),
        }
    }
    if problems.len() > before {
        return Ok(None);
    }
    match MotionSource::deserialize(motion.into_deserializer()) {
        Ok(source) => Ok(Some(source)),
        Err(e) => {
            problems.push(Problem::new("motion", e.message().to_owned(), ""));
            Ok(None)
        }
    }
}

/// The kind of motion.
fn kind(given: &toml::Table, problems: &mut Vec<Problem>) -> Option<&'static str> {
    let names = KINDS.map(|(name, _)| name);
    let allowed = format!("allowed \"{}\"", names.join("\", \""));
    let Some(value) = given.get("kind") else {
        problems.push(Problem::new(
            "motion.kind",
            format!("is missing, {allowed}"),
            "",
        ));
        return None;
    };
    let text = value.as_str().unwrap_or_default();
    let kind = names.into_iter().find(|name| *name == text);
    if kind.is_none() {
        let hint =
            nearest(text, &names).map_or(String::new(), |n| format!("did you mean \"{n}\"?"));
        problems.push(Problem::new(
            "motion.kind",
            format!("is {value}, {allowed}"),
            hint,
        ));
    }
    kind
}

/// Name of the field that the file stands for, and its content; or what is wrong in the file.
type Inlined = std::result::Result<(&'static str, toml::Value), Vec<Problem>>;

fn inline(kind: &str, name: &toml::Value, folder: &Path) -> Result<Inlined> {
    let Some(name) = name.as_str() else {
        let what = format!("is {name}, allowed is the path of a CSV file in quotes");
        return Ok(Err(vec![Problem::new("motion.file", what, "")]));
    };
    let text = file::read_text(&folder.join(name))?;
    let rows = match kind {
        _ => table::parse_rows(&text, name).map(|rows| ("rows", numbers(&rows))),
    };
    Ok(rows)
}

/// Rows of numbers as a TOML value.
fn numbers<const N: usize>(rows: &[[f64; N]]) -> toml::Value {
    let row = |row: &[f64; N]| toml::Value::Array(row.iter().map(|v| (*v).into()).collect());
    toml::Value::Array(rows.iter().map(row).collect())
}
