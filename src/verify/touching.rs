//! Do the meshes carry the contacts of the design: at every station of every tooth pair both flanks
//! must be there, half the clearance behind the contact point. From this follow the tooth pairs that
//! really touch at each φ, the contact ratio as built, and how smoothly one tooth hands over to the next.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::claim::{Bound, Claim, Spot};
use super::overlap::Part;
use crate::design::{Design, Gear};
use crate::motion::Cycle;
use crate::solid::sweep;

/// Largest deviation of a flank from its place, mm: a quarter of the usual gap between flanks. Facets
/// of swept teeth stay far below, and so do the lofts of CAD programs.
const DEVIATION: f64 = 0.025;

/// Phases at which the touching tooth pairs are counted.
const PHASES: usize = 720;

/// A tooth pair that touches, as the meshes have it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Touching {
    /// Sub-gear pair, from 1.
    pub pair: usize,
    /// Tooth, from 1.
    pub tooth: usize,
    /// Driver angle at which both flanks begin to be in place, deg; may be below 0.
    pub from_deg: f64,
    /// Driver angle at which one of them ends, deg.
    pub to_deg: f64,
}

impl Touching {
    /// Whether it touches at `phi_deg`, whatever the turn.
    pub fn at(&self, phi_deg: f64) -> bool {
        let slack = 1e-9;
        (phi_deg - self.from_deg + slack).rem_euclid(360.0)
            <= self.to_deg - self.from_deg + 2.0 * slack
    }
}

/// A station of a tooth pair and how far each gear's flank is behind the contact point.
#[derive(Debug, Clone, Copy)]
struct Flank {
    phi: f64,
    /// Distance along the normal into the material, driver and follower; NaN where no surface is near.
    behind: [f64; 2],
}

/// The flanks of one tooth pair (k, j), in order of contact.
struct Tooth {
    at: (usize, usize),
    flanks: Vec<Flank>,
}

impl Flank {
    /// Deviation of a gear's flank (0 driver, 1 follower) from its place `wanted`, mm.
    fn deviation(&self, gear: usize, wanted: f64) -> f64 {
        match (self.behind[gear] - wanted).abs() {
            d if d.is_finite() => d,
            _ => f64::INFINITY,
        }
    }

    fn good(&self, wanted: f64) -> bool {
        (0..2).all(|gear| self.deviation(gear, wanted) <= DEVIATION)
    }
}

/// Claims about the contacts as the meshes have them, and the tooth pairs that touch.
pub(super) fn claims(
    design: &Design,
    cycle: Cycle,
    (driver, follower): (&Part, &Part),
) -> (Vec<Claim>, Vec<Touching>) {
    let wanted = 0.5 * design.section.clearance;
    let drive = design.settings.gear.drive();
    let pairs = design.sub_gear_pairs.iter().enumerate();
    let numbers: Vec<(usize, usize)> = pairs
        .flat_map(|(k, pair)| (0..pair.teeth.len()).map(move |j| (k, j)))
        .collect();
    let teeth: Vec<Tooth> = numbers
        .par_iter()
        .map(|&(k, j)| {
            let stations = &design.sub_gear_pairs[k].teeth[j].stations;
            let flank = |s: &crate::design::Station| Flank {
                phi: s.phi,
                behind: [(Gear::Driver, driver), (Gear::Follower, follower)].map(|(gear, part)| {
                    let (p, n, _) = s.frame(gear);
                    // Of all copies of the tooth that which is least in its place.
                    let copies = (0..sweep::copies(drive, gear)).map(|copy| {
                        let pose = drive.copy(copy);
                        behind(part, pose.apply(p), pose.rotation * n)
                    });
                    let off = |b: f64| match (b - wanted).abs() {
                        off if off.is_finite() => off,
                        _ => f64::INFINITY,
                    };
                    let worst = copies.max_by(|a, b| off(*a).total_cmp(&off(*b)));
                    worst.unwrap_or(f64::NAN)
                }),
            };
            Tooth {
                at: (k, j),
                flanks: stations.iter().map(flank).collect(),
            }
        })
        .collect();
    let touching: Vec<Touching> = teeth.iter().filter_map(|t| span(t, wanted)).collect();
    let mut claims = in_place(&teeth, wanted);
    claims.push(hand_over((design, cycle), &numbers, &touching));
    claims.push(smooth((design, cycle), &teeth, wanted));
    claims.push(drive_through((design, cycle), &touching));
    (claims, touching)
}

/// Every flank where the design puts it.
fn in_place(teeth: &[Tooth], wanted: f64) -> Vec<Claim> {
    let all = || {
        teeth
            .iter()
            .flat_map(|t| t.flanks.iter().map(move |f| (t.at, f)))
    };
    let names = [
        "flanks of the driver in place",
        "flanks of the follower in place",
    ];
    let meaning = "every tooth is where the design puts it, along its whole contact";
    names
        .into_iter()
        .enumerate()
        .map(|(gear, name)| {
            let claim = Claim::new(name, meaning);
            let worst = all().max_by(|a, b| {
                let deviation = |f: &Flank| f.deviation(gear, wanted);
                deviation(a.1).total_cmp(&deviation(b.1))
            });
            match worst {
                Some((at, flank)) => claim
                    .decide(
                        flank.deviation(gear, wanted),
                        "mm",
                        Bound::AtMost(DEVIATION),
                    )
                    .at(Spot::phase(flank.phi).on(Some(at))),
                None => claim.undecided("the design has no contact stations"),
            }
        })
        .collect()
}

