//! Is the follower held: Q from the contacts, escapes and play on the meshes.

use serde::{Deserialize, Serialize};

use super::check::Effort;
use super::claim::{Bound, Claim, Spot};
use super::escape::Held;
use super::settle::{Beads, End, Limits, Pushes, Rest};
use super::{Mechanism, Proof, directions};
use crate::certified::Certified;
use crate::closure::{Wrench, measure, wrench};
use crate::design::{ClosureSample, Design};
use crate::load::contacts::Configuration;
use crate::load::{LoadReport, LoadSample, Sampling, analyse};
use crate::motion::Motion;
use crate::{Error, Result};

/// Name of the claim that the payload which the settings demand is carried.
pub const PAYLOAD: &str = "payload";

/// Play beyond this share of its first-order bound is not play but a missing flank.
const PLAY_SHARE: f64 = 1.5;

/// How far the follower can be moved until it touches the driver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Play {
    /// Driver angle, rad.
    pub phi: f64,
    /// Unit direction in span(U), order linear (mm), angular (rad).
    pub direction: Vec<f64>,
    /// Distance on the meshes, in units of the direction; `None` when it does not touch within
    /// three times the first-order bound.
    pub distance: Option<f64>,
    /// First-order bound clearance/Q.
    pub first_order: f64,
}

/// Q, Q* and η from the stations and the motion; `None` when some φ has no contact.
pub(super) fn closure(design: &Design, motion: &Motion) -> Option<Vec<ClosureSample>> {
    let gear = &design.settings.gear;
    let cycle = motion.cycle();
    let count = cycle.pairs(gear.tooth_pairs()) * gear.samples;
    let dof = design.class.dof();
    (0..count)
        .map(|i| {
            let phi = cycle.part(i, count);
            let at = Configuration::at(design, motion, phi).ok()?;
            let wrenches = |length: f64| -> Vec<Wrench> {
                at.contacts
                    .iter()
                    .map(|c| wrench(at.class, c.p, c.n, at.centre, length))
                    .collect()
            };
            let star = wrenches(0.5 * gear.center_distance_mm);
            let size = |w: &Wrench| w.iter().map(|x| x * x).sum::<f64>().sqrt();
            let mean = star.iter().map(size).sum::<f64>() / star.len() as f64;
            let q_star = measure(&star, dof);
            let q = measure(&wrenches(1.0), dof);
            Some(ClosureSample {
                phi,
                q,
                q_star,
                eta: dof as f64 * q_star / mean,
            })
        })
        .collect()
}

/// Claims about Q: at the samples `samples`, and between them what is `certified`.
pub(super) fn closure_claims(
    design: &Design,
    samples: Option<&[ClosureSample]>,
    certified: Option<Certified>,
) -> Vec<Claim> {
    let gear = &design.settings.gear;
    let claim = || {
        Claim::new(
            "dynamic form closure",
            "the driver holds the follower in every direction it could move",
        )
    };
    let Some(samples) = samples.filter(|s| !s.is_empty()) else {
        return vec![
            claim().undecided("some driver angle has no tooth in contact, or too few stations"),
        ];
    };
    let least = |get: fn(&ClosureSample) -> f64| {
        samples
            .iter()
            .min_by(|a, b| get(a).total_cmp(&get(b)))
            .map_or((f64::NAN, 0.0), |s| (get(s), s.phi))
    };
    let (q, _) = least(|s| s.q);
    let (eta, eta_phi) = least(|s| s.eta);
    let valid = samples
        .iter()
        .filter(|s| s.q > gear.closure_threshold)
        .count() as f64
        / samples.len() as f64;
    let stored = design
        .closure
        .iter()
        .map(|s| s.q)
        .fold(f64::INFINITY, f64::min);
    let scaled = Claim::new(
        "form closure, dimensionless",
        "the same with lengths measured in L/2",
    );
    let [closed, scaled] = match certified {
        Some(least) => {
            let limit = Bound::AtLeast(gear.closure_threshold);
            let closed = claim().decide(least.q, "(min Q, at every φ)", limit);
            let zero = Bound::AtLeast(0.0);
            [
                closed.at(Spot::phase(least.phi)),
                scaled.decide(least.q_star, "(min Q*, at every φ)", zero),
            ]
        }
        None => [claim(), scaled]
            .map(|claim| claim.undecided("the teeth have too few stations, or do not share them")),
    };
    vec![
        closed,
        scaled,
        Claim::new(
            "quality of the hold",
            "how close it comes to the best that contacts of this size allow",
        )
        .decide(eta, "(min η)", Bound::AtLeast(0.0))
        .at(Spot::phase(eta_phi)),
        Claim::new("share of the turn", "the hold is there all the time").decide(
            valid,
            "(E_validTime)",
            Bound::AtLeast(1.0),
        ),
        match Claim::new(
            "figures of the file",
            "min Q in design.json is what its contacts give",
        ) {
            claim if design.closure.is_empty() => claim.undecided("the file states no Q"),
            claim => claim.decide(
                (stored - q).abs() / q.abs().max(f64::MIN_POSITIVE),
                "relative difference",
                Bound::AtMost(0.02),
            ),
        },
    ]
}

