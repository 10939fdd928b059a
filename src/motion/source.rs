//! The `[motion]` table of a motion file, with the files it refers to read in.

use std::path::Path;

use serde::Deserialize;
use serde::de::IntoDeserializer;

use super::document::{nearest, unknown_fields};
use super::{MotionSource, file, path, table};
use crate::{Error, Problem, Problems, Result};

/// The kinds of motion, with their fields.
const KINDS: [(&str, &[&str]); 4] = [
    ("table", &["kind", "file", "rows"]),
    ("keyframes", &["kind", "own_turn", "keyframes"]),
    (
        "formula",
        &[
            "kind",
            "constants",
            "own_turn",
            "axis",
            "rotation",
            "translation",
            "drive",
            "range_deg",
        ],
    ),
    ("path", &["kind", "file", "points", "own_turn", "radius_mm"]),
];

/// Fields of one keyframe.
const KEYFRAME: [&str; 4] = ["phi_deg", "position", "rotation_deg", "quaternion"];

/// Reads `[motion]`; `None` if that is impossible, and why is then among the `problems`.
///
/// # Errors
/// [`crate::Error::Io`] and others if a file it refers to cannot be read.
pub(super) fn read(
    document: &toml::Table,
    folder: &Path,
    problems: &mut Problems,
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
    unknown_fields("motion", given, fields, problems);
    if let Some(toml::Value::Array(keyframes)) = given.get("keyframes") {
        for (i, keyframe) in keyframes.iter().enumerate() {
            if let Some(keyframe) = keyframe.as_table() {
                let path = format!("motion.keyframes[{}]", i + 1);
                unknown_fields(&path, keyframe, &KEYFRAME, problems);
            }
        }
    }
    let mut motion = given.clone();
    if fields.contains(&"file")
        && let Some(name) = motion.remove("file")
    {
        match inline(kind, &name, folder)? {
            Ok((field, values)) if !given.contains_key(field) => {
                motion.insert(field.to_owned(), values);
            }
            Ok((field, _)) => {
                let what = format!("has both `file` and `{field}`");
                problems.push(Problem::new("motion", what, "keep one of them"));
            }
            Err(list) => problems.append(list),
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

/// Rows of a pose table in a file of its own are called by that file's name.
pub(super) fn name_rows(document: &toml::Table, problems: &mut Problems) {
    let motion = document.get("motion").and_then(toml::Value::as_table);
    let Some(name) = motion.and_then(|m| m.get("file")?.as_str()) else {
        return;
    };
    for problem in problems.first_mut() {
        problem.place = problem
            .place
            .replace("motion row", &format!("{name} row"))
            .replace("motion.points[", &format!("{name} point ["));
    }
}

/// The kind of motion.
fn kind(given: &toml::Table, problems: &mut Problems) -> Option<&'static str> {
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
type Inlined = std::result::Result<(&'static str, toml::Value), Problems>;

fn inline(kind: &str, name: &toml::Value, folder: &Path) -> Result<Inlined> {
    let Some(name) = name.as_str() else {
        let what = format!("is {name}, allowed is the path of a CSV file in quotes");
        return Ok(Err(vec![Problem::new("motion.file", what, "")].into()));
    };
    let path = folder.join(name);
    // To open a pipe is to wait for its writer.
    let found = std::fs::metadata(&path).map_err(Error::io(&path))?;
    if !found.is_file() {
        let what = format!("`{name}` is a {}, not a file", kind_of(&found));
        let hint = "give the path of a CSV file";
        return Ok(Err(vec![Problem::new("motion.file", what, hint)].into()));
    }
    let text = file::read_text(&path, file::MAX_BYTES)?;
    Ok(match kind {
        "path" => path::parse_points(&text, name).map(|points| ("points", points)),
        _ => table::parse_rows(&text, name).map(|rows| ("rows", rows)),
    }
    .map(|(field, rows)| (field, numbers(&rows))))
}

/// What something that is no file is.
fn kind_of(found: &std::fs::Metadata) -> &'static str {
    match found.is_dir() {
        true => "folder",
        false => "pipe or device",
    }
}

/// Rows of numbers as a TOML value.
fn numbers(rows: &[Vec<f64>]) -> toml::Value {
    let row = |row: &Vec<f64>| toml::Value::Array(row.iter().map(|v| (*v).into()).collect());
    toml::Value::Array(rows.iter().map(row).collect())
}
