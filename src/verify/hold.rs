//! Is the follower held: Q from the contacts, escapes and play on the meshes.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::check::Effort;
use super::claim::{Bound, Claim, Spot};
use super::escape::Held;
use super::{Proof, directions};
use crate::Error;
use crate::closure::{Wrench, measure, wrench};
use crate::design::{ClosureSample, Design};
use crate::load::contacts::Configuration;
use crate::load::{LoadSample, Sampling, analyse};
use crate::motion::Motion;

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
    let count = gear.teeth * gear.samples;
    let dof = design.class.dof();
    (0..count)
        .map(|i| {
            let phi = TAU * i as f64 / count as f64;
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

/// Claims about Q.
pub(super) fn closure_claims(design: &Design, samples: Option<&[ClosureSample]>) -> Vec<Claim> {
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
    let (q, q_phi) = least(|s| s.q);
    let (q_star, star_phi) = least(|s| s.q_star);
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
    vec![
        claim()
            .decide(q, "(min Q)", Bound::AtLeast(gear.closure_threshold))
            .at(Spot::phase(q_phi)),
        Claim::new(
            "form closure, dimensionless",
            "the same with lengths measured in L/2",
        )
        .decide(q_star, "(min Q*)", Bound::AtLeast(0.0))
        .at(Spot::phase(star_phi)),
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
    (0..effort.play_phases)
        .flat_map(|i| {
            let phi = TAU * i as f64 / effort.play_phases as f64;
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

/// Claims that the follower is not looser than the settings allow: what the flanks alone leave it, with
/// the motor held.
pub(super) fn play_limits(design: &Design, motion: &Motion) -> [Claim; 2] {
    let fit = &design.settings.fit;
    let report = analyse(design, motion, &design.settings.load, Sampling::default());
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
            Err(Error::Infeasible { reason, place, .. }) => {
                claim.undecided(&format!("{reason}, {place}"))
            }
            Err(error) => claim.undecided(&error.to_string()),
        }
    })
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
