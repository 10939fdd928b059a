//! `mpcgear check`: every claim that a working mechanism makes, tried on the design file and the
//! meshes alone.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::claim::Claim;
use super::escape::Held;
use super::fabrication::{self, Printer};
use super::failure::{self, Recognised};
use super::hold::{self, Play};
use super::overlap::Part;
use super::touching::{self, Touching};
use super::{
    Mechanism, Progress, Proof, ProofSettings, apart, conjugation, insertion, joints, prove,
};
use crate::certified::{self, Certified};
use crate::design::{ClosureSample, Design};
use crate::load::LoadReport;
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

impl Effort {
    /// The default times `share`, never less than a few phases.
    pub fn scaled(share: f64) -> Effort {
        let Effort {
            steps,
            escape_phases,
            directions,
            play_phases,
        } = Effort::default();
        let of = |count: usize, least: usize| ((count as f64 * share).ceil() as usize).max(least);
        Effort {
            steps: of(steps, 90),
            escape_phases: of(escape_phases, 12),
            directions: of(directions, 8),
            play_phases: of(play_phases, 6),
        }
    }
}

/// The table of claims with what it rests on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// All claims.
    pub claims: Vec<Claim>,
    /// Q over the turn, from the contacts; empty where some angle has none.
    pub closure: Vec<ClosureSample>,
    /// Tooth pairs that touch, as the meshes have them.
    pub touching: Vec<Touching>,
    /// Play per phase and direction.
    pub play: Vec<Play>,
    /// Known failures that were recognised.
    pub failures: Vec<Recognised>,
    /// The proof on the meshes; `None` when driver or follower is missing.
    pub proof: Option<Proof>,
    /// What it carries under the `[load]` of its settings; `None` where the contacts cannot hold that.
    #[serde(skip)]
    pub load: Option<LoadReport>,
    /// Lower bounds of Q and Q* for every φ; `None` where there are none.
    #[serde(skip)]
    pub certified: Option<Certified>,
}

impl Check {
    /// Whether every claim holds.
    pub fn holds(&self) -> bool {
        self.claims.iter().all(|c| c.holds)
    }

    /// Everything that fails, one plain sentence each.
    pub fn problems(&self) -> Vec<String> {
        let failed = self.claims.iter().filter(|c| !c.holds);
        failed
            .map(|c| {
                let place = match c.place.as_str() {
                    "" => String::new(),
                    place => format!(" at {place}"),
                };
                format!("{}: {}{place}; wanted {}", c.name, c.figure, c.limit)
            })
            .collect()
    }
}

/// Share of the work that the proof on the meshes is.
const PROOF_SHARE: f64 = 0.8;

/// Tries every claim.
///
/// # Errors
/// [`Error::Interrupted`] when `progress` breaks.
pub fn check(input: &CheckInput, progress: &mut Progress) -> Result<Check> {
    let samples = hold::closure(input.design, input.motion);
    let mechanism = input.mechanism();
    let proof = match input.complete() {
        true => Some(prove(
            input.bodies,
            &mechanism,
            (&input.proof_settings(), &known(samples.as_deref())),
            &mut |what, done| progress(what, PROOF_SHARE * done),
        )?),
        false => None,
    };
    examine(input, proof, &mut |what, done| {
        progress(what, PROOF_SHARE + (1.0 - PROOF_SHARE) * done)
    })
}

