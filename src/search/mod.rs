//! From a motion to K compatible sub-gear pairs: random candidates, the best compatible choice of K,
//! joint polish; K from N+1 upwards.

pub mod candidates;
pub mod clearance;
mod paper;
pub mod paper_search;
pub mod polish;
pub mod select;
pub mod slsqp;
pub mod swept;

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use crate::motion::Motion;
use crate::settings::{PairCount, Settings};
use crate::sub_gear::{BandLaw, Flaw};
use crate::{Error, Result};
use candidates::{Candidate, Workshop};
use polish::Team;
use select::Pool;

/// Where the search is.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub stage: &'static str,
    /// Work done in this stage, 0 to 1.
    pub done: f64,
    /// Usable candidate bands so far.
    pub candidates: usize,
    /// Best min Q so far.
    pub best_q: Option<f64>,
}

impl Progress {
    /// Whether bands are still being searched for, or chosen anew after a failed proof; what else
    /// follows (solids, proof) is of bounded length.
    pub fn is_search(&self) -> bool {
        [CANDIDATES, SOLVING, COMBINING, POLISH, FALLBACK].contains(&self.stage)
    }
}

const CANDIDATES: &str = "candidate bands";
/// The published formulation only.
const SOLVING: &str = "solving bands";
const COMBINING: &str = "combining bands";
const POLISH: &str = "polish";
/// Going on to the next best choice after the proof refused one.
pub(crate) const FALLBACK: &str = "next best choice";

/// Told about progress; `Break` stops the search, which then returns the best it has.
pub type Observer<'a> = dyn FnMut(&Progress) -> ControlFlow<()> + 'a;

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// All planned work was done.
    Finished,
    /// The observer asked to stop.
    Stopped,
}

/// Result of a search.
#[derive(Debug, Clone)]
pub struct Found {
    /// Bands of the best choices and their min Q, best first; at least one.
    pub choices: Vec<(Vec<BandLaw>, f64)>,
    /// Why it ended.
    pub stop: StopReason,
}

/// Work planned for a search; grows with the number of contacts that have to find room.
#[derive(Debug, Clone, Copy)]
struct Plan {
    /// Usable candidates wanted.
    usable: usize,
    /// Candidates drawn at most.
    draws: usize,
    /// Starts of the local search over choices.
    starts: usize,
    /// Choices that are polished.
    polished: usize,
    /// Generations of the polish of each of them.
    generations: usize,
}

impl Plan {
    fn new(dof: usize, effort: f64) -> Plan {
        let (usable, draws, starts, (polished, generations)) = match dof {
            1 => (300, 4_000, 48, (4, 100)),
            2 => (450, 8_000, 64, (4, 200)),
            3 => (900, 16_000, 64, (6, 300)),
            _ => (1100, 20_000, 96, (8, 400)),
        };
        let scaled = |n: usize| ((n as f64 * effort).round() as usize).max(1);
        Plan {
            usable: scaled(usable),
            draws: scaled(draws),
            starts: scaled(starts),
            polished,
            generations: scaled(generations),
        }
    }
}

/// Candidates drawn between two looks at the observer.
const BATCH: usize = 256;
/// Polished choices that are offered to the proof.
const FINALISTS: usize = 4;

