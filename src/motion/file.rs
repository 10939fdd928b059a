//! The motion file: what a user writes, read, checked and with all problems named at once.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Deserialize;
use serde::de::IntoDeserializer;

use super::document::{Document, nearest, unknown_fields};
use super::{Change, Class, Motion, MotionSource, source};
use crate::settings::Settings;
use crate::{Error, Problem, Problems, Result};

/// Larger files of numbers are refused before they are read.
pub(crate) const MAX_BYTES: u64 = 50_000_000;

/// Larger motion files are: TOML takes some hundred times its size in memory.
pub(crate) const MAX_TOML_BYTES: u64 = 4_000_000;

/// A motion file: what to do, and with which settings.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionFile {
    /// Name of the design.
    pub name: String,
    /// Class of the follower-support joint.
    pub class: Class,
    /// The motion, with the files it refers to inlined.
    pub source: MotionSource,
    /// All settings, defaults filled in.
    pub settings: Settings,
}

impl MotionFile {
    /// Reads and checks a motion file and everything it refers to.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read; otherwise as [`MotionFile::parse`].
    pub fn read(path: &Path) -> Result<(MotionFile, Motion)> {
        let (file, motion) = MotionFile::read_draft(path)?;
        Ok((file, motion?))
    }

    /// Like [`MotionFile::read`], but a good file with a motion that cannot be that of a gear is
    /// still returned, with [`Error::Infeasible`] in place of the motion.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read, [`Error::Input`] if it is no good.
    pub fn read_draft(path: &Path) -> Result<(MotionFile, Result<Motion>)> {
        MotionFile::read_changed(path, &[])
    }

    /// Like [`MotionFile::read_draft`], of a file in which `changes` are made first.
    ///
    /// # Errors
    /// As there; changes that cannot be made are problems of their fields.
    pub fn read_changed(path: &Path, changes: &[Change]) -> Result<(MotionFile, Result<Motion>)> {
        let text = read_text(path, MAX_TOML_BYTES)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        MotionFile::understand(&text, path, folder, changes)
    }

    /// Checks the `text` of a motion file; `path` is what errors call it, files it refers to are
    /// looked for in `folder`.
    ///
    /// # Errors
    /// [`Error::Input`] with all problems found, [`Error::Infeasible`] if all is well but the
    /// motion cannot be that of a gear, [`Error::Io`] if a file it refers to cannot be read.
    pub fn parse(text: &str, path: &Path, folder: &Path) -> Result<(MotionFile, Motion)> {
        let (file, motion) = MotionFile::understand(text, path, folder, &[])?;
        Ok((file, motion?))
    }

    fn understand(
        text: &str,
        path: &Path,
        folder: &Path,
        changes: &[Change],
    ) -> Result<(MotionFile, Result<Motion>)> {
        let mut document =
            Document::parse(text).map_err(|problem| Error::input(path, vec![problem]))?;
        let mut problems = Problems::default();
        for change in changes {
            problems.extend(change.apply(&mut document.table).err());
        }
        let table = &document.table;
        unknown_fields("", table, &TABLES, &mut problems);
        let name = name(table, path, &mut problems);
        let class = class(table, &mut problems);
        let settings = settings(table, &mut problems);
        problems.extend(settings.problems(class.unwrap_or(Class::R3)));
        let source = source::read(table, folder, &mut problems)?;
        problems.extend(
            source
                .iter()
                .flat_map(|source| settings.cycle_problems(source.cycle())),
        );
        let motion = match (class, &source) {
            (Some(class), Some(source)) => match Motion::new(class, source) {
                Err(Error::Input { problems: list, .. }) => {
                    problems.append(list);
                    None
                }
                other => Some(other),
            },
            _ => None,
        };
        match (class, source, motion) {
            (Some(class), Some(source), Some(motion)) if problems.is_empty() => {
                let file = MotionFile {
                    name,
                    class,
                    source,
                    settings,
                };
                Ok((file, motion))
            }
            _ => {
                source::name_rows(table, &mut problems);
                document.locate(&mut problems);
                Err(Error::input(path, problems))
            }
        }
    }
}

/// Tables and values at the top of a motion file.
const TABLES: [&str; 10] = [
    "name", "class", "motion", "gear", "fit", "hub", "spokes", "support", "search", "load",
];

/// Reads the text of a file of numbers.
///
/// # Errors
/// [`Error::Io`] and [`Error::Input`] when it cannot be read, is too large or no text.
pub fn read_csv(path: &Path) -> Result<String> {
    read_text(path, MAX_BYTES)
}

/// Reads a text file of at most `most` bytes.
pub(crate) fn read_text(path: &Path, most: u64) -> Result<String> {
    let file = File::open(path).map_err(Error::io(path))?;
    let size = file.metadata().map_err(Error::io(path))?.len();
    let refuse = |what: String, hint: &str| {
        let place = path.display().to_string();
        Err(Error::input(path, vec![Problem::new(place, what, hint)]))
    };
    let limit = most / 1_000_000;
    let smaller =
        "some hundred rows of poses describe a motion well; long tables go into a CSV file";
    if size > most {
        let what = format!("the file has {} MB, allowed {limit} MB", size / 1_000_000);
        return refuse(what, smaller);
    }
    let mut bytes = Vec::new();
    // Devices and pipes report no size.
    file.take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(Error::io(path))?;
    if bytes.len() as u64 > most {
        return refuse(format!("the file has more than {limit} MB"), smaller);
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(text),
        Err(e) => refuse(
            format!(
                "the file is not text (UTF-8) from byte {} on",
                e.utf8_error().valid_up_to()
            ),
            "save it as plain text",
        ),
    }
}