/// Claim that no push gets through.
pub(super) fn escape_claim(proof: &Proof) -> Claim {
    Claim::new(
        "no escape",
        "a small push in any direction is stopped by a tooth",
    )
    .say(
        proof.escapes.is_empty() && proof.displacements > 0,
        format!(
            "{} of {} pushes got through",
            proof.escapes.len(),
            proof.displacements
        ),
        "0",
    )
    .measured(proof.escapes.len() as f64, "", 0.0)
    .at(proof.escapes.first().map_or(Spot::default(), |e| {
        Spot::phase(e.phi).towards(&e.direction)
    }))
}

/// Play at evenly spread phases in the directions of the escape test.
pub(super) fn plays(
    held: &Held,
    closure: &[ClosureSample],
    (effort, clearance): (&Effort, f64),
) -> Vec<Play> {
    let directions = directions(held.mechanism.motion.class(), effort.directions);
    let cycle = held.mechanism.motion.cycle();
    cycle
        .phases(effort.play_phases)
        .flat_map(|phi| {
            let q = super::q_at(closure, phi).unwrap_or(f64::NAN);
            let first_order = clearance / q;
            let distances = if first_order > 0.0 && first_order.is_finite() {
                held.play(phi, &directions, 3.0 * first_order)
            } else {
                vec![None; directions.len()]
            };
            directions
                .iter()
                .zip(distances)
                .map(|(u, distance)| Play {
                    phi,
                    direction: u.iter().copied().collect(),
                    distance,
                    first_order,
                })
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Claims that the follower is not looser than the settings allow (what the flanks alone leave it, with
/// the motor held) and carries what it has to; with the load report that they rest on.
pub(super) fn load_claims(design: &Design, motion: &Motion) -> (Vec<Claim>, Option<LoadReport>) {
    let report = analyse(design, motion, &design.settings.load, Sampling::of(motion));
    let mut claims = play_limits(design, &report).to_vec();
    claims.push(payload_claim(design, &report));
    (claims, report.ok())
}

/// Claim that the mechanism carries what its `[load]` demands.
fn payload_claim(design: &Design, report: &Result<LoadReport>) -> Claim {
    let claim = Claim::new(
        PAYLOAD,
        "what the load point may carry before a contact or a tooth's root reaches its limit",
    );
    let load = &design.settings.load;
    let demand = load.payload_at_least_g;
    match report {
        Ok(report) if report.payload_max.is_infinite() => {
            claim.say(true, "unlimited", &format!("≥ {demand} g"))
        }
        Ok(report) => claim.decide(1e3 * report.payload_max, "g", Bound::AtLeast(demand)),
        Err(error) => claim.undecided(&in_a_line(error)),
    }
}

/// An error without its hint.
fn in_a_line(error: &Error) -> String {
    match error {
        Error::Infeasible { reason, place, .. } => format!("{reason}, {place}"),
        error => error.to_string(),
    }
}

fn play_limits(design: &Design, report: &Result<LoadReport>) -> [Claim; 2] {
    let fit = &design.settings.fit;
    type Get = fn(&LoadSample) -> f64;
    let limits: [(_, _, Get, _, _); 2] = [
        (
            "play as an angle",
            "how far the flanks let the follower turn, with the motor held",
            |s| s.play_turn.to_degrees(),
            "°",
            fit.max_play_deg,
        ),
        (
            "play at the load point",
            "how far the flanks let the load point move, with the motor held",
            |s| s.play_point,
            "mm",
            fit.max_play_mm,
        ),
    ];
    limits.map(|(name, meaning, get, unit, most)| {
        let claim = Claim::new(name, meaning);
        let worst = report.as_ref().map(|report| {
            let samples = report.samples.iter();
            samples.max_by(|a, b| get(a).total_cmp(&get(b)))
        });
        match worst {
            Ok(Some(worst)) => claim
                .decide(get(worst), unit, Bound::AtMost(most))
                .at(Spot::phase(worst.phi)),
            Ok(None) => claim.undecided("nothing was tried"),
            Err(error) => claim.undecided(&in_a_line(error)),
        }
    })
}

/// Limits of the play, as a share of those that the settings allow, at which a push is given up.
const GIVEN_UP: f64 = 2.0;

/// Claim that flanks alone hold the follower, wherever it slides along them.
pub(super) fn flanks_claim(design: &Design, mechanism: &Mechanism, effort: &Effort) -> Claim {
    let claim = Claim::new(
        "held by the flanks alone",
        "with ribs left out, a push in any direction comes to rest on flanks, however it slides along them",
    );
    let fit = &design.settings.fit;
    let limits = Limits {
        turn: fit.max_play_deg.to_radians(),
        shift: fit.max_play_mm,
    };
    let beads = match Beads::new(design) {
        Ok(beads) => beads,
        Err(error) => return claim.undecided(&error.to_string()),
    };
    let pushes = Pushes {
        beads: &beads,
        mechanism: *mechanism,
        point: design.settings.load.point_mm.into(),
        limits: Limits {
            turn: GIVEN_UP * limits.turn,
            shift: GIVEN_UP * limits.shift,
        },
    };
    // Of the few corners that play has, some direction leads to each.
    let directions = directions(mechanism.motion.class(), effort.directions.div_ceil(2));
    let count = effort.play_phases.div_ceil(2);
    let phases = mechanism.motion.cycle().phases(count);
    let rests: Vec<Rest> = phases.flat_map(|phi| pushes.at(phi, &directions)).collect();
    let share = |rest: &Rest| match rest.end {
        End::Held => (rest.turn / limits.turn).max(rest.point / limits.shift),
        End::Loose | End::Met => f64::INFINITY,
    };
    let Some(worst) = rests.iter().max_by(|a, b| share(a).total_cmp(&share(b))) else {
        return claim.undecided("nothing was tried");
    };
    let figure = match worst.end {
        End::Held => format!(
            "{:.3}°, {:.3} mm at the load point",
            worst.turn.to_degrees(),
            worst.point
        ),
        End::Loose => "does not come to rest".into(),
        End::Met => "flanks meet before anything is pushed".into(),
    };
    let limit = format!("≤ {}°, {} mm", fit.max_play_deg, fit.max_play_mm);
    let direction: Vec<f64> = worst.push.iter().copied().collect();
    claim
        .say(share(worst) <= 1.0, figure, &limit)
        .measured(share(worst), "of the play allowed", 1.0)
        .at(Spot::phase(worst.phi).towards(&direction))
}

/// Claim that the play is what the gap allows.
pub(super) fn play_claim(play: &[Play]) -> Claim {
    let claim = Claim::new(
        "play",
        "how far the follower can be moved until it touches, against the first-order gap/Q",
    );
    let ratio = |p: &Play| p.distance.map_or(f64::INFINITY, |d| d / p.first_order);
    let Some(worst) = play.iter().max_by(|a, b| ratio(a).total_cmp(&ratio(b))) else {
        return claim.undecided("nothing was tried");
    };
    let figure = match worst.distance {
        Some(d) => format!(
            "{d:.5} (rad, mm), {:.2} of first order {:.5}",
            ratio(worst),
            worst.first_order
        ),
        None => "unbounded".into(),
    };
    claim
        .say(
            ratio(worst) <= PLAY_SHARE,
            figure,
            &format!("≤ {PLAY_SHARE} of first order"),
        )
        .measured(ratio(worst), "of first order", PLAY_SHARE)
        .at(Spot::phase(worst.phi).towards(&worst.direction))
}