/// Searches for K compatible bands that close the follower at every φ.
///
/// # Errors
/// [`Error::Infeasible`] when no candidate is usable by itself or no K of them go together, naming
/// what most of them failed of; [`Error::Interrupted`] when stopped before there was any choice.
pub fn run(motion: &Motion, settings: &Settings, observer: &mut Observer) -> Result<Found> {
    let workshop = Workshop::new(motion, settings);
    let dof = motion.class().dof();
    let plan = Plan::new(dof, settings.search.effort);
    let seed = settings.search.seed;

    let mut candidates: Vec<Candidate> = Vec::new();
    let mut flaws: BTreeMap<Flaw, usize> = BTreeMap::new();
    let mut drawn = 0;
    let mut stop = StopReason::Finished;
    while candidates.len() < plan.usable && drawn < plan.draws {
        let (usable, failed) = workshop.sample(seed, drawn, BATCH);
        drawn += BATCH;
        candidates.extend(usable);
        for (flaw, count) in failed {
            *flaws.entry(flaw).or_insert(0) += count;
        }
        let done =
            (candidates.len() as f64 / plan.usable as f64).max(drawn as f64 / plan.draws as f64);
        let progress = Progress {
            stage: CANDIDATES,
            done,
            candidates: candidates.len(),
            best_q: None,
        };
        if observer(&progress).is_break() {
            stop = StopReason::Stopped;
            break;
        }
    }
    candidates.truncate(plan.usable);
    if candidates.is_empty() {
        return Err(if stop == StopReason::Stopped {
            Error::Interrupted
        } else {
            no_band(&flaws, drawn)
        });
    }

    let counts = match settings.gear.sub_gear_pairs {
        PairCount::Fixed(k) => k..=k,
        PairCount::Auto(_) => dof + 1..=dof + MORE,
    };
    let mut best: Vec<Team> = Vec::new();
    for k in counts {
        let progress = Progress {
            stage: COMBINING,
            done: 0.0,
            candidates: candidates.len(),
            best_q: None,
        };
        if observer(&progress).is_break() {
            stop = StopReason::Stopped;
        }
        let starts = if stop == StopReason::Stopped {
            8
        } else {
            plan.starts
        };
        let choices = Pool::new(&workshop, &candidates).best(seed, k, starts);
        let usable = candidates.len();
        let mut report = |done: f64, q: Option<f64>, stage: &'static str| {
            observer(&Progress {
                stage,
                done,
                candidates: usable,
                best_q: q,
            })
            .is_break()
        };
        let mut teams: Vec<Team> = distinct(&choices, plan.polished)
            .map(|c| {
                Team::new(
                    &workshop,
                    c.bands.iter().map(|&i| candidates[i].clone()).collect(),
                )
            })
            .collect();
        let generations = plan.generations;
        let work = (teams.len() * generations) as f64;
        'polish: for i in 0..teams.len() {
            for generation in 0..generations {
                if stop == StopReason::Stopped {
                    break 'polish;
                }
                teams[i].improve(&workshop, seed.wrapping_add(i as u64));
                let q = teams.iter().map(|t| t.q).fold(f64::NEG_INFINITY, f64::max);
                if report(
                    (i * generations + generation) as f64 / work,
                    Some(q),
                    POLISH,
                ) {
                    stop = StopReason::Stopped;
                }
            }
        }
        best.extend(teams);
        best.sort_by(|a, b| b.q.total_cmp(&a.q));
        let closed = best
            .first()
            .is_some_and(|t| t.q > settings.gear.closure_threshold);
        if closed || stop == StopReason::Stopped {
            break;
        }
    }
    if best.is_empty() {
        return Err(if stop == StopReason::Stopped {
            Error::Interrupted
        } else {
            no_choice(&candidates, settings)
        });
    }
    let choices = best
        .into_iter()
        .take(FINALISTS)
        .map(|team| (team.bands.into_iter().map(|b| b.law).collect(), team.q))
        .collect();
    Ok(Found { choices, stop })
}

/// K above N tried before a motion is called infeasible.
const MORE: usize = 3;

/// The best `count` choices that differ from each other in at least half of their bands.
fn distinct(choices: &[select::Choice], count: usize) -> impl Iterator<Item = &select::Choice> {
    let mut kept: Vec<&select::Choice> = Vec::new();
    for choice in choices {
        let new = kept.iter().all(|other| {
            let common = choice
                .bands
                .iter()
                .filter(|b| other.bands.contains(b))
                .count();
            2 * common <= choice.bands.len()
        });
        if new {
            kept.push(choice);
        }
        if kept.len() == count {
            break;
        }
    }
    kept.into_iter()
}

fn no_band(flaws: &BTreeMap<Flaw, usize>, drawn: usize) -> Error {
    let worst = flaws.iter().max_by_key(|(_, count)| **count);
    let (reason, hint) = match worst.map(|(flaw, _)| *flaw) {
        Some(Flaw::Hub | Flaw::Joint) => (
            "the motion range is so large that the follower reaches the driver's hub or the socket",
            "smaller tilt or stroke, larger gear.center_distance_mm, thinner hubs",
        ),
        Some(Flaw::Gap | Flaw::Cusp | Flaw::Fold | Flaw::Degenerate) => (
            "the motion turns too sharply for teeth: their surfaces cross or fold beside the contact",
            "a smoother motion (fewer high-curvature points), more teeth, or a smaller contact ratio",
        ),
        _ => (
            "teeth of every band tried collide with each other",
            "thinner teeth, fewer teeth, or a smaller contact ratio",
        ),
    };
    Error::Infeasible {
        reason: reason.into(),
        place: format!("none of {drawn} candidate bands is usable: {flaws:?}"),
        hint: hint.into(),
    }
}

fn no_choice(candidates: &[Candidate], settings: &Settings) -> Error {
    Error::Infeasible {
        reason: "no set of bands fits side by side on the gears".into(),
        place: format!(
            "{} usable bands, none of which go together as wanted",
            candidates.len()
        ),
        hint: format!(
            "smaller tilt or stroke, thinner teeth (gear.tooth_thickness_mm = {}), or search.effort above {}",
            settings.gear.tooth_thickness_mm, settings.search.effort
        ),
    }
}
