//! `mpcgear check`: every claim that a working mechanism makes, tried on the design file and the
//! meshes alone.

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::claim::{Bound, Claim};
use super::escape::Held;
use super::fabrication::{self, Printer};
use super::failure::{self, Recognised};
use super::overlap::{self, OverlapSettings, Part};
use super::{
    Mechanism, Progress, Proof, ProofSettings, conjugation, directions, joints, prove, touching,
};
use crate::closure::{Wrench, measure, wrench};
use crate::design::{ClosureSample, Design};
use crate::load::contacts::Configuration;
use crate::motion::Motion;
use crate::solid::Mesh;
use crate::solid::assembly::{Carrier, SolidBody};
use crate::{Error, Result};

/// Everything that is checked.
#[derive(Debug, Clone, Copy)]
pub struct CheckInput<'a> {
    /// The design.
    pub design: &'a Design,
    /// Its motion.
    pub motion: &'a Motion,
    /// Bodies in their own frames; from the solids, or from files by [`Mechanism::assembled`].
    pub bodies: &'a [SolidBody],
    /// Pieces as they lie on the printer's bed, by name; may be empty.
    pub pieces: &'a [(String, Mesh)],
    /// The printer.
    pub printer: Printer,
    /// How densely to look; what to demand is the design's.
    pub effort: Effort,
}

/// How densely to look. Default 360 steps of the turn, 72 phases and 32 directions of escape, 24
/// phases of play.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Least number of steps the turn is cut into.
    pub steps: usize,
    /// Phases at which escapes are tried.
    pub escape_phases: usize,
    /// Directions tried at each.
    pub directions: usize,
    /// Phases at which the play is measured.
    pub play_phases: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Effort {
            steps: 360,
            escape_phases: 72,
            directions: 32,
            play_phases: 24,
        }
    }
}

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

/// The table of claims with what it rests on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// All claims.
    pub claims: Vec<Claim>,
    /// The proof on the meshes.
    pub proof: Proof,
    /// Play per phase and direction.
    pub play: Vec<Play>,
    /// Known failures that were recognised.
    pub failures: Vec<Recognised>,
}

impl Check {
    /// Whether every claim holds.
    pub fn holds(&self) -> bool {
        self.claims.iter().all(|c| c.holds)
    }
}

/// Tries every claim.
///
/// # Errors
/// [`Error::Interrupted`] when `progress` breaks; [`Error::Internal`] when driver or follower is missing.
pub fn check(input: &CheckInput, progress: &mut Progress) -> Result<Check> {
    let design = input.design;
    let settings = &design.settings;
    let mechanism = Mechanism {
        motion: input.motion,
        center_distance: settings.gear.center_distance_mm,
    };
    let mut claims = conjugation::claims(design, input.motion);
    let samples = closure(design, input.motion);
    claims.extend(closure_claims(design, &samples));
    let proof_settings = ProofSettings {
        clearance_mm: settings.fit.clearance_mm,
        minimum_wall_mm: settings.gear.minimum_wall_mm,
        grown_by_mm: input.printer.tolerance_mm,
        phases: input.effort.steps,
        escape_phases: input.effort.escape_phases,
        directions: input.effort.directions,
    };
    let known = samples.as_deref().unwrap_or(&[]);
    // Without Q no displacement has a size; every one of them then counts as an escape.
    let nothing = [ClosureSample {
        phi: 0.0,
        q: f64::NAN,
        q_star: f64::NAN,
        eta: f64::NAN,
    }];
    let known = if known.is_empty() { &nothing } else { known };
    let mut proof = prove(input.bodies, &mechanism, (&proof_settings, known), progress)?;
    claims.extend(mesh_claims(&proof));
    let mut play = Vec::new();
    if proof.pairs.is_empty() {
        for name in [
            "no overlap",
            "no escape",
            "flanks in place",
            "joint holds the follower",
        ] {
            let claim = Claim::new(name, "cannot be tried on these meshes");
            claims.push(claim.undecided("a mesh is empty or unreadable"));
        }
    } else {
        let parts: Vec<Part> = input.bodies.iter().map(Part::new).collect();
        let find = |carrier: Carrier| {
            parts
                .iter()
                .find(|p| p.body.carrier == carrier)
                .ok_or_else(|| Error::Internal(format!("no {carrier:?} among the bodies")))
        };
        let (driver, follower) = (find(Carrier::Driver)?, find(Carrier::Follower)?);
        claims.extend(overlap_claims(
            &mut proof,
            &parts,
            &mechanism,
            &proof_settings,
        ));
        claims.push(escape_claim(&proof));
        let held = Held {
            driver,
            follower,
            mechanism,
        };
        play = plays(&held, known, (&input.effort, settings.fit.clearance_mm));
        claims.push(play_claim(&play));
        claims.extend(touching::claims(design, (driver, follower)));
        claims.extend(joints::claims(
            &parts,
            &mechanism,
            settings.fit.joint_play_mm,
        ));
    }
    let pieces = input
        .pieces
        .iter()
        .map(|(name, mesh)| (name.as_str(), mesh));
    claims.extend(fabrication::claims(pieces, &input.printer));
    let failures = failure::recognise(design, &mechanism, &proof.pairs);
    for f in &failures {
        let name = |t: Option<(usize, usize)>| {
            t.map_or("no tooth".into(), |(k, j)| {
                format!("pair {} tooth {}", k + 1, j + 1)
            })
        };
        claims.push(
            Claim::new("known failure", &f.failure.to_string())
                .say(
                    false,
                    format!(
                        "driver: {}, follower: {}",
                        name(f.driver_tooth),
                        name(f.follower_tooth)
                    ),
                    "none of the known failures",
                )
                .at(f.place.to_string()),
        );
    }
    Ok(Check {
        claims,
        proof,
        play,
        failures,
    })
}

