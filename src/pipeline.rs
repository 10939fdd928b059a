//! The main job: motion file → search → solids → proof, falling back to the next best choice of bands
//! when the meshes refuse the best.

use std::ops::ControlFlow;

use crate::design::Design;
use crate::motion::{Motion, MotionFile};
use crate::search::{self, Progress, StopReason, paper_search};
use crate::settings::Method;
use crate::solid::Solids;
use crate::synthesis::{self, Bands};
use crate::verify::{self, Check, CheckInput, Effort, Printer};
use crate::{Error, Result};

/// A finished job: the design with everything that was made from it and found out about it.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The design; its `problems` are empty when it works.
    pub design: Design,
    /// Bodies and print pieces.
    pub solids: Solids,
    /// Every claim tried on the meshes; `None` when the run was stopped before.
    pub check: Option<Check>,
    /// Largest |n·v_rel|, |n·T²|, mm/rad.
    pub residual: f64,
    /// Whether the search was cut short.
    pub stop: StopReason,
}

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
        // Choices come best first: one draft of bands that do not close the follower is enough.
        if best.is_some() && *q <= 0.0 {
            break;
        }
        // Once the search was told to stop, there is only the best choice to be finished.
        if let Some(best) = &mut best
            && (stop == StopReason::Stopped || tell(search::FALLBACK, 0.0).is_break())
        {
            best.stop = StopReason::Stopped;
            break;
        }
        // After an interrupt the best choice is still built, but not proven.
        let stopped = tell("solids", 0.0).is_break();
        let design = synthesis::design(file, motion, bands);
        let built = design.and_then(|design| Ok((Solids::build(&design, motion)?, design)));
        let (solids, design) = match built {
            Ok(built) => built,
            Err(error) => {
                failure = Some(error);
                continue;
            }
        };
        let mut outcome = Outcome {
            residual: synthesis::conjugation_residual(&design, motion),
            design,
            solids,
            check: None,
            stop: if stopped { StopReason::Stopped } else { stop },
        };
        if !stopped {
            match prove(&outcome, motion, &mut |done| {
                tell("proof on the meshes", 0.1 + 0.9 * done)
            }) {
                Ok(check) => outcome.check = Some(check),
                Err(Error::Interrupted) => outcome.stop = StopReason::Stopped,
                Err(error) => return Err(error),
            }
        }
        outcome.design.problems = problems(&outcome);
        let fewer = best
            .as_ref()
            .is_none_or(|b| outcome.design.problems.len() < b.design.problems.len());
        let done = outcome.design.problems.is_empty() || outcome.check.is_none();
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
) -> Result<Check> {
    let pieces = outcome.solids.pieces.iter();
    let pieces: Vec<_> = pieces.map(|p| (p.name.clone(), p.mesh.clone())).collect();
    let input = CheckInput {
        design: &outcome.design,
        motion,
        bodies: &outcome.solids.bodies,
        pieces: &pieces,
        printer: Printer::default(),
        effort: Effort::default(),
    };
    verify::check(&input, &mut |_, done| tell(done))
}

/// Everything that keeps the design from working, one sentence each.
fn problems(outcome: &Outcome) -> Vec<String> {
    match &outcome.check {
        Some(check) => check.problems(),
        None => vec!["stopped before the proof on the meshes: not known to work".into()],
    }
}
