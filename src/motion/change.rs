//! One field of a motion file set to another value, as `mpcgear trial --set` and explorations do.

use std::fmt;

use toml::{Table, Value};

use super::document::as_key;
use crate::Problem;

/// A field of a motion file by its path and the value that it gets.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// As messages name it: `gear.teeth`, `motion.constants.k`, `load.point_mm[2]` (from 0).
    pub path: String,
    /// What it is set to.
    pub value: Value,
}

/// Where the constants of formulas stand; they are texts there.
const CONSTANTS: &str = "motion.constants.";

/// Deepest path.
const DEEPEST: usize = 8;

impl Change {
    /// Reads `path=value`; what is no TOML value is taken for a text.
    ///
    /// # Errors
    /// What is wrong with it, in one sentence.
    pub fn parse(text: &str) -> Result<Change, String> {
        let Some((path, value)) = text.split_once('=') else {
            return Err(format!("`{text}` is no change; write gear.teeth=12"));
        };
        let (path, value) = (path.trim(), value.trim());
        let parsed: Option<Value> = toml::from_str::<Table>(&format!("v = {value}"))
            .ok()
            .and_then(|mut table| table.remove("v"));
        let change = Change {
            path: path.to_owned(),
            value: parsed.unwrap_or_else(|| Value::String(value.to_owned())),
        };
        steps(&change.path)?;
        Ok(change)
    }

    /// Sets the field in `table`; tables on the way are made, rows have to be there.
    ///
    /// # Errors
    /// A [`Problem`] at the field.
    pub fn apply(&self, table: &mut Table) -> Result<(), Problem> {
        let problem = |what: &str| Problem::new(&self.path, what, "write a path as gear.teeth");
        let steps = steps(&self.path).map_err(|what| problem(&what))?;
        let Some((Step::Field(first), rest)) = steps.split_first() else {
            return Err(problem("is no field"));
        };
        let empty = || Value::Table(Table::new());
        let mut place = table.entry((*first).to_owned()).or_insert_with(empty);
        for step in rest {
            place = match (step, place) {
                (Step::Field(name), Value::Table(inner)) => {
                    inner.entry((*name).to_owned()).or_insert_with(empty)
                }
                (Step::Row(i), Value::Array(rows)) => {
                    rows.get_mut(*i).ok_or_else(|| problem("has no such row"))?
                }
                _ => return Err(problem("goes through a field that is no table")),
            };
        }
        *place = match &self.value {
            Value::Integer(_) | Value::Float(_) if self.path.starts_with(CONSTANTS) => {
                Value::String(self.value.to_string())
            }
            value => value.clone(),
        };
        Ok(())
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.path, self.value)
    }
}

/// One step of a path.
#[derive(Debug, Clone, Copy)]
enum Step<'p> {
    Field(&'p str),
    Row(usize),
}

/// The steps of a path such as `load.point_mm[2]`.
fn steps(path: &str) -> Result<Vec<Step<'_>>, String> {
    let wrong = || format!("`{path}` is no path of a field; write gear.teeth or load.point_mm[2]");
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (name, rows) = part.split_once('[').map_or((part, ""), |(n, r)| (n, r));
        if name.is_empty() || as_key(name) != name {
            return Err(wrong());
        }
        steps.push(Step::Field(name));
        if part.len() > name.len() {
            for row in rows.split('[') {
                let index = row.strip_suffix(']').and_then(|i| i.parse().ok());
                steps.push(Step::Row(index.ok_or_else(wrong)?));
            }
        }
    }
    if steps.len() > DEEPEST {
        return Err(wrong());
    }
    Ok(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(text: &str, change: &str) -> Table {
        let mut table: Table = toml::from_str(text).expect("TOML");
        let change = Change::parse(change).expect("a change");
        change.apply(&mut table).expect("applies");
        table
    }

    #[test]
    fn a_change_sets_one_field_and_no_other() {
        let table = changed("[gear]\nteeth = 10\ntip_mm = 0.5\n", "gear.teeth=12");
        assert_eq!(table["gear"]["teeth"].as_integer(), Some(12));
        assert_eq!(table["gear"]["tip_mm"].as_float(), Some(0.5));
        let table = changed("", "load.driver_material=PA12");
        assert_eq!(table["load"]["driver_material"].as_str(), Some("PA12"));
        let table = changed(
            "[load]\npoint_mm = [0.0, 0.0, 60.0]\n",
            "load.point_mm[2]=40",
        );
        assert_eq!(table["load"]["point_mm"][2].as_integer(), Some(40));
    }

    #[test]
    fn constants_of_formulas_stay_texts() {
        let table = changed(
            "[motion.constants]\na = \"8*deg\"\n",
            "motion.constants.a=0.25",
        );
        assert_eq!(table["motion"]["constants"]["a"].as_str(), Some("0.25"));
    }

    #[test]
    fn what_is_no_path_is_refused() {
        for text in [
            "teeth",
            "=3",
            "gear..teeth=3",
            "a[x]=1",
            "a b=1",
            "a.b.c.d.e.f.g.h.i=1",
        ] {
            Change::parse(text).expect_err(text);
        }
        let mut table: Table = toml::from_str("name = \"x\"\nrows = [1]").expect("TOML");
        for text in ["name.first=1", "rows[1]=2"] {
            let change = Change::parse(text).expect(text);
            change.apply(&mut table).expect_err(text);
        }
    }
}