/// The longest stretch on which both flanks are in place; `None` where they nowhere are.
fn span(tooth: &Tooth, wanted: f64) -> Option<Touching> {
    let runs = tooth
        .flanks
        .chunk_by(|a, b| a.good(wanted) && b.good(wanted));
    let longest = runs
        .filter(|run| run.iter().all(|f| f.good(wanted)))
        .filter_map(|run| Some((run.first()?.phi, run.last()?.phi)))
        .max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    Some(Touching {
        pair: tooth.at.0 + 1,
        tooth: tooth.at.1 + 1,
        from_deg: longest.0.to_degrees(),
        to_deg: longest.1.to_degrees(),
    })
}

/// Contact ratio as built: every tooth must still be there where the next one takes over.
fn hand_over(
    (design, cycle): (&Design, Cycle),
    teeth: &[(usize, usize)],
    touching: &[Touching],
) -> Claim {
    let claim = Claim::new(
        "hand-over",
        "each tooth takes over before the one before it lets go",
    );
    let ratio = |&(k, j): &(usize, usize)| {
        let touch = touching
            .iter()
            .find(|t| (t.pair, t.tooth) == (k + 1, j + 1));
        let pitch = cycle.length().to_degrees() / design.sub_gear_pairs[k].teeth.len() as f64;
        touch.map_or(0.0, |t| (t.to_deg - t.from_deg) / pitch)
    };
    match teeth.iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b))) {
        Some(worst) => {
            let start = design.sub_gear_pairs[worst.0].teeth[worst.1].phi_start;
            claim
                .decide(ratio(worst), "contact ratio", Bound::AtLeast(1.0))
                .at(Spot::phase(start).on(Some(*worst)))
        }
        None => claim.undecided("the design has no teeth"),
    }
}

/// While two teeth of a pair touch, the flank gap of both must be the same, or the follower jumps.
fn smooth((design, cycle): (&Design, Cycle), teeth: &[Tooth], wanted: f64) -> Claim {
    let claim = Claim::new(
        "no jump at hand-over",
        "the next tooth takes over without a jolt: both leave the same gap",
    );
    let mut worst: Option<(f64, Spot)> = None;
    for tooth in teeth {
        let (k, j) = tooth.at;
        let count = design.sub_gear_pairs[k].teeth.len();
        let Some(next) = teeth.iter().find(|t| t.at == (k, (j + 1) % count)) else {
            continue;
        };
        if j + 1 == count && !cycle.wraps() {
            continue;
        }
        // The first tooth follows the last one a turn later.
        let later = if j + 1 == count { TAU } else { 0.0 };
        for flank in tooth.flanks.iter().filter(|f| f.good(wanted)) {
            let Some(gap) = gap_at(&next.flanks, flank.phi - later, wanted) else {
                continue;
            };
            let jump = (gap - (flank.behind[0] + flank.behind[1])).abs();
            if worst.as_ref().is_none_or(|(w, _)| jump > *w) {
                worst = Some((jump, Spot::phase(flank.phi).on(Some(tooth.at))));
            }
        }
    }
    match worst {
        Some((jump, spot)) => claim.decide(jump, "mm", Bound::AtMost(DEVIATION)).at(spot),
        None => claim.undecided("no two teeth of a pair touch at once"),
    }
}

/// Flank gap at `phi`, linear between stations; `None` beyond them and where a flank is missing.
fn gap_at(flanks: &[Flank], phi: f64, wanted: f64) -> Option<f64> {
    let after = flanks.partition_point(|f| f.phi < phi);
    let (a, b) = (flanks.get(after.checked_sub(1)?)?, flanks.get(after)?);
    let gap = |f: &Flank| f.behind[0] + f.behind[1];
    let t = (phi - a.phi) / (b.phi - a.phi);
    (a.good(wanted) && b.good(wanted)).then(|| gap(a) * (1.0 - t) + gap(b) * t)
}

/// At every driver angle each sub-gear pair must have a tooth pair that touches.
fn drive_through((design, cycle): (&Design, Cycle), touching: &[Touching]) -> Claim {
    let claim = Claim::new(
        "drive-through",
        "at every angle each sub-gear pair has teeth that touch",
    );
    let count = |phi: f64, k: usize| {
        let of_pair = touching.iter().filter(|t| t.pair == k + 1);
        of_pair.filter(|t| t.at(phi)).count()
    };
    let pairs = design.sub_gear_pairs.len();
    let phases = || cycle.phases(PHASES).map(f64::to_degrees);
    let open = phases()
        .flat_map(|phi| (0..pairs).map(move |k| (phi, k)))
        .find(|&(phi, k)| count(phi, k) == 0);
    let at_once = |phi: f64| (0..pairs).map(|k| count(phi, k)).sum::<usize>();
    let least = phases().map(at_once).min().unwrap_or(0);
    let most = phases().map(at_once).max().unwrap_or(0);
    let spot = open.map_or(Spot::default(), |(phi, k)| Spot {
        pair: Some(k + 1),
        ..Spot::phase(phi.to_radians())
    });
    claim
        .say(
            pairs > 0 && open.is_none(),
            format!("{least} to {most} tooth pairs touch at once"),
            &format!("≥ {pairs}, one of each sub-gear pair"),
        )
        .measured(least as f64, "tooth pairs", pairs as f64)
        .at(spot)
}

/// How far the surface of `part` is from `p` along `n`, both in the body's frame.
fn behind(part: &Part, p: Vector3<f64>, n: Vector3<f64>) -> f64 {
    part.tree.nearest(p, 2.0).map_or(f64::NAN, |(near, _)| {
        let offset = near.q - p;
        // Off to the side is not behind: the flank has to be met along the normal.
        offset.norm() * offset.dot(&n).signum()
    })
}
