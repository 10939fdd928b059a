//! The main job: motion file → search → solids → proof, falling back to the next best choice of bands
//! when the meshes refuse the best.

use std::ops::ControlFlow;

use crate::design::Design;
use crate::motion::{Motion, MotionFile};
use crate::search::{self, Progress, StopReason, paper_search};
use crate::settings::Method;
use crate::solid::Solids;
use crate::synthesis::{self, Bands};
use crate::verify::{self, Mechanism, Proof, ProofSettings};
use crate::{Error, Result};

/// A finished job: the design with everything that was made from it and found out about it.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The design; its `problems` are empty when it works.
    pub design: Design,
    /// Bodies and print pieces.
    pub solids: Solids,
    /// Proof on the meshes; `None` when the run was stopped before.
    pub proof: Option<Proof>,
    /// Largest |n·v_rel|, |n·T²|, mm/rad.
    pub residual: f64,
    /// Whether the search was cut short.
    pub stop: StopReason,
}

/// Largest conjugation residual of a working design, mm/rad.
pub const RESIDUAL_LIMIT: f64 = 1e-6;

/// Designs the mechanism of `file`. When no choice of bands passes the proof, the one with the fewest
/// problems is returned with them.
///
/// # Errors
/// As [`search::run`]; [`Error::Infeasible`] when no choice leaves room for the joint; and
/// [`Error::Internal`] for solids the kernel cannot build.
pub fn run(file: &MotionFile, motion: &Motion, observer: &mut search::Observer) -> Result<Outcome> {
    let (choices, stop) = choices(file, motion, observer)?;
    let mut best: Option<Outcome> = None;
    let mut failure = None;
    for (i, (bands, q)) in choices.iter().enumerate() {
        let mut tell = |stage: &'static str, done: f64| {
            let done = (i as f64 + done) / choices.len() as f64;
            observer(&Progress {
                stage,
                done,
                candidates: 0,
                best_q: Some(*q),
            })
        };
        // Once the search was told to stop, there is only the best choice to be finished.
        if let Some(best) = &mut best
            && (stop == StopReason::Stopped || tell(search::FALLBACK, 0.0).is_break())
        {
            best.stop = StopReason::Stopped;
            break;
        }
        // After an interrupt the best choice is still built, but not proven.
        let stopped = tell("solids", 0.0).is_break();
        let mut design = synthesis::design(file, motion, bands)?;
        let solids = match Solids::build(&design, motion) {
            Ok(solids) => solids,
            Err(error) => {
                failure = Some(error);
                continue;
            }
        };
        design.recipe = solids.recipe.clone();
        let mut outcome = Outcome {
            residual: synthesis::conjugation_residual(&design, motion),
            design,
            solids,
            proof: None,
            stop: if stopped { StopReason::Stopped } else { stop },
        };
        if !stopped {
            match prove(&outcome, motion, &mut |done| {
                tell("proof on the meshes", 0.1 + 0.9 * done)
            }) {
                Ok(proof) => outcome.proof = Some(proof),
                Err(Error::Interrupted) => outcome.stop = StopReason::Stopped,
                Err(error) => return Err(error),
            }
        }
        outcome.design.problems = problems(&outcome);
        let fewer = best
            .as_ref()
            .is_none_or(|b| outcome.design.problems.len() < b.design.problems.len());
        let done = outcome.design.problems.is_empty() || outcome.proof.is_none();
        let stop = outcome.stop;
        if fewer {
            best = Some(outcome);
        }
        if let Some(best) = &mut best {
            best.stop = stop;
        }
        if done {
            break;
        }
    }
    best.ok_or_else(|| failure.unwrap_or(Error::Interrupted))
}

/// Choices of bands, best first, with their min Q, by the method that the settings ask for.
fn choices(
    file: &MotionFile,
    motion: &Motion,
    observer: &mut search::Observer,
) -> Result<(Vec<(Bands, f64)>, StopReason)> {
    let settings = &file.settings;
    Ok(match settings.search.method {
        Method::Exact => {
            let found = search::run(motion, settings, observer)?;
            let choices = found.choices.into_iter();
            (
                choices.map(|(b, q)| (Bands::Exact(b), q)).collect(),
                found.stop,
            )
        }
        Method::Paper => {
            let found = paper_search::run(motion, settings, observer)?;
            let choices = found.choices.into_iter();
            (
                choices.map(|(b, q)| (Bands::Paper(b), q)).collect(),
                found.stop,
            )
        }
    })
}

fn prove(
    outcome: &Outcome,
    motion: &Motion,
    tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Proof> {
    let settings = &outcome.design.settings;
    let mechanism = Mechanism {
        motion,
        center_distance: settings.gear.center_distance_mm,
    };
    let proof = ProofSettings {
        clearance_mm: settings.fit.clearance_mm,
        minimum_wall_mm: settings.gear.minimum_wall_mm,
        ..ProofSettings::default()
    };
    verify::prove(
        &outcome.solids.bodies,
        &mechanism,
        (&proof, &outcome.design.closure),
        &mut |_, done| tell(done),
    )
}

/// Everything that keeps the design from working, one sentence each.
fn problems(outcome: &Outcome) -> Vec<String> {
    let mut problems = Vec::new();
    let gear = &outcome.design.settings.gear;
    let closure = &outcome.design.closure;
    if let Some(worst) = closure.iter().min_by(|a, b| a.q.total_cmp(&b.q))
        && !(worst.q > gear.closure_threshold)
    {
        let open = closure
            .iter()
            .filter(|s| !(s.q > gear.closure_threshold))
            .count();
        problems.push(format!(
            "no form closure in {open} of {} samples, worst Q = {:.3} at φ = {:.1}°",
            closure.len(),
            worst.q,
            worst.phi.to_degrees()
        ));
    }
    if !(outcome.residual <= RESIDUAL_LIMIT) {
        problems.push(format!(
            "conjugation residual of {:.1e} mm/rad, at most {RESIDUAL_LIMIT:.0e} wanted",
            outcome.residual
        ));
    }
    match &outcome.proof {
        Some(proof) => problems.extend(proof.problems()),
        None => problems.push("stopped before the proof on the meshes: not known to work".into()),
    }
    problems
}
