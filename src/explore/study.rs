//! The study file: what is varied, what is wanted, how long it may take.

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::measures::MEASURES;
use super::plan::PRIMES;
use super::trial::Stage;
use crate::motion::document::{Document, nearest, unknown_fields};
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
        for variable in &study.variables {
            problems.extend(tried(variable, motion)?);
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
fn tried(variable: &Variable, motion: &Path) -> Result<Vec<Problem>> {
    let (base, _) = MotionFile::read_draft(motion)?;
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
        return Ok(vec![Problem::new(
            place,
            "is no constant of the motion",
            hint,
        )]);
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
    Ok(found)
}

/// Reads fields and gathers what is wrong with them.
struct Reader {
    problems: Problems,
}

impl Reader {
    fn tell(&mut self, place: impl Into<String>, what: impl Into<String>, hint: &str) {
        self.problems.push(Problem::new(place, what, hint));
    }

    /// A table; an empty one where it is missing.
    fn table(&mut self, table: &Table, name: &str, needed: bool) -> Table {
        match table.get(name) {
            Some(Value::Table(inner)) => return inner.clone(),
            None if !needed => {}
            None => self.tell(name, "is missing or empty", &format!("write [{name}]")),
            Some(_) => self.tell(name, "is not a table", &format!("write [{name}]")),
        }
        Table::new()
    }

    fn text(&mut self, table: &Table, name: &str, default: &str) -> String {
        match table.get(name) {
            None => {}
            Some(Value::String(text)) if !text.trim().is_empty() => return text.clone(),
            Some(other) => self.tell(name, format!("is {other}, allowed is any text"), ""),
        }
        default.to_owned()
    }

    fn sampler(&mut self, table: &Table) -> String {
        const SAMPLERS: [&str; 3] = ["tpe", "nsga2", "random"];
        let name = self.text(table, "sampler", SAMPLERS[0]);
        if !SAMPLERS.contains(&name.as_str()) {
            let what = format!("is {name:?}, allowed \"{}\"", SAMPLERS.join("\", \""));
            self.tell(
                "sampler",
                what,
                "tpe learns fastest, nsga2 asks for least time",
            );
        }
        name
    }

    /// A number within `range`, or `None` where it is missing or wrong.
    fn number(&mut self, table: &Table, at: &str, name: &str, range: [f64; 2]) -> Option<f64> {
        let value = table.get(name)?;
        let number = value.as_float().or(value.as_integer().map(|i| i as f64));
        let [least, most] = range;
        match number {
            Some(number) if (least..=most).contains(&number) => Some(number),
            _ => {
                let what = format!("is {value}, allowed are numbers from {least} to {most}");
                self.tell(place(at, name), what, "");
                None
            }
        }
    }

    fn whole(&mut self, table: &Table, at: &str, name: &str, default: i64, range: [i64; 2]) -> i64 {
        let Some(value) = table.get(name) else {
            return default;
        };
        let [least, most] = range;
        match value.as_integer() {
            Some(number) if (least..=most).contains(&number) => number,
            _ => {
                let what = format!("is {value}, allowed are whole numbers from {least} to {most}");
                self.tell(place(at, name), what, "");
                default
            }
        }
    }

    fn variables(&mut self, table: &Table) -> Vec<Variable> {
        let given = self.table(table, "variables", true);
        if given.len() > PRIMES.len() {
            let what = format!("has {} entries, allowed {}", given.len(), PRIMES.len());
            self.tell("variables", what, "");
        }
        let mut variables = Vec::new();
        for (path, value) in &given {
            let at = format!("variables.{path:?}");
            if let Err(what) = Change::parse(&format!("{path}=0")) {
                let hint =
                    "paths with dots stand in quotes: \"gear.teeth\" = { low = 8, high = 12 }";
                self.tell(&at, what, hint);
            } else if let Some(range) = self.range(&at, value) {
                variables.push(Variable {
                    path: path.clone(),
                    range,
                });
            }
        }
        variables
    }

    fn range(&mut self, at: &str, value: &Value) -> Option<Range> {
        const HINT: &str =
            "write { low = 8, high = 12 }, with step or log if wanted, or { choices = [1, 2] }";
        let Some(table) = value.as_table() else {
            self.tell(at, format!("is {value}, which is no range"), HINT);
            return None;
        };
        unknown_fields(
            at,
            table,
            &["low", "high", "step", "log", "choices"],
            &mut self.problems,
        );
        if let Some(choices) = table.get("choices") {
            let plain =
                |v: &Value| !matches!(v, Value::Array(_) | Value::Table(_) | Value::Datetime(_));
            return match choices.as_array() {
                Some(list) if !list.is_empty() && list.iter().all(plain) && table.len() == 1 => {
                    Some(Range::Choice {
                        choices: list.clone(),
                    })
                }
                _ => {
                    let what =
                        "choices must be a list of texts, numbers or truth values, and stand alone";
                    self.tell(at, what, HINT);
                    None
                }
            };
        }
        let ends = [table.get("low"), table.get("high")];
        let step = table.get("step");
        let log = table
            .get("log")
            .is_some_and(|log| log.as_bool() == Some(true));
        if let [Some(Value::Integer(low)), Some(Value::Integer(high))] = ends
            && step.is_none_or(Value::is_integer)
            && !log
        {
            let step = step.and_then(Value::as_integer).unwrap_or(1);
            if low < high && step >= 1 && *low >= -1_000_000 && *high <= 1_000_000 {
                return Some(Range::Whole {
                    low: *low,
                    high: *high,
                    step,
                });
            }
        } else {
            let number = |v: Option<&Value>| {
                let v = v?;
                v.as_float()
                    .or(v.as_integer().map(|i| i as f64))
                    .filter(|f| f.is_finite())
            };
            let step = step.map(|step| number(Some(step)).unwrap_or(-1.0));
            if let [Some(low), Some(high)] = ends.map(number)
                && low < high
                && step.is_none_or(|step| step > 0.0 && step <= high - low)
                && (!log || (low > 0.0 && step.is_none()))
            {
                return Some(Range::Number {
                    low,
                    high,
                    step,
                    log,
                });
            }
        }
        let what = format!(
            "is {value}: low must be less than high, step above 0; log needs low above 0 and no step"
        );
        self.tell(at, what, HINT);
        None
    }

    /// The unit of a figure, if there is such a figure.
    fn unit(&mut self, at: &str, name: &str) -> Option<&'static str> {
        let found = MEASURES.iter().find(|m| m.name == name);
        if found.is_none() {
            let names: Vec<&str> = MEASURES.iter().map(|m| m.name).collect();
            let hint = match nearest(name, &names) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!("known here: {}", names.join(", ")),
            };
            self.tell(format!("{at}.{name}"), "unknown figure", &hint);
        }
        found.map(|m| m.unit)
    }

    fn objectives(&mut self, table: &Table) -> Vec<Objective> {
        let given = self.table(table, "objectives", true);
        if given.len() > 4 || (given.is_empty() && table.contains_key("objectives")) {
            let what = format!("has {} entries, allowed 1 to 4", given.len());
            self.tell(
                "objectives",
                what,
                "limits on other figures are constraints",
            );
        }
        let mut objectives = Vec::new();
        for (name, way) in &given {
            let unit = self.unit("objectives", name);
            let up = match way.as_str() {
                Some("up") => true,
                Some("down") => false,
                _ => {
                    let what = format!("is {way}, allowed \"up\", \"down\"");
                    self.tell(format!("objectives.{name}"), what, "");
                    continue;
                }
            };
            objectives.extend(unit.map(|unit| Objective {
                measure: name.clone(),
                unit: unit.into(),
                up,
            }));
        }
        objectives
    }

    fn constraints(&mut self, table: &Table) -> Vec<Constraint> {
        let given = self.table(table, "constraints", false);
        let mut constraints = Vec::new();
        for (name, limits) in &given {
            let at = format!("constraints.{name}");
            self.unit("constraints", name);
            let none = Table::new();
            let limits_table = limits.as_table().unwrap_or(&none);
            unknown_fields(&at, limits_table, &["least", "most"], &mut self.problems);
            let ends =
                ["least", "most"].map(|end| self.number(limits_table, &at, end, [-1e12, 1e12]));
            if limits_table.is_empty() {
                self.tell(
                    at,
                    format!("is {limits}, which is no limit"),
                    "write { least = 800 } or { most = 80 }",
                );
                continue;
            }
            let [least, most] = ends;
            constraints.push(Constraint {
                measure: name.clone(),
                least,
                most,
            });
        }
        constraints
    }

    fn budget(&mut self, table: &Table) -> Budget {
        let given = self.table(table, "budget", true);
        let known = ["trials", "minutes", "keep", "effort"];
        unknown_fields("budget", &given, &known, &mut self.problems);
        let trials = given.contains_key("trials");
        let trials =
            trials.then(|| self.whole(&given, "budget", "trials", 1, [1, 1_000_000]) as u64);
        let minutes = self.number(&given, "budget", "minutes", [0.01, 1e6]);
        if trials.is_none() && !given.contains_key("minutes") && table.contains_key("budget") {
            self.tell(
                "budget",
                "has neither trials nor minutes",
                "write trials = 200",
            );
        }
        Budget { trials, minutes }
    }

    /// Drafts of all; of each rung the best share goes on to the next: `keep` and `effort`, number or list.
    fn rungs(&mut self, table: &Table) -> Vec<Rung> {
        let none = Table::new();
        let budget = table
            .get("budget")
            .and_then(Value::as_table)
            .unwrap_or(&none);
        let list = |name: &str| match budget.get(name) {
            Some(Value::Array(list)) => list.clone(),
            Some(one) => vec![one.clone()],
            None => Vec::new(),
        };
        let mut numbers = |name: &str, range: [f64; 2]| -> Vec<f64> {
            let values = list(name).into_iter();
            let one = |value| Table::from_iter([(name.to_owned(), value)]);
            values
                .filter_map(|value| self.number(&one(value), "budget", name, range))
                .collect()
        };
        let (keep, effort) = (
            numbers("keep", [0.0, 1.0]),
            numbers("effort", [0.01, 100.0]),
        );
        let keep = if keep.is_empty() { vec![0.2] } else { keep };
        if !effort.is_empty() && effort.len() != keep.len() {
            let what = format!("has {} entries, but keep has {}", effort.len(), keep.len());
            self.tell(
                "budget.effort",
                what,
                "one effort for each share that is kept",
            );
        }
        let draft = Rung {
            stage: Stage::Draft,
            effort: None,
            keep: 1.0,
        };
        let designs = keep.iter().enumerate().map(|(i, &keep)| Rung {
            stage: Stage::Design,
            effort: effort.get(i).copied(),
            keep,
        });
        std::iter::once(draft).chain(designs).collect()
    }

    fn limits(&mut self, table: &Table) -> Limits {
        let given = self.table(table, "limits", false);
        let known = ["draft_s", "design_s", "memory_mb", "threads"];
        unknown_fields("limits", &given, &known, &mut self.problems);
        let mut number = |name: &str, default: f64| {
            self.number(&given, "limits", name, [0.1, 1e6])
                .unwrap_or(default)
        };
        let (draft_s, design_s) = (number("draft_s", 120.0), number("design_s", 1200.0));
        let mut whole = |name: &str, default: i64, range: [i64; 2]| {
            self.whole(&given, "limits", name, default, range) as u64
        };
        Limits {
            draft_s,
            design_s,
            memory_mb: whole("memory_mb", 2000, [200, 1_000_000]),
            threads: whole("threads", 1, [1, 1000]),
        }
    }
}

fn place(at: &str, name: &str) -> String {
    match at {
        "" => name.to_owned(),
        at => format!("{at}.{name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOTION: &str = "class = \"1R\"\n[motion]\nkind = \"formula\"\nown_turn = \"-phi + a*sin(phi)\"\n\
                          constants = { a = \"0.1\" }\n";

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

    #[test]
    fn all_problems_are_told_at_once() {
        let text = "sampler = \"best\"\n[variables]\n\"gear.tooth\" = { low = 8, high = 12 }\n\
            \"gear.teeth\" = { low = 2, high = 12 }\n\"gear.tip_mm\" = { low = 1.0, high = 0.5 }\n\
            \"motion.constants.b\" = { low = 0.1, high = 0.2 }\n\
            [objectives]\nplastik_g = \"down\"\nplay_mm = \"less\"\n[constraints]\nheight_mm = 80\n[budget]\nkeep = 2\n";
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
            "budget: has neither trials nor minutes",
            "budget.keep: is 2",
        ] {
            assert!(told.contains(part), "{part:?} is not in:\n{told}");
        }
    }
}
