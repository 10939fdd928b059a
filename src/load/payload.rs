//! The largest payload at one driver angle, what limits it and where.

use nalgebra::DVector;
use serde::Serialize;

use super::contacts::Configuration;
use super::{Load, forces, hertz};
use crate::design::Gear;
use crate::strength::Teeth;

/// What limits the payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PayloadLimit {
    /// The contact force limit of the settings.
    Force,
    /// The Hertz pressure that the weaker material bears.
    Pressure,
    /// The contact patch, which would grow over the end of a flank.
    Patch,
    /// The stress at the root of a tooth.
    RootStress,
}

impl std::fmt::Display for PayloadLimit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            PayloadLimit::Force => "the contact force limit",
            PayloadLimit::Pressure => "the contact pressure that the material bears",
            PayloadLimit::Patch => "the contact patch, which reaches the edge of a flank",
            PayloadLimit::RootStress => "the stress at the root of a tooth",
        })
    }
}

/// A tooth, or both teeth of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ToothName {
    /// Its gear; `None` where both gears' teeth are meant.
    pub gear: Option<Gear>,
    /// Sub-gear pair k, from 0.
    pub pair: usize,
    /// Tooth j, from 0.
    pub tooth: usize,
}

impl std::fmt::Display for ToothName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let gear = match self.gear {
            Some(Gear::Driver) => "driver's ",
            Some(Gear::Follower) => "follower's ",
            None => "",
        };
        write!(
            f,
            "{gear}tooth {} of pair {}",
            self.tooth + 1,
            self.pair + 1
        )
    }
}

/// Largest payload at one driver angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Payload {
    /// kg; infinite where weight does not load the contacts, `None` when even the extra load alone exceeds a
    /// limit.
    pub kg: Option<f64>,
    /// What limits it; `None` where it is unlimited.
    pub limit: Option<PayloadLimit>,
    /// Where that is; `None` without limit or without payload.
    pub tooth: Option<ToothName>,
}

/// What one contact bears before each limit, with the safety asked for, N.
struct Bears {
    pressure: f64,
    patch: f64,
    /// Of the driver's and of the follower's tooth.
    roots: [f64; 2],
}

impl Bears {
    fn root(&self) -> f64 {
        self.roots[0].min(self.roots[1])
    }
}

/// Largest payload at `at` for contacts with the projected normals `columns`, whose rows are scaled by
/// `lengths`, under the projected wrenches of one kilogram and of what else loads the follower. Teeth are
/// unbreakable without `teeth`.
pub(super) fn largest(
    (load, at, teeth): (&Load, &Configuration, Option<&Teeth>),
    (columns, lengths): (&[DVector<f64>], &DVector<f64>),
    (unit, extra): (&DVector<f64>, &DVector<f64>),
) -> Payload {
    let limit = load.force_limit_n;
    let materials = [load.driver_material, load.follower_material];
    let modulus = hertz::effective_modulus(materials[0], materials[1]);
    let bears: Vec<Bears> = at
        .contacts
        .iter()
        .map(|c| {
            let point = hertz::bearable(c, load.pressure_allowed(), modulus);
            let roots = teeth.map(|teeth| {
                let both = teeth.tooth(c.pair, c.tooth);
                [0, 1].map(|i| materials[i].yield_strength() / both[i].at(c.share).stress)
            });
            let safe = |force: f64| force / load.safety;
            Bears {
                pressure: point.map_or(f64::INFINITY, |b| safe(b.by_pressure)),
                patch: point.map_or(f64::INFINITY, |b| safe(b.by_patch)),
                roots: roots.map_or([f64::INFINITY; 2], |forces| forces.map(safe)),
            }
        })
        .collect();
    // Forces are counted in shares of what their contact bears.
    let weaker = |of: &dyn Fn(&Bears) -> f64| -> Vec<DVector<f64>> {
        let share = |b: &Bears| (of(b) / limit).min(1.0);
        columns
            .iter()
            .zip(&bears)
            .map(|(c, b)| c * share(b))
            .collect()
    };
    let carried = |of: &dyn Fn(&Bears) -> f64| {
        forces::largest_payload(&weaker(of), (unit, extra), lengths, limit)
    };
    let least = |b: &Bears| b.pressure.min(b.patch).min(b.root());
    let by_all = carried(&least);
    // The first limit that alone allows no more than all of them.
    let governs = |of: &dyn Fn(&Bears) -> f64| match (carried(of), by_all) {
        (None, _) => true,
        (Some(alone), Some(all)) => all >= alone * (1.0 - 1e-6),
        (Some(_), None) => false,
    };
    let governing = match by_all {
        Some(kg) if kg.is_infinite() => None,
        _ if governs(&|_| limit) => Some(PayloadLimit::Force),
        _ if governs(&|b| b.pressure) => Some(PayloadLimit::Pressure),
        _ if governs(&Bears::root) => Some(PayloadLimit::RootStress),
        _ if governs(&|b| b.patch) => Some(PayloadLimit::Patch),
        // No limit alone: the place says which one it is.
        _ => None,
    };
    let at_limit = by_all.filter(|kg| kg.is_finite()).and_then(|kg| {
        let total = unit * kg + extra;
        let shares = forces::smallest_largest(&weaker(&least), &total, lengths)?.forces;
        let most = (0..shares.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b]))?;
        let (contact, b) = (&at.contacts[most], &bears[most]);
        let kind = match least(b) {
            force if force >= limit => PayloadLimit::Force,
            force if force >= b.pressure => PayloadLimit::Pressure,
            force if force >= b.root() => PayloadLimit::RootStress,
            _ => PayloadLimit::Patch,
        };
        let gear = match b.roots[0] <= b.roots[1] {
            true => Gear::Driver,
            false => Gear::Follower,
        };
        let name = ToothName {
            gear: (kind == PayloadLimit::RootStress).then_some(gear),
            pair: contact.pair,
            tooth: contact.tooth,
        };
        Some((kind, name))
    });
    Payload {
        kg: by_all,
        limit: governing.or(at_limit.map(|(kind, _)| kind)),
        tooth: at_limit.map(|(_, name)| name),
    }
}
