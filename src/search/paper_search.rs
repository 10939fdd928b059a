//! Search with bands of the published formulation, the reference that the exact one is measured against.
//!
//! A band takes seconds instead of milliseconds here, so few are solved. They start where bands of the
//! exact search go well together: from the same heights, travels and turning sides. Everything after
//! that (tests of a band, compatibility, choice of K) is the exact search's.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::candidates::{Candidate, Workshop};
use super::infeasible::{no_band, no_choice};
use super::select::{Choice, Pool, Tell};
use super::slsqp::Limits;
use super::{
    CANDIDATES, COMBINING, Drawn, FINALISTS, Observer, Progress, SOLVING, StopReason, Teller,
    counts,
};
use crate::contact::{BandStart, PaperBand};
use crate::motion::Motion;
use crate::settings::Settings;
use crate::sub_gear::{Band, BandLaw, Flaw};
use crate::{Error, Result};

/// Result of a search.
#[derive(Debug, Clone)]
pub struct Found {
    /// Bands of the best choices and their min Q, best first; at least one.
    pub choices: Vec<(Vec<PaperBand>, f64)>,
    /// Why it ended.
    pub stop: StopReason,
}

/// Bands solved per degree of freedom at effort 1.
const BANDS: f64 = 12.0;
/// Exact bands wanted to choose starts among, and drawn at most, per degree of freedom.
const SKETCHES: usize = 80;
const DRAWS: usize = 4096;
/// Bands solved between two looks at the observer.
const SOLVED: usize = 4;
/// Local searches over choices.
const STARTS: usize = 24;
/// Evaluations of one band at most; it has usually converged before.
const EVALUATIONS: u32 = 400;

/// Searches for K compatible bands of the published formulation. Conjugation is only as good as the
/// penalty made it: the caller measures it.
///
/// # Errors
/// As [`super::run`].
pub fn run(motion: &Motion, settings: &Settings, observer: &mut Observer) -> Result<Found> {
    let workshop = Workshop::new(motion, settings);
    let dof = motion.class().dof();
    let seed = settings.search.seed;
    let mut teller = Teller::new(observer);
    let mut tell = |stage: &'static str, done: f64, candidates: usize, best_q: Option<f64>| {
        teller.tell(&Progress {
            stage,
            done,
            candidates,
            best_q,
        })
    };
    let wanted = (SKETCHES * dof, DRAWS * dof);
    let mut drawn = Drawn::default();
    drawn.more(&workshop, seed, wanted, &mut |done, count| {
        tell(CANDIDATES, done, count, None)
    });
    let sketches = &drawn.usable;
    if sketches.is_empty() {
        return Err(match teller.stop {
            StopReason::Stopped => Error::Interrupted,
            StopReason::Finished => no_band((motion, settings), (&drawn.flaws, drawn.count), ""),
        });
    }
    let starts = starts(&workshop, sketches, settings, &mut |done, q| {
        tell(COMBINING, done, sketches.len(), q)
    });

    let mut flaws: BTreeMap<Flaw, usize> = BTreeMap::new();
    let mut bands: Vec<PaperBand> = Vec::new();
    let mut candidates: Vec<Candidate> = Vec::new();
    for (i, chunk) in starts.chunks(SOLVED).enumerate() {
        let done = (i * SOLVED) as f64 / starts.len() as f64;
        if tell(SOLVING, done, candidates.len(), None).is_break() {
            break;
        }
        let solved: Vec<Result<std::result::Result<_, Flaw>>> = chunk
            .par_iter()
            .map(|law| solve(&workshop, (motion, settings), law))
            .collect();
        for result in solved {
            match result? {
                Ok((band, candidate)) => {
                    bands.push(band);
                    candidates.push(candidate);
                }
                Err(flaw) => *flaws.entry(flaw).or_insert(0) += 1,
            }
        }
    }
    let interrupted = || Err(Error::Interrupted);
    if candidates.is_empty() {
        return match teller.stop {
            StopReason::Stopped => interrupted(),
            StopReason::Finished => Err(no_band((motion, settings), (&flaws, starts.len()), "")),
        };
    }
    let usable = candidates.len();
    let mut combining = |done: f64, best_q: Option<f64>| tell(COMBINING, done, usable, best_q);
    let pool = Pool::new(&workshop, &candidates, &mut combining);
    let mut choices: Vec<Choice> = Vec::new();
    for k in counts(settings, dof) {
        choices.extend(pool.best(seed, k, STARTS, &mut combining));
        choices.sort_by(|a, b| b.q.total_cmp(&a.q));
        let closed = |c: &Choice| c.q > settings.gear.closure_threshold;
        if choices.first().is_some_and(closed) {
            break;
        }
    }
    if choices.is_empty() {
        return match teller.stop {
            StopReason::Stopped => interrupted(),
            StopReason::Finished => Err(no_choice((motion, settings), (usable, ""), "")),
        };
    }
    let of = |c: &Choice| c.bands.iter().map(|&i| bands[i].clone()).collect();
    let choices = choices
        .iter()
        .take(FINALISTS)
        .map(|c| (of(c), c.q))
        .collect();
    Ok(Found {
        choices,
        stop: teller.stop,
    })
}

/// Laws to start from: those of the best compatible choices first.
fn starts(
    workshop: &Workshop,
    sketches: &[Candidate],
    settings: &Settings,
    tell: &mut Tell,
) -> Vec<BandLaw> {
    let dof = workshop.class.dof();
    let wanted = ((BANDS * dof as f64 * settings.search.effort).ceil() as usize).max(dof + 1);
    let choices =
        Pool::new(workshop, sketches, tell).best(settings.search.seed, dof + 1, STARTS, tell);
    let mut order: Vec<usize> = Vec::new();
    for i in choices
        .iter()
        .flat_map(|c| c.bands.iter().copied())
        .chain(0..sketches.len())
    {
        if order.len() < wanted && !order.contains(&i) {
            order.push(i);
        }
    }
    order.into_iter().map(|i| sketches[i].law.clone()).collect()
}

/// Solves one band and runs all tests of a band on it.
fn solve(
    workshop: &Workshop,
    (motion, settings): (&Motion, &Settings),
    law: &BandLaw,
) -> Result<std::result::Result<(PaperBand, Candidate), Flaw>> {
    let sketch = &law.sketch;
    let start = BandStart {
        side: sketch.side,
        z_start: sketch.z - 0.5 * sketch.travel,
        travel: sketch.travel,
        offset: sketch.offset,
    };
    // No limit of time: the result must not depend on the machine.
    let limits = Limits {
        evaluations: EVALUATIONS,
        seconds: 1e6,
        ..Limits::default()
    };
    let band = match PaperBand::solve(motion, settings, &start, &limits) {
        Ok(report) => report.best,
        Err(Error::Infeasible { .. }) => return Ok(Err(Flaw::Degenerate)),
        Err(error) => return Err(error),
    };
    let teeth = band.traces(&workshop.grid);
    let finite = teeth
        .iter()
        .flatten()
        .all(|c| c.p.iter().chain(c.n.iter()).all(|x| x.is_finite()));
    if !finite {
        return Ok(Err(Flaw::Degenerate));
    }
    let tested = Band::of(&workshop.grid, law.clone(), teeth, &workshop.margins)
        .and_then(|tested| workshop.check_spacing(tested))
        .and_then(|tested| workshop.finish(&tested));
    Ok(tested.map(|candidate| (band, candidate)))
}
