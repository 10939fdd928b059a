//! The fields of a study file, with everything that is wrong with them.

use toml::{Table, Value};

use super::measures::MEASURES;
use super::plan::PRIMES;
use super::study::{Budget, Constraint, Limits, Objective, Range, Rung, Variable};
use super::trial::Stage;
use crate::motion::Change;
use crate::motion::document::{nearest, unknown_fields};
use crate::{Problem, Problems};

/// What is often forgotten.
const QUOTES: &str = "paths with dots stand in quotes: \"gear.teeth\" = { low = 8, high = 12 }";

/// Reads fields and gathers what is wrong with them.
pub(super) struct Reader {
    /// What is wrong.
    pub problems: Problems,
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

    pub fn text(&mut self, table: &Table, name: &str, default: &str) -> String {
        match table.get(name) {
            None => {}
            Some(Value::String(text)) if !text.trim().is_empty() => return text.clone(),
            Some(other) => self.tell(name, format!("is {other}, allowed is any text"), ""),
        }
        default.to_owned()
    }

    pub fn sampler(&mut self, table: &Table) -> String {
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

    pub fn whole(
        &mut self,
        table: &Table,
        at: &str,
        name: &str,
        default: i64,
        range: [i64; 2],
    ) -> i64 {
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

    pub fn variables(&mut self, table: &Table) -> Vec<Variable> {
        let given = self.table(table, "variables", true);
        if given.len() > PRIMES.len() {
            let what = format!("has {} entries, allowed {}", given.len(), PRIMES.len());
            self.tell("variables", what, "");
        }
        let mut variables = Vec::new();
        for (path, value) in &given {
            let at = format!("variables.{path:?}");
            if let Err(what) = Change::parse(&format!("{path}=0")) {
                self.tell(&at, what, QUOTES);
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
        if table.values().any(Value::is_table) {
            self.tell(at, "is a table of tables, which is no range", QUOTES);
            return None;
        }
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
        let log = match table.get("log").map(Value::as_bool) {
            None => false,
            Some(Some(log)) => log,
            Some(None) => {
                self.tell(at, "log is neither true nor false", HINT);
                return None;
            }
        };
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

    pub fn objectives(&mut self, table: &Table) -> Vec<Objective> {
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

    pub fn constraints(&mut self, table: &Table) -> Vec<Constraint> {
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
            if let (Some(least), Some(most)) = (least, most)
                && least > most
            {
                let what = format!("is {limits}: least is more than most, so nothing is within");
                self.tell(at, what, "");
            }
            constraints.push(Constraint {
                measure: name.clone(),
                least,
                most,
            });
        }
        constraints
    }

    pub fn budget(&mut self, table: &Table) -> Budget {
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
    pub fn rungs(&mut self, table: &Table) -> Vec<Rung> {
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

    pub fn limits(&mut self, table: &Table) -> Limits {
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
