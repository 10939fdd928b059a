//! The study file: what is varied, what is wanted, how long it may take.

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::Value;

use super::reader::Reader;
use super::trial::Stage;
use crate::motion::document::{Document, unknown_fields};
use crate::motion::file::{MAX_TOML_BYTES, read_text};
use crate::motion::{Change, MotionFile};
use crate::{Error, Problem, Problems, Result};

/// Values that a variable may have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Range {
    /// Any number, or every `step` from `low`.
    Number {
        /// Least.
        low: f64,
        /// Largest.
        high: f64,
        /// Distance of the values; none for all numbers.
        step: Option<f64>,
        /// Whether to look as closely from 1 to 10 as from 10 to 100.
        log: bool,
    },
    /// A whole number.
    Whole {
        /// Least.
        low: i64,
        /// Largest.
        high: i64,
        /// Distance of the values.
        step: i64,
    },
    /// One of these.
    Choice {
        /// Texts, numbers or truth values.
        choices: Vec<Value>,
    },
}

/// A field of the motion file and the values that it may have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Variable {
    /// Path of the field.
    pub path: String,
    /// Values.
    #[serde(flatten)]
    pub range: Range,
}

/// A figure and the way that it should go.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Objective {
    /// Name of the figure.
    pub measure: String,
    /// Its unit.
    pub unit: String,
    /// Whether more of it is better.
    pub up: bool,
}

/// A figure and its limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Constraint {
    /// Name of the figure.
    pub measure: String,
    /// It has to be at least this.
    pub least: Option<f64>,
    /// It may be at most this.
    pub most: Option<f64>,
}

/// One rung of the successive halving.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rung {
    /// What is made.
    pub stage: Stage,
    /// `search.effort` of it; the motion file's where there is none.
    pub effort: Option<f64>,
    /// Share of the rung below that gets here.
    pub keep: f64,
}

/// How long a study may take.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// Number of drafts; none where only time ends it.
    pub trials: Option<u64>,
    /// Time, min; drafts take at most half of it.
    pub minutes: Option<f64>,
}

/// What one trial may take.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Time of a draft, s.
    pub draft_s: f64,
    /// Time of a design, s.
    pub design_s: f64,
    /// Memory, MB.
    pub memory_mb: u64,
    /// Threads.
    pub threads: u64,
}

/// A study, checked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Its name.
    pub name: String,
    /// Seed of all draws.
    pub seed: u64,
    /// How trials are chosen: `tpe`, `nsga2` or `random`.
    pub sampler: String,
    /// What is varied.
    pub variables: Vec<Variable>,
    /// What is wanted.
    pub objectives: Vec<Objective>,
    /// What has to be.
    pub constraints: Vec<Constraint>,
    /// Drafts, then designs.
    pub rungs: Vec<Rung>,
    /// When it ends.
    pub budget: Budget,
    /// What one trial may take.
    pub limits: Limits,
}

impl Study {
    /// Reads and checks the study file at `path` for the motion file at `motion`.
    ///
    /// # Errors
    /// [`Error::Io`] for files that cannot be read, [`Error::Input`] with all problems found.
    pub fn read(path: &Path, motion: &Path) -> Result<Study> {
        let text = read_text(path, MAX_TOML_BYTES)?;
        Study::parse(&text, path, motion)
    }

    fn parse(text: &str, path: &Path, motion: &Path) -> Result<Study> {
        let document = Document::parse(text).map_err(|problem| Error::input(path, problem))?;
        let table = &document.table;
        let mut reader = Reader {
            problems: Problems::default(),
        };
        const FIELDS: [&str; 8] = [
            "name",
            "seed",
            "sampler",
            "variables",
            "objectives",
            "constraints",
            "budget",
            "limits",
        ];
        unknown_fields("", table, &FIELDS, &mut reader.problems);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let study = Study {
            name: reader.text(table, "name", &stem),
            seed: reader.whole(table, "", "seed", 1, [0, i64::from(u32::MAX)]) as u64,
            sampler: reader.sampler(table),
            variables: reader.variables(table),
            objectives: reader.objectives(table),
            constraints: reader.constraints(table),
            rungs: reader.rungs(table),
            budget: reader.budget(table),
            limits: reader.limits(table),
        };
        let mut problems = reader.problems;
        let (base, _) = MotionFile::read_draft(motion)?;
        for variable in &study.variables {
            problems.extend(tried(variable, motion, &base));
        }
        if problems.is_empty() {
            return Ok(study);
        }
        document.locate(&mut problems);
        Err(Error::input(path, problems))
    }

