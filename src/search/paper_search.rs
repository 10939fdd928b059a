//! Search with bands of the published formulation, the reference that the exact one is measured against.
//!
//! A band takes seconds instead of milliseconds here, so few are solved. They start where bands of the
//! exact search go well together: from the same heights, travels and turning sides. Everything after
//! that (tests of a band, compatibility, choice of K) is the exact search's.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rayon::prelude::*;

use super::candidates::{Candidate, Workshop};
use super::select::{Choice, Pool};
use super::slsqp::Limits;
use super::{
    CANDIDATES, FINALISTS, MORE, Observer, Progress, SOLVING, StopReason, no_band, no_choice,
};
use crate::contact::{BandStart, PaperBand};
use crate::motion::Motion;
use crate::settings::{PairCount, Settings};
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
/// Exact bands drawn between two looks at the observer.
const BATCH: usize = 256;
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
    let counts = match settings.gear.sub_gear_pairs {
        PairCount::Fixed(k) => k..=k,
        PairCount::Auto(_) => dof + 1..=dof + MORE,
    };
    let sketches = sketches(&workshop, (seed, dof), observer)?;
    let starts = starts(&workshop, &sketches, settings);

    let mut flaws: BTreeMap<Flaw, usize> = BTreeMap::new();
    let mut bands: Vec<PaperBand> = Vec::new();
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut stop = StopReason::Finished;
    for (i, chunk) in starts.chunks(SOLVED).enumerate() {
        let progress = Progress {
            stage: SOLVING,
            done: (i * SOLVED) as f64 / starts.len() as f64,
            candidates: candidates.len(),
            best_q: None,
        };
        if observer(&progress).is_break() {
            stop = StopReason::Stopped;
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
    let stopped = || Err(Error::Interrupted);
    if candidates.is_empty() {
        return match stop {
            StopReason::Stopped => stopped(),
            StopReason::Finished => Err(no_band(&flaws, starts.len())),
        };
    }
    let pool = Pool::new(&workshop, &candidates);
    let mut choices: Vec<Choice> = Vec::new();
    for k in counts {
        choices.extend(pool.best(seed, k, STARTS));
        choices.sort_by(|a, b| b.q.total_cmp(&a.q));
        let closed = |c: &Choice| c.q > settings.gear.closure_threshold;
        if choices.first().is_some_and(closed) {
            break;
        }
    }
    if choices.is_empty() {
        return match stop {
            StopReason::Stopped => stopped(),
            StopReason::Finished => Err(no_choice(&candidates, settings)),
        };
    }
    let of = |c: &Choice| c.bands.iter().map(|&i| bands[i].clone()).collect();
    let choices = choices
        .iter()
        .take(FINALISTS)
        .map(|c| (of(c), c.q))
        .collect();
    Ok(Found { choices, stop })
}

/// Usable bands of the exact search, to start from.
fn sketches(
    workshop: &Workshop,
    (seed, dof): (u64, usize),
    observer: &mut Observer,
) -> Result<Vec<Candidate>> {
    let mut usable = Vec::new();
    let mut flaws: BTreeMap<Flaw, usize> = BTreeMap::new();
    let mut drawn = 0;
    while usable.len() < SKETCHES * dof && drawn < DRAWS * dof {
        let progress = Progress {
            stage: CANDIDATES,
            done: usable.len() as f64 / (SKETCHES * dof) as f64,
            candidates: usable.len(),
            best_q: None,
        };
        if let ControlFlow::Break(()) = observer(&progress) {
            return Err(Error::Interrupted);
        }
        let (more, failed) = workshop.sample(seed, drawn, BATCH);
        drawn += BATCH;
        usable.extend(more);
        for (flaw, count) in failed {
            *flaws.entry(flaw).or_insert(0) += count;
        }
    }
    if usable.is_empty() {
        return Err(no_band(&flaws, drawn));
    }
    Ok(usable)
}

/// Laws to start from: those of the best compatible choices first.
fn starts(workshop: &Workshop, sketches: &[Candidate], settings: &Settings) -> Vec<BandLaw> {
    let dof = workshop.class.dof();
    let wanted = ((BANDS * dof as f64 * settings.search.effort).ceil() as usize).max(dof + 1);
    let choices = Pool::new(workshop, sketches).best(settings.search.seed, dof + 1, STARTS);
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