/// Tries every claim, with the `proof` on the meshes already made with the settings that
/// [`CheckInput::proof_settings`] gives.
///
/// # Errors
/// [`Error::Interrupted`] when `progress` breaks.
pub fn examine(
    input: &CheckInput,
    mut proof: Option<Proof>,
    progress: &mut Progress,
) -> Result<Check> {
    let mut step = |what: &'static str, done: f64| match progress(what, done) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    };
    step("proof: hold", 0.0)?;
    let design = input.design;
    let mechanism = input.mechanism();
    let samples = hold::closure(design, input.motion);
    let q_min = known(samples.as_deref())
        .iter()
        .map(|s| s.q)
        // Q that is not known anywhere is not known.
        .fold(
            f64::INFINITY,
            |least, q| if q.is_nan() { q } else { least.min(q) },
        );
    let mut claims = conjugation::claims(design, input.motion, q_min);
    let certified = certified::of(design, input.motion);
    claims.extend(hold::closure_claims(design, samples.as_deref(), certified));
    let (load_claims, load) = hold::load_claims(design, input.motion);
    claims.extend(load_claims);
    claims.push(hold::flanks_claim(design, &mechanism, &input.effort));
    let closure = samples.unwrap_or_default();
    let (mut play, mut touching, mut failures) = (Vec::new(), Vec::new(), Vec::new());
    match &mut proof {
        Some(proof) if !proof.pairs.is_empty() => {
            claims.extend(apart::mesh_claims(proof));
            step("proof: overlap as drawn", 0.1)?;
            let parts: Vec<Part> = input.bodies.iter().map(Part::new).collect();
            let find = |carrier: Carrier| {
                let part = parts.iter().find(|p| p.body.carrier == carrier);
                part.ok_or_else(|| Error::Internal(format!("no {carrier:?} among the bodies")))
            };
            let (driver, follower) = (find(Carrier::Driver)?, find(Carrier::Follower)?);
            claims.extend(apart::overlap_claims(proof, &parts, design, &mechanism));
            claims.push(hold::escape_claim(proof));
            let held = Held {
                driver,
                follower,
                mechanism,
            };
            step("proof: play", 0.2)?;
            let clearance = design.settings.fit.clearance_mm;
            play = hold::plays(&held, &known(Some(&closure)), (&input.effort, clearance));
            claims.push(hold::play_claim(&play));
            step("proof: flanks", 0.7)?;
            let (contacts, spans) =
                touching::claims(design, input.motion.cycle(), (driver, follower));
            claims.extend(contacts);
            touching = spans;
            step("proof: joints", 0.8)?;
            let joint_play = design.settings.fit.joint_play_mm;
            claims.extend(joints::claims(&parts, &mechanism, (joint_play, &play)));
            step("proof: assembly", 0.9)?;
            claims.extend(insertion::claims(design, &parts, &mechanism));
            failures = failure::recognise(design, &mechanism, &proof.pairs);
        }
        proof => {
            let why = match proof {
                Some(proof) => {
                    claims.extend(apart::mesh_claims(proof));
                    "a mesh is empty, unreadable or no surface"
                }
                None => "there is no driver or no follower",
            };
            for name in [
                "no overlap",
                "no escape",
                "flanks in place",
                "joint holds the follower",
                "assembly",
            ] {
                let claim = Claim::new(name, "cannot be tried without the meshes");
                claims.push(claim.undecided(why));
            }
        }
    }
    let pieces = input
        .pieces
        .iter()
        .map(|(name, mesh)| (name.as_str(), mesh));
    claims.extend(fabrication::claims(pieces, &input.printer));
    claims.extend(failures.iter().map(failure::claim));
    Ok(Check {
        claims,
        closure,
        touching,
        play,
        failures,
        proof,
        load,
        certified,
    })
}

impl CheckInput<'_> {
    fn mechanism(&self) -> Mechanism<'_> {
        Mechanism {
            motion: self.motion,
            drive: self.design.settings.gear.drive(),
        }
    }

    /// Whether there are a driver and a follower to prove anything about.
    fn complete(&self) -> bool {
        let has = |carrier| self.bodies.iter().any(|b| b.carrier == carrier);
        has(Carrier::Driver) && has(Carrier::Follower)
    }

    /// What the proof on the meshes has to demand.
    pub fn proof_settings(&self) -> ProofSettings {
        let settings = &self.design.settings;
        ProofSettings {
            clearance_mm: settings.fit.clearance_mm,
            minimum_wall_mm: settings.gear.minimum_wall_mm,
            grown_by_mm: self.printer.tolerance_mm,
            phases: self.effort.steps,
            escape_phases: self.effort.escape_phases,
            directions: self.effort.directions,
        }
    }
}

/// Q over the turn; where it is not known no displacement has a size, and every one of them counts as
/// an escape.
fn known(samples: Option<&[ClosureSample]>) -> Vec<ClosureSample> {
    match samples {
        Some(samples) if !samples.is_empty() => samples.to_vec(),
        _ => vec![ClosureSample {
            phi: 0.0,
            q: f64::NAN,
            q_star: f64::NAN,
            eta: f64::NAN,
        }],
    }
}
