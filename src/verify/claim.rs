//! One line of the table that `check` prints.

use serde::{Deserialize, Serialize};

use super::overlap::Place;

/// One claim about the mechanism and whether it holds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
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
    /// The figure as a number; `None` where a sentence says it or it could not be measured.
    pub value: Option<f64>,
    /// The limit of that number.
    pub bound: Option<f64>,
    /// Unit of both.
    pub unit: String,
    /// The place as numbers.
    pub spot: Spot,
}

/// Where a claim is worst; what does not apply is left out.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Spot {
    /// Driver angle, deg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phi_deg: Option<f64>,
    /// Sub-gear pair, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pair: Option<usize>,
    /// Tooth of that pair, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tooth: Option<usize>,
    /// Point, mm: in Σ where there is a driver angle, otherwise in the frame of the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_mm: Option<[f64; 3]>,
    /// Direction in span(U), order linear (mm), angular (rad).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<Vec<f64>>,
}

impl Spot {
    /// A driver angle, rad.
    pub(super) fn phase(phi: f64) -> Spot {
        Spot {
            phi_deg: Some(phi.to_degrees()),
            ..Spot::default()
        }
    }

    /// A point of a mesh, mm.
    pub(super) fn point(at: [f64; 3]) -> Spot {
        Spot {
            at_mm: Some(at),
            ..Spot::default()
        }
    }

    /// The same place, on tooth `j` of sub-gear pair `k`, both from 0; unchanged without a tooth.
    pub(super) fn on(self, tooth: Option<(usize, usize)>) -> Spot {
        match tooth {
            Some((k, j)) => Spot {
                pair: Some(k + 1),
                tooth: Some(j + 1),
                ..self
            },
            None => self,
        }
    }

    /// The same place, towards `direction`.
    pub(super) fn towards(self, direction: &[f64]) -> Spot {
        Spot {
            direction: Some(direction.to_vec()),
            ..self
        }
    }
}

impl From<Place> for Spot {
    fn from(place: Place) -> Spot {
        Spot {
            at_mm: Some(place.at),
            ..Spot::phase(place.phi)
        }
    }
}

impl std::fmt::Display for Spot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let parts = [
            self.phi_deg.map(|phi| format!("φ = {phi:.2}°")),
            self.pair.map(|k| format!("pair {k}")),
            self.tooth.map(|j| format!("tooth {j}")),
            self.at_mm
                .map(|[x, y, z]| format!("({x:.2}, {y:.2}, {z:.2}) mm")),
            self.direction
                .as_ref()
                .map(|u| format!("direction {u:.2?}")),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        f.write_str(&parts.join(", "))
    }
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
            ..Claim::default()
        }
    }

    /// Decides the claim by a value; what is no finite number is undecided.
    pub(super) fn decide(mut self, value: f64, unit: &str, bound: Bound) -> Claim {
        let number = |x: f64| match x {
            0.0 => "0".into(),
            x if x.abs() < 1e-3 || x.abs() >= 1e6 => format!("{x:.2e}"),
            x => format!("{x:.4}"),
        };
        let with_unit = |x: f64| format!("{} {unit}", number(x)).trim_end().to_owned();
        self.figure = match value.is_finite() {
            true => with_unit(value),
            false => "undecided: no finite number".into(),
        };
        let limit;
        (limit, self.limit, self.holds) = match bound {
            Bound::AtMost(limit) => (limit, format!("≤ {}", with_unit(limit)), value <= limit),
            Bound::AtLeast(limit) => (limit, format!("≥ {}", with_unit(limit)), value >= limit),
        };
        self.holds &= value.is_finite();
        self.measured(value, unit, limit)
    }

    /// Decides the claim by a sentence.
    pub(super) fn say(mut self, holds: bool, figure: impl Into<String>, limit: &str) -> Claim {
        (self.holds, self.figure, self.limit) = (holds, figure.into(), limit.into());
        self
    }

    /// Adds the numbers behind the sentence of [`Claim::say`].
    pub(super) fn measured(mut self, value: f64, unit: &str, bound: f64) -> Claim {
        [self.value, self.bound] = [value, bound].map(|x| Some(x).filter(|x| x.is_finite()));
        self.unit = unit.into();
        self
    }

    /// A claim that cannot be decided, and why.
    pub(super) fn undecided(self, why: &str) -> Claim {
        self.say(false, format!("undecided: {why}"), "decided")
    }

    pub(super) fn at(mut self, spot: impl Into<Spot>) -> Claim {
        self.spot = spot.into();
        self.place = self.spot.to_string();
        self
    }
}