    /// Whether the trials of `other` are those of this study: only how long it takes may differ.
    pub fn is_same(&self, other: &Study) -> bool {
        let timeless = |study: &Study| Study {
            budget: Budget {
                trials: None,
                minutes: None,
            },
            limits: Limits {
                draft_s: 0.0,
                design_s: 0.0,
                memory_mb: 0,
                threads: 0,
            },
            ..study.clone()
        };
        timeless(self) == timeless(other)
    }
}

/// What is wrong with the ends of a variable's range in the motion file: unknown fields, values that are not
/// allowed, constants that no formula has.
fn tried(variable: &Variable, motion: &Path, base: &MotionFile) -> Vec<Problem> {
    let place = format!("variables.{:?}", variable.path);
    let values = match &variable.range {
        Range::Number { low, high, .. } => vec![Value::Float(*low), Value::Float(*high)],
        Range::Whole { low, high, .. } => vec![Value::Integer(*low), Value::Integer(*high)],
        Range::Choice { choices } => choices.clone(),
    };
    if let Some(name) = variable.path.strip_prefix("motion.constants.")
        && let crate::motion::MotionSource::Formula(formula) = &base.source
        && !formula.constants.contains_key(name)
    {
        let known: Vec<&str> = formula.constants.keys().map(String::as_str).collect();
        let hint = format!("constants of the motion: {}", known.join(", "));
        return vec![Problem::new(place, "is no constant of the motion", hint)];
    }
    let mut found: Vec<Problem> = Vec::new();
    for value in values {
        let change = Change {
            path: variable.path.clone(),
            value,
        };
        let Err(Error::Input { problems, .. }) =
            MotionFile::read_changed(motion, std::slice::from_ref(&change))
        else {
            continue;
        };
        // Fields that have to fit this one may be varied with it; only its own problems count.
        let own = |p: &&Problem| p.place.ends_with(&variable.path);
        for problem in problems.first().iter().filter(own) {
            // What is wrong whatever the value is told once.
            if !found.iter().any(|told| told.what.ends_with(&problem.what)) {
                let what = format!("{change}: {}", problem.what);
                found.push(Problem::new(&place, what, &problem.hint));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml::Table;

    const MOTION: &str = "class = \"1R\"\n[motion]\nkind = \"formula\"\nown_turn = \"-phi + a*sin(phi)\"\n\
                          constants = { a = \"0.1\" }\n[load]\npoint_mm = [0.0, 0.0, 60.0]\ngravity = [0.0, 0.0, -1.0]\n";

    fn study(text: &str) -> Result<Study> {
        let folder = tempfile::tempdir().expect("a folder");
        let motion = folder.path().join("my.toml");
        std::fs::write(&motion, MOTION).expect("written");
        Study::parse(text, Path::new("study.toml"), &motion)
    }

    const GOOD: &str = "[variables]\n\"gear.teeth\" = { low = 8, high = 12 }\n\
        \"motion.constants.a\" = { low = 0.05, high = 0.2 }\n\"load.driver_material\" = { choices = [\"PLA\", \"PA12\"] }\n\
        [objectives]\nplastic_g = \"down\"\n[constraints]\nheight_mm = { most = 80 }\n[budget]\ntrials = 8\n";

    #[test]
    fn a_study_says_what_is_varied_and_wanted() {
        let study = study(GOOD).expect("good");
        assert_eq!(study.variables.len(), 3);
        assert!(study.variables.iter().any(|v| v.range
            == Range::Whole {
                low: 8,
                high: 12,
                step: 1
            }));
        assert_eq!(study.constraints[0].most, Some(80.0));
        assert_eq!(study.rungs.len(), 2);
        let mut longer = study.clone();
        longer.budget.trials = Some(9);
        assert!(study.is_same(&longer));
        longer.seed = 2;
        assert!(!study.is_same(&longer));
    }

    /// A study with one variable and one objective.
    fn one(variable: &str, range: &str, objective: &str, way: &str) -> Result<Study> {
        study(&format!(
            "[variables]\n{variable:?} = {range}\n[objectives]\n{objective} = {way:?}\n[budget]\ntrials = 8\n"
        ))
    }

    #[test]
    fn sizes_numbers_choices_and_constants_can_be_varied() {
        let numbers = ["center_distance_mm", "contact_ratio", "tooth_thickness_mm"];
        let heights = ["tip_mm", "root_mm"];
        for (name, range) in numbers
            .iter()
            .zip([
                "{ low = 24.0, high = 30.0 }",
                "{ low = 1.2, high = 1.5 }",
                "{ low = 1.4, high = 2.0 }",
            ])
            .chain(heights.iter().zip([
                "{ low = 0.5, high = 0.9 }",
                "{ low = 0.3, high = 0.7, step = 0.1 }",
            ]))
        {
            let made = one(&format!("gear.{name}"), range, "play_mm", "down").expect(name);
            assert!(
                matches!(made.variables[0].range, Range::Number { .. }),
                "{name}"
            );
        }
        let others = [
            ("gear.teeth", "{ low = 8, high = 12 }"),
            ("gear.sub_gear_pairs", "{ choices = [\"auto\", 3, 4] }"),
            (
                "load.follower_material",
                "{ choices = [\"PLA\", \"PETG\", \"SLA\", \"PA12\", \"steel\"] }",
            ),
            ("fit.clearance_mm", "{ low = 0.05, high = 0.2, log = true }"),
            ("motion.constants.a", "{ low = 0.05, high = 0.2 }"),
            ("load.point_mm[2]", "{ low = 40.0, high = 60.0 }"),
        ];
        for (path, range) in others {
            let made = one(path, range, "play_mm", "down").expect(path);
            assert_eq!(made.variables[0].path, path);
        }
    }

    #[test]
    fn every_setting_can_be_varied() {
        let settings = Table::try_from(crate::settings::Settings::default()).expect("a table");
        let mut tried = 0;
        for (section, fields) in &settings {
            for (field, value) in fields.as_table().expect("a section") {
                // Lists are varied by their numbers.
                let (path, value) = match value.as_array() {
                    None => (format!("{section}.{field}"), value),
                    Some(list) if list.is_empty() => continue,
                    Some(list) => (format!("{section}.{field}[0]"), &list[0]),
                };
                let made = one(
                    &path,
                    &format!("{{ choices = [{value}] }}"),
                    "play_mm",
                    "down",
                );
                assert!(made.is_ok(), "{path} = {value}: {:?}", made.err());
                tried += 1;
            }
        }
        assert!(tried > 40, "only {tried}");
        assert!(one("gear.no_setting", "{ choices = [1] }", "play_mm", "down").is_err());
    }

    #[test]
    fn every_figure_can_be_an_objective_and_a_constraint() {
        for measure in crate::explore::measures::MEASURES {
            let name = measure.name;
            for (way, up) in [("up", true), ("down", false)] {
                let made = one("gear.teeth", "{ low = 8, high = 12 }", name, way).expect(name);
                let asked = &made.objectives[0];
                assert_eq!((asked.measure.as_str(), asked.up), (name, up));
                assert_eq!(asked.unit, measure.unit);
            }
            let limited = GOOD.replace("height_mm =", &format!("{name} ="));
            let made = study(&limited).expect(name);
            assert_eq!(made.constraints[0].measure, name);
        }
    }

    #[test]
    fn all_problems_are_told_at_once() {
        let text = "sampler = \"best\"\n[variables]\n\"gear.tooth\" = { low = 8, high = 12 }\n\
            \"gear.teeth\" = { low = 2, high = 12 }\n\"gear.tip_mm\" = { low = 1.0, high = 0.5 }\n\
            \"gear.root_mm\" = { low = 0.1, high = 0.5, log = 1 }\nfit.clearance_mm = { low = 0.1, high = 0.2 }\n\"motion.constants.b\" = { low = 0.1, high = 0.2 }\n\
            [objectives]\nplastik_g = \"down\"\nplay_mm = \"less\"\n[constraints]\nheight_mm = 80\nplay_mm = { least = 2, most = 1 }\n[budget]\nkeep = 2\n";
        let Err(Error::Input { problems, .. }) = study(text) else {
            panic!("accepted");
        };
        let told = problems.to_string();
        for part in [
            "line 1, sampler: is \"best\"",
            "\"gear.tooth\": gear.tooth=8: unknown field",
            "gear.teeth=2: is 2, allowed 3 to 60",
            "low must be less than high",
            "is no constant of the motion",
            "did you mean `plastic_g`?",
            "is \"less\", allowed \"up\", \"down\"",
            "constraints.height_mm: is 80, which is no limit",
            "least is more than most",
            "log is neither true nor false",
            "is a table of tables",
            "budget: has neither trials nor minutes",
            "budget.keep: is 2",
        ] {
            assert!(told.contains(part), "{part:?} is not in:\n{told}");
        }
    }
}