/// Longest name of a design, letters.
const LONGEST_NAME: usize = 300;

/// Why `name` cannot be the name of a design, and what to do about it.
pub fn unusable_name(name: &str) -> Option<(String, &'static str)> {
    let letters = name.chars().count();
    if letters > LONGEST_NAME {
        let hint = "the name is a title; longer texts can go into a comment";
        return Some((
            format!("has {letters} letters, allowed {LONGEST_NAME}"),
            hint,
        ));
    }
    // The characters of XML 1.0, which 3MF files and pages are made of, on one line.
    let fits = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    let at = name.chars().position(|c| !fits(c))?;
    let code = name.chars().nth(at).map_or(0, u32::from);
    let what = format!(
        "has U+{code:04X} at letter {}, allowed are U+0020 to U+FFFD and U+10000 on, without control characters",
        at + 1
    );
    Some((what, "remove it: files of CAD programs cannot hold it"))
}

fn name(table: &toml::Table, path: &Path, problems: &mut Problems) -> String {
    let name = given_name(table, path, problems);
    if let Some((what, hint)) = unusable_name(&name) {
        problems.push(Problem::new("name", what, hint));
    }
    name
}

fn given_name(table: &toml::Table, path: &Path, problems: &mut Problems) -> String {
    match table.get("name") {
        Some(toml::Value::String(name)) if !name.trim().is_empty() => name.clone(),
        Some(other) => {
            let what = format!("is {other}, allowed is any text");
            problems.push(Problem::new("name", what, ""));
            String::new()
        }
        None => {
            let stem = path.file_stem().unwrap_or_default();
            stem.to_string_lossy().into_owned()
        }
    }
}

fn class(table: &toml::Table, problems: &mut Problems) -> Option<Class> {
    let names = Class::ALL.map(|class| class.to_string());
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let allowed = format!("allowed \"{}\"", names.join("\", \""));
    let Some(value) = table.get("class") else {
        let what = format!("is missing, {allowed}");
        let hint = "1R turns about z, 1R1T also slides along z, 3R wobbles too, 3R1T does all";
        problems.push(Problem::new("class", what, hint));
        return None;
    };
    let class = value.as_str().and_then(|text| {
        Class::ALL
            .into_iter()
            .find(|class| class.to_string() == text)
    });
    if class.is_none() {
        let upper = value.as_str().unwrap_or_default().to_uppercase();
        let hint =
            nearest(&upper, &names).map_or(String::new(), |n| format!("did you mean \"{n}\"?"));
        problems.push(Problem::new(
            "class",
            format!("is {value}, {allowed}"),
            hint,
        ));
    }
    class
}

/// The settings with defaults for what is missing or unusable; each field is tried on its own so
/// that all problems show at once.
fn settings(table: &toml::Table, problems: &mut Problems) -> Settings {
    let Ok(defaults) = toml::Table::try_from(Settings::default()) else {
        return Settings::default();
    };
    let mut merged = defaults.clone();
    for (section, default) in &defaults {
        let (Some(given), Some(default)) = (table.get(section), default.as_table()) else {
            continue;
        };
        let Some(given) = given.as_table() else {
            let hint = format!("write [{section}]");
            problems.push(Problem::new(section, "is not a table", hint));
            continue;
        };
        let known: Vec<&str> = default.keys().map(String::as_str).collect();
        unknown_fields(section, given, &known, problems);
        for (key, value) in given {
            let Some(default) = default.get(key) else {
                continue;
            };
            let one = toml::Table::from_iter([(key.clone(), value.clone())]);
            let alone = toml::Table::from_iter([(section.clone(), one.into())]);
            match Settings::deserialize(alone.into_deserializer()) {
                Ok(_) => {
                    if let Some(section) = merged.get_mut(section).and_then(|s| s.as_table_mut()) {
                        section.insert(key.clone(), value.clone());
                    }
                }
                Err(e) => {
                    let what = format!("is {value}: {}", plain_type(e.message()));
                    let hint = format!("the default is {default}");
                    problems.push(Problem::new(format!("{section}.{key}"), what, hint));
                }
            }
        }
    }
    let mut settings = Settings::deserialize(merged.into_deserializer()).unwrap_or_default();
    settings.follow(|section, key| {
        let section = table.get(section).and_then(|s| s.as_table());
        section.is_some_and(|s| s.contains_key(key))
    });
    settings
}

/// Names of Rust's number types in words.
fn plain_type(message: &str) -> String {
    message
        .replace("usize", "a whole number of at least 0")
        .replace("u64", "a whole number of at least 0")
        .replace("f64", "a number")
}