/// Q, Q* and η from the stations and the motion; `None` when some φ has no contact.
fn closure(design: &Design, motion: &Motion) -> Option<Vec<ClosureSample>> {
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

fn closure_claims(design: &Design, samples: &Option<Vec<ClosureSample>>) -> Vec<Claim> {
    let gear = &design.settings.gear;
    let claim = || {
        Claim::new(
            "dynamic form closure",
            "the driver holds the follower in every direction it could move",
        )
    };
    let Some(samples) = samples.as_ref().filter(|s| !s.is_empty()) else {
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
    let place = |phi: f64| format!("φ = {:.2}°", phi.to_degrees());
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
            .at(place(q_phi)),
        Claim::new(
            "form closure, dimensionless",
            "the same with lengths measured in L/2",
        )
        .decide(q_star, "(min Q*)", Bound::AtLeast(0.0))
        .at(place(star_phi)),
        Claim::new(
            "quality of the hold",
            "how close it comes to the best that contacts of this size allow",
        )
        .decide(eta, "(min η)", Bound::AtLeast(0.0))
        .at(place(eta_phi)),
        Claim::new("share of the turn", "the hold is there all the time").decide(
            valid,
            "(E_validTime)",
            Bound::AtLeast(1.0),
        ),
        Claim::new(
            "figures of the file",
            "min Q in design.json is what its contacts give",
        )
        .decide(
            (stored - q).abs() / q.abs(),
            "relative difference",
            Bound::AtMost(0.02),
        ),
    ]
}

fn mesh_claims(proof: &Proof) -> Vec<Claim> {
    let mesh = Claim::new("closed meshes", "every body is one closed, clean surface");
    let mut claims = vec![match proof.mesh_problems.first() {
        None => mesh.say(true, "no defects", "no defects"),
        Some(first) => mesh.say(false, first.to_string(), "no defects"),
    }];
    for (body, wall) in &proof.walls {
        let claim = Claim::new(
            format!("walls of the {body}"),
            "nothing is too thin to print",
        );
        claims.push(match wall {
            Some(w) => claim
                .decide(w.thickness_mm, "mm", Bound::AtLeast(proof.minimum_wall_mm))
                .at(format!(
                    "({:.2}, {:.2}, {:.2}) mm",
                    w.at[0], w.at[1], w.at[2]
                )),
            None => claim.say(
                true,
                format!("> {:.2} mm", 1.25 * proof.minimum_wall_mm),
                &format!("≥ {} mm", proof.minimum_wall_mm),
            ),
        });
    }
    claims
}

/// Two claims a pair: apart, and apart when grown. The proof was made for grown parts; where it
/// fails, the parts as drawn are walked again and take its place.
fn overlap_claims(
    proof: &mut Proof,
    parts: &[Part],
    mechanism: &Mechanism,
    settings: &ProofSettings,
) -> Vec<Claim> {
    let mut claims = Vec::new();
    for pair in &mut proof.pairs {
        let [a, b] = pair.bodies.clone();
        let grown = pair.clone();
        if !grown.holds() {
            let find = |name: &str| parts.iter().find(|p| p.body.name == name);
            if let (Some(first), Some(second)) = (find(&a), find(&b)) {
                let plain = OverlapSettings {
                    steps: settings.phases,
                    floor: 0.0,
                };
                *pair = overlap::apart((first, second), mechanism, &plain);
            }
        }
        let claim = Claim::new(
            format!("{a} and {b} stay apart"),
            "the parts never meet, at any angle, turning either way",
        );
        let figure = match (pair.overlap_at, pair.doubts.len()) {
            (Some(_), _) => format!(
                "{} shared in {} steps of the turn",
                pair.overlap_mm3
                    .map_or("unmeasured volume".into(), |v| format!("{v:.4} mm³")),
                pair.colliding_steps
            ),
            (None, 0) => format!("{:.4} mm smallest gap", pair.gap_mm),
            (None, n) => format!("undecided in {n} steps of the turn"),
        };
        let place = pair
            .overlap_at
            .or(pair.doubts.first().copied())
            .unwrap_or(pair.gap_at);
        claims.push(
            claim
                .say(pair.holds(), figure, "0 mm³, proven for every φ")
                .at(place.to_string()),
        );
        claims.push(
            Claim::new(
                format!("{a} and {b} stay apart as printed"),
                "the same with every surface grown by the printer's tolerance",
            )
            .say(
                grown.holds(),
                format!("{:.4} mm smallest gap", grown.gap_mm),
                &format!("> {:.3} mm everywhere", 2.0 * settings.grown_by_mm),
            )
            .at(grown
                .doubts
                .first()
                .copied()
                .unwrap_or(grown.gap_at)
                .to_string()),
        );
    }
    claims
}

fn escape_claim(proof: &Proof) -> Claim {
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
    .at(proof.escapes.first().map_or(String::new(), |e| {
        format!(
            "φ = {:.2}°, direction {:.3?}",
            e.phi.to_degrees(),
            e.direction
        )
    }))
}

/// Play at evenly spread phases in the directions of the escape test.
fn plays(held: &Held, closure: &[ClosureSample], (effort, clearance): (&Effort, f64)) -> Vec<Play> {
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

fn play_claim(play: &[Play]) -> Claim {
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
        .say(ratio(worst) <= 1.5, figure, "≤ 1.5 of first order")
        .at(format!(
            "φ = {:.2}°, direction {:.3?}",
            worst.phi.to_degrees(),
            worst.direction
        ))
}
