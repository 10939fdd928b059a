//! A trial's name and its record.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use toml::{Table, Value};

use crate::motion::Change;
use crate::motion::file::{MAX_BYTES, MAX_TOML_BYTES, read_text};
use crate::{Error, Problem, Result};

/// How far a trial goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// Bodies and figures of a choice that is neither polished nor proved.
    Draft,
    /// Searched, polished and proved.
    Design,
}

/// What came of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// A gear: of a draft its bodies, of a design its proof.
    Complete,
    /// No gear, and the reason.
    Infeasible,
    /// The program crashed or took too long; it is not tried again.
    Poisoned,
}

/// `trial.json`: what came of a trial. It is written last, so a folder that has it is complete.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of its folder.
    pub key: String,
    /// Key of the motion file that was varied.
    pub base: String,
    /// The fields that were set, by path.
    pub set: BTreeMap<String, serde_json::Value>,
    /// How far it went.
    pub stage: Stage,
    /// What came of it.
    pub state: State,
    /// Why it is no gear; empty where it is.
    pub reason: String,
    /// Figures by name ([`super::measures::MEASURES`]); `null` where there is none.
    pub figures: BTreeMap<String, Option<f64>>,
    /// Time that it took, s.
    pub seconds: f64,
    /// Time of all cores together, s; `null` where the system does not tell.
    pub cpu_seconds: Option<f64>,
    /// Largest memory, MB; `null` where the system does not tell.
    pub memory_mb: Option<f64>,
    /// `mpcgear` version.
    pub version: String,
}

/// Name of the record in a trial's folder.
pub const RECORD: &str = "trial.json";

/// What a trial is made from.
#[derive(Debug, Clone)]
pub struct Trial<'a> {
    /// Motion file.
    pub motion: &'a Path,
    /// What is changed in it.
    pub changes: &'a [Change],
    /// How far it goes.
    pub stage: Stage,
}

impl Trial<'_> {
    /// A record of this trial with nothing found yet.
    ///
    /// # Errors
    /// As [`Trial::key`].
    pub fn record(&self) -> Result<Record> {
        let set = self.changes.iter().map(|change| {
            let value = serde_json::to_value(&change.value);
            Ok((change.path.clone(), value.map_err(internal)?))
        });
        Ok(Record {
            key: self.key()?,
            base: base(self.motion)?,
            set: set.collect::<Result<_>>()?,
            stage: self.stage,
            state: State::Infeasible,
            reason: String::new(),
            figures: BTreeMap::new(),
            seconds: 0.0,
            cpu_seconds: None,
            memory_mb: None,
            version: env!("CARGO_PKG_VERSION").into(),
        })
    }

    /// Name of the trial's folder: a hash of the changed motion file without its comments and its name, the
    /// file that it refers to, the stage and the version of the program.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::Input`] for files that cannot be read.
    pub fn key(&self) -> Result<String> {
        key(self.motion, self.changes, Some(self.stage))
    }
}

/// Key of a motion file as it is: trials with the same one varied the same file.
///
/// # Errors
/// As [`Trial::key`].
pub fn base(motion: &Path) -> Result<String> {
    key(motion, &[], None)
}

fn key(motion: &Path, changes: &[Change], stage: Option<Stage>) -> Result<String> {
    let text = read_text(motion, MAX_TOML_BYTES)?;
    let mut table: Table = toml::from_str(&text).map_err(|e| {
        let problem = Problem::new("file", format!("is not TOML: {}", e.message()), "");
        Error::input(motion, problem)
    })?;
    for change in changes {
        // A change that cannot be made is told when the trial is; here it only has to count.
        if change.apply(&mut table).is_err() {
            table.insert(change.to_string(), Value::Boolean(true));
        }
    }
    table.remove("name");
    let rows = table.get("motion").and_then(|m| m.get("file")?.as_str());
    let rows = rows.map(|name| read_text(&crate::disk::folder_of(motion).join(name), MAX_BYTES));
    let whole = serde_json::json!({
        "motion": canonical(&Value::Table(table.clone())),
        "file": rows.transpose()?,
        "stage": stage,
        "version": env!("CARGO_PKG_VERSION"),
    });
    let digest = Sha256::digest(serde_json::to_vec(&whole).map_err(internal)?);
    let letters = digest.iter().take(KEY_BYTES).map(|b| format!("{b:02x}"));
    Ok(letters.collect())
}

/// Bytes of a key: with ten thousand trials, equal ones are as likely as 1 in 10^21.
const KEY_BYTES: usize = 12;

/// The value with all numbers alike: 25 is 25.0.
fn canonical(value: &Value) -> serde_json::Value {
    match value {
        Value::Integer(i) => (*i as f64).into(),
        Value::Float(f) if f.is_finite() => (*f).into(),
        Value::Boolean(b) => (*b).into(),
        Value::Array(rows) => rows.iter().map(canonical).collect(),
        Value::Table(table) => {
            let mut fields: Vec<_> = table.iter().collect();
            fields.sort_by_key(|(name, _)| *name);
            let fields = fields.into_iter().map(|(k, v)| (k.clone(), canonical(v)));
            serde_json::Value::Object(fields.collect())
        }
        other => other.to_string().into(),
    }
}

fn internal(error: serde_json::Error) -> Error {
    Error::Internal(format!("{RECORD}: {error}"))
}

impl Record {
    /// The record in the folder of the trial `key`; `None` where it is not complete.
    pub fn read(folder: &Path) -> Option<Record> {
        let text = std::fs::read(folder.join(RECORD)).ok()?;
        serde_json::from_slice(&text).ok()
    }

    /// The record as a file of its folder.
    ///
    /// # Errors
    /// [`Error::Internal`] when the encoder fails.
    pub fn file(&self) -> Result<crate::export::File> {
        let mut text = serde_json::to_vec_pretty(self).map_err(internal)?;
        text.push(b'\n');
        Ok(crate::export::File::new(PathBuf::from(RECORD), text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key_of(text: &str, changes: &[&str], stage: Stage) -> String {
        let folder = tempfile::tempdir().expect("a folder");
        let motion = folder.path().join("my.toml");
        std::fs::write(&motion, text).expect("written");
        let changes: std::result::Result<Vec<_>, _> =
            changes.iter().map(|c| Change::parse(c)).collect();
        let changes = changes.expect("changes");
        let trial = Trial {
            motion: &motion,
            changes: &changes,
            stage,
        };
        trial.key().expect("a key")
    }

    #[test]
    fn a_key_stands_for_what_is_computed_and_nothing_else() {
        const TEXT: &str = "class = \"1R\"\n[gear]\nteeth = 10\n";
        let key = |text: &str, changes: &[&str]| key_of(text, changes, Stage::Draft);
        let plain = key(TEXT, &[]);
        assert_eq!(
            plain,
            key(&format!("# a comment\nname = \"x\"\n{TEXT}"), &[])
        );
        assert_eq!(plain, key(TEXT, &["gear.teeth=10.0"]));
        assert_eq!(
            key(TEXT, &["gear.teeth=12", "gear.tip_mm=0.5"]),
            key(TEXT, &["gear.tip_mm=0.5", "gear.teeth=12"])
        );
        assert_ne!(plain, key(TEXT, &["gear.teeth=12"]));
        assert_ne!(plain, key_of(TEXT, &[], Stage::Design));
    }
}
