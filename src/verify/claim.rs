//! One line of the table that `check` prints.

use serde::{Deserialize, Serialize};

/// One claim about the mechanism and whether it holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Short name, as `check` prints it.
    pub name: String,
    /// What it means, in plain words.
    pub meaning: String,
    /// What was measured, with its unit; "undecided" with the reason when it could not be.
    pub figure: String,
    /// What was demanded.
    pub limit: String,
    /// Where it is worst (φ, sub-gear pair, tooth); may be empty.
    pub place: String,
    /// Whether it holds. What cannot be decided does not.
    pub holds: bool,
}

/// A value that a claim bounds, in one unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Bound {
    AtMost(f64),
    AtLeast(f64),
}

impl Claim {
    /// A claim `name` with its plain `meaning`.
    pub(super) fn new(name: impl Into<String>, meaning: &str) -> Claim {
        Claim {
            name: name.into(),
            meaning: meaning.into(),
            figure: String::new(),
            limit: String::new(),
            place: String::new(),
            holds: false,
        }
    }

    /// Decides the claim by a value; NaN is undecided.
    pub(super) fn decide(mut self, value: f64, unit: &str, bound: Bound) -> Claim {
        let number = |x: f64| match x {
            0.0 => "0".into(),
            x if x.abs() < 1e-3 || x.abs() >= 1e6 => format!("{x:.2e}"),
            x => format!("{x:.4}"),
        };
        let with_unit = |x: f64| format!("{} {unit}", number(x)).trim_end().to_owned();
        self.figure = if value.is_nan() {
            "undecided: not a number".into()
        } else {
            with_unit(value)
        };
        (self.limit, self.holds) = match bound {
            Bound::AtMost(limit) => (format!("≤ {}", with_unit(limit)), value <= limit),
            Bound::AtLeast(limit) => (format!("≥ {}", with_unit(limit)), value >= limit),
        };
        self
    }

    /// Decides the claim by a sentence.
    pub(super) fn say(mut self, holds: bool, figure: impl Into<String>, limit: &str) -> Claim {
        (self.holds, self.figure, self.limit) = (holds, figure.into(), limit.into());
        self
    }

    /// A claim that cannot be decided, and why.
    pub(super) fn undecided(self, why: &str) -> Claim {
        self.say(false, format!("undecided: {why}"), "decided")
    }

    pub(super) fn at(mut self, place: impl Into<String>) -> Claim {
        self.place = place.into();
        self
    }
}

/// "φ = 12.3°, pair 2, tooth 7" (counted from 1).
pub(super) fn tooth_place(phi: f64, k: usize, j: usize) -> String {
    format!(
        "φ = {:.2}°, pair {}, tooth {}",
        phi.to_degrees(),
        k + 1,
        j + 1
    )
}
