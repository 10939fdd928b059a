//! From a motion to K compatible sub-gear pairs: random candidates, the best compatible choice of K,
//! joint polish; K from N+1 upwards until the hold is good.

pub mod candidates;
pub mod clearance;
mod field;
mod infeasible;
mod mates;
mod near;
mod paper;
pub mod paper_search;
pub mod polish;
mod program;
mod proved;
pub mod select;
pub mod slsqp;
pub mod swept;
mod tooth;

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::motion::Motion;
use crate::settings::{PairCount, Settings};
use crate::sub_gear::{BandLaw, Flaw};
use crate::{Error, Result};
use candidates::{Candidate, Workshop};
use infeasible::{no_band, no_choice, places, worst_tooth};
use polish::{Team, race};
use select::{Choice, Pool};

/// Where the search is.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub stage: &'static str,
    /// Work done in this stage, 0 to 1.
    pub done: f64,
    /// Usable candidate bands so far.
    pub candidates: usize,
    /// Best hold so far: min Q, in classes that slide min Q* (there Q mixes units).
    pub best_q: Option<f64>,
}

impl Progress {
    /// Whether bands are still being searched for; bodies and proof follow.
    pub fn is_search(&self) -> bool {
        [CANDIDATES, SOLVING, COMBINING, POLISH].contains(&self.stage)
    }
}

const CANDIDATES: &str = "candidate bands";
/// The published formulation only.
const SOLVING: &str = "solving bands";
const COMBINING: &str = "combining bands";
const POLISH: &str = "polish";
/// Going on to the next best choice after the proof refused one.
pub(crate) const FALLBACK: &str = "next best choice";

/// Drafts of changed motions and gears, after the search found nothing.
pub(crate) const REMEDIES: &str = "what would be feasible";

/// Told about progress; `Break` stops the search, which then returns the best it has.
pub type Observer<'a> = dyn FnMut(&Progress) -> ControlFlow<()> + 'a;

/// Tells the observer, and remembers whether it asked to stop.
struct Teller<'a, 'b> {
    observer: &'a mut Observer<'b>,
    stop: StopReason,
}

impl<'a, 'b> Teller<'a, 'b> {
    fn new(observer: &'a mut Observer<'b>) -> Teller<'a, 'b> {
        Teller {
            observer,
            stop: StopReason::Finished,
        }
    }

    fn tell(&mut self, progress: &Progress) -> ControlFlow<()> {
        let answer = (self.observer)(progress);
        if answer.is_break() {
            self.stop = StopReason::Stopped;
        }
        answer
    }
}

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
    /// Bands of the best choices and their hold (min Q, in classes that slide min Q*), best first; at
    /// least one.
    pub choices: Vec<(Vec<BandLaw>, f64)>,
    /// Contact ratio of the teeth.
    pub contact_ratio: f64,
    /// Whether the hold is below [`Search::least_hold`](crate::settings::Search::least_hold).
    pub is_weak: bool,
    /// Whether, before the polish, no as many of the candidates hold better; `None` where it was not tried.
    pub is_proved: Option<bool>,
    /// Why it ended.
    pub stop: StopReason,
}

impl Found {
    /// The hold of the best choice.
    pub fn hold(&self) -> f64 {
        self.choices.first().map_or(f64::NEG_INFINITY, |c| c.1)
    }
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
    /// Steps of the polish of each of them, at most.
    rounds: usize,
}

impl Plan {
    fn new(dof: usize, effort: f64) -> Plan {
        let (usable, draws, starts, polished) = match dof {
            1 => (300, 4_000, 48, 4),
            2 => (450, 8_000, 64, 4),
            3 => (900, 16_000, 64, 6),
            _ => (1100, 20_000, 96, 8),
        };
        let scaled = |n: usize| ((n as f64 * effort).round() as usize).max(1);
        Plan {
            usable: scaled(usable),
            draws: scaled(draws),
            starts: scaled(starts),
            polished,
            rounds: scaled(ROUNDS),
        }
    }
}

/// Steps of a polish; most end before.
const ROUNDS: usize = 60;

/// Share of the planned candidates that a first look begins with.
const FIRST_LOOK: usize = 12;

/// Candidates are drawn in multiples of this.
const BATCH: usize = 256;
/// Usable candidates are rare when there is less than one in so many.
const RARE: usize = 20;
/// Then so many usable ones are looked for to each that was found by chance.
const VARIATIONS: usize = 4;
/// Memory for stored candidates, bytes: more of them are not kept.
const ROOM: usize = 1 << 29;
/// Polished choices that are offered to the proof.
const FINALISTS: usize = 4;

/// Searches for K compatible bands that close the follower at every φ. Where there are none at the
/// contact ratio asked for, or only weak ones, teeth of the least contact ratio are tried: they are
/// shorter, so they fold less and leave more room.
///
/// # Errors
/// [`Error::Infeasible`] when no candidate is usable by itself or no K of them go together, naming
/// what most of them failed of; [`Error::Interrupted`] when stopped before there was any choice.
pub fn run(motion: &Motion, settings: &Settings, observer: &mut Observer) -> Result<Found> {
    let Some(shorter) = shorter(settings) else {
        return at_ratio(motion, settings, observer);
    };
    let first = at_ratio(motion, settings, observer);
    match first {
        Err(Error::Infeasible { .. }) => at_ratio(motion, &shorter, observer),
        Ok(found) if found.is_weak && found.stop == StopReason::Finished => {
            let stronger = match at_ratio(motion, &shorter, observer) {
                Ok(other) if other.hold() > GAIN * found.hold() => other,
                // What was found stays what it is, unless the observer wants to be quick.
                Ok(other) => Found {
                    stop: other.stop,
                    ..found
                },
                Err(Error::Interrupted) => Found {
                    stop: StopReason::Stopped,
                    ..found
                },
                Err(Error::Infeasible { .. }) => found,
                Err(error) => return Err(error),
            };
            Ok(stronger)
        }
        other => other,
    }
}

/// `settings` with the least contact ratio, where that is another one.
fn shorter(settings: &Settings) -> Option<Settings> {
    let least = settings.gear.least_contact_ratio;
    (least < settings.gear.contact_ratio).then(|| {
        let mut shorter = settings.clone();
        shorter.gear.contact_ratio = least;
        shorter
    })
}

/// A step that costs something, one more band or a smaller overlap, has to better the hold this much.
const GAIN: f64 = 1.05;

fn at_ratio(motion: &Motion, settings: &Settings, observer: &mut Observer) -> Result<Found> {
    let workshop = Workshop::new(motion, settings);
    let dof = motion.class().dof();
    let plan = Plan::new(dof, settings.search.effort);
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

    // A weak hold is not a working gear: at small Q* the follower jumps out of its teeth, so more
    // candidates are drawn, and more bands tried, beside those that are there and chosen anew.
    let unit = workshop.hold_unit();
    let enough = (settings.search.least_hold * unit).max(settings.gear.closure_threshold);
    let mut drawn = Drawn::default();
    let mut best: Vec<Team> = Vec::new();
    let mut proofs: BTreeMap<usize, bool> = BTreeMap::new();
    for share in LOOKS {
        let wanted = (plan.usable.div_ceil(share), plan.draws.div_ceil(share));
        drawn.more(&workshop, seed, wanted, &mut |done, count| {
            tell(CANDIDATES, done, count, None)
        });
        let candidates = &drawn.usable;
        let usable = candidates.len();
        let pool = Pool::new(&workshop, candidates, &mut |done, _| {
            tell(COMBINING, 0.5 * done, usable, None)
        });
        let mut teams: Vec<Team> = Vec::new();
        for k in counts(settings, dof) {
            let before = teams.first().map_or(f64::NEG_INFINITY, |team| team.q);
            let grown = teams.first().filter(|t| t.bands.len() + 1 == k);
            let grown = grown.and_then(|team| team.grow(&workshop, candidates));
            let mut choices = pool.best(seed, k, plan.starts.div_ceil(share), &mut |done, q| {
                tell(COMBINING, 0.5 + 0.5 * done, usable, q)
            });
            if let Some(first) = choices.first().filter(|_| k <= proved::MOST) {
                let proof = pool.prove(first.clone());
                proofs.insert(k, proof.is_proved);
                if proof.best != *first {
                    choices.insert(0, proof.best);
                }
            }
            let laws = |choice: &Choice| {
                let bands = choice.bands.iter();
                bands.map(|&i| candidates[i].law.clone()).collect()
            };
            let chosen: Vec<&Choice> = distinct(&choices, plan.polished).collect();
            let mut tried: Vec<Team> = chosen
                .par_iter()
                .map(|choice| Team::new(&workshop, laws(choice)))
                .collect();
            tried.extend(grown);
            let stopped = race(&mut tried, &workshop, plan.rounds, &mut |done, q| {
                tell(POLISH, done, usable, Some(q))
            });
            teams.extend(tried);
            teams.sort_by(|a, b| b.q.total_cmp(&a.q));
            // Where no k bands go together, no more of them do; and a closed follower that one more band
            // does not hold better is held as well as can be.
            let Some(team) = teams.first() else { break };
            let helps = before <= 0.0 || team.q > GAIN * before;
            if stopped.is_break() || team.q >= enough || !helps {
                break;
            }
        }
        best.extend(teams);
        best.sort_by(|a, b| b.q.total_cmp(&a.q));
        if best.first().is_some_and(|team| team.q >= enough)
            || tell(CANDIDATES, 1.0, usable, best.first().map(|t| t.q)).is_break()
        {
            break;
        }
    }
    let Some(first) = best.first() else {
        return Err(match teller.stop {
            StopReason::Stopped => Error::Interrupted,
            StopReason::Finished => drawn.refusal(&workshop, (motion, settings)),
        });
    };
    let is_weak = first.q < enough;
    let is_proved = proofs.get(&first.bands.len()).copied();
    let choices = best.into_iter().take(FINALISTS);
    Ok(Found {
        choices: choices.map(|team| (team.bands, team.q)).collect(),
        contact_ratio: settings.gear.contact_ratio,
        is_weak,
        is_proved,
        stop: teller.stop,
    })
}

/// The planned candidates are drawn in two looks, a share of them first and all where that does not
/// give a good hold.
const LOOKS: [usize; 2] = [3, 1];

/// A first look: the best choice of few candidates, as it was found, without polish. Twice as many
/// candidates are tried as long as there is no choice that closes the follower, up to those of [`run`].
///
/// # Errors
/// As [`run`].
pub fn draft(motion: &Motion, settings: &Settings, observer: &mut Observer) -> Result<Found> {
    match (
        draft_at_ratio(motion, settings, observer),
        shorter(settings),
    ) {
        (Err(Error::Infeasible { .. }), Some(shorter)) => {
            draft_at_ratio(motion, &shorter, observer)
        }
        (found, _) => found,
    }
}

fn draft_at_ratio(motion: &Motion, settings: &Settings, observer: &mut Observer) -> Result<Found> {
    let workshop = Workshop::new(motion, settings);
    let dof = motion.class().dof();
    let whole = Plan::new(dof, settings.search.effort);
    let seed = settings.search.seed;
    let mut teller = Teller::new(observer);
    let mut drawn = Drawn::default();
    let mut share = FIRST_LOOK;
    loop {
        let wanted = (whole.usable.div_ceil(share), whole.draws.div_ceil(share));
        let mut tell = |stage: &'static str, done: f64, candidates: usize| {
            teller.tell(&Progress {
                stage,
                done,
                candidates,
                best_q: None,
            })
        };
        drawn.more(&workshop, seed, wanted, &mut |done, count| {
            tell(CANDIDATES, done, count)
        });
        let usable = drawn.usable.len();
        let pool = Pool::new(&workshop, &drawn.usable, &mut |done, _| {
            tell(COMBINING, 0.5 * done, usable)
        });
        for k in counts(settings, dof) {
            let choices = pool.best(seed, k, whole.starts.div_ceil(share), &mut |done, _| {
                tell(COMBINING, 0.5 + 0.5 * done, usable)
            });
            if let Some(best) = choices.first()
                && best.q > settings.gear.closure_threshold
            {
                let bands = best.bands.iter();
                let bands = bands.map(|&i| drawn.usable[i].law.clone()).collect();
                let choices = vec![(bands, best.q)];
                return Ok(Found {
                    choices,
                    contact_ratio: settings.gear.contact_ratio,
                    is_weak: best.q < settings.search.least_hold * workshop.hold_unit(),
                    is_proved: None,
                    stop: teller.stop,
                });
            }
        }
        match (teller.stop, share) {
            (StopReason::Stopped, _) => return Err(Error::Interrupted),
            (_, 1) => return Err(drawn.refusal(&workshop, (motion, settings))),
            _ => share = share.div_ceil(2),
        }
    }
}

/// Numbers of bands to try, fewest first.
fn counts(settings: &Settings, dof: usize) -> std::ops::RangeInclusive<usize> {
    match settings.gear.sub_gear_pairs {
        PairCount::Fixed(k) => k..=k,
        PairCount::Auto(_) => dof + 1..=dof + MORE,
    }
}

/// Candidates as they are drawn.
#[derive(Default)]
struct Drawn {
    /// Usable by themselves.
    usable: Vec<Candidate>,
    /// Those of them that are no variations.
    parents: Vec<BandLaw>,
    /// What the others failed of.
    flaws: BTreeMap<Flaw, usize>,
    /// How many were drawn.
    count: usize,
    /// Memory of the usable ones, bytes.
    bytes: usize,
}

impl Drawn {
    /// Why there is no choice: no band is usable by itself, or too few go together.
    fn refusal(&self, workshop: &Workshop, (motion, settings): (&Motion, &Settings)) -> Error {
        let tooth = worst_tooth(workshop, settings);
        match self.usable.len() {
            0 => no_band((motion, settings), (&self.flaws, self.count), &tooth),
            usable => {
                let places = places(motion, &self.usable);
                no_choice((motion, settings), (usable, &places), &tooth)
            }
        }
    }

    /// Draws on until there are as many as planned, most were drawn, memory is full or `tell` breaks.
    fn more(
        &mut self,
        workshop: &Workshop,
        seed: u64,
        (wanted, most): (usize, usize),
        tell: &mut dyn FnMut(f64, usize) -> ControlFlow<()>,
    ) {
        let look = workshop.draws_between_looks();
        // Whole batches of draws, however many there are between two looks.
        let most = most.next_multiple_of(BATCH);
        let full = |drawn: &Drawn| drawn.usable.len() >= wanted || drawn.bytes >= ROOM;
        while !full(self) && self.count < most {
            // Where few are usable, more are looked for beside those that are.
            let rare = self.usable.len() * RARE < self.count;
            let varies = rare && self.usable.len() < VARIATIONS * self.parents.len();
            let parents = if varies { &self.parents[..] } else { &[] };
            let (usable, failed) = workshop.sample(seed, (self.count, look), parents);
            self.count += look;
            for candidate in usable {
                if !full(self) {
                    if !varies {
                        self.parents.push(candidate.law.clone());
                    }
                    self.bytes += candidate.swept.bytes();
                    self.usable.push(candidate);
                }
            }
            for (flaw, count) in failed {
                *self.flaws.entry(flaw).or_insert(0) += count;
            }
            let found = self.usable.len() as f64 / wanted as f64;
            let done = found.max(self.count as f64 / most as f64).min(1.0);
            if tell(done, self.usable.len()).is_break() {
                return;
            }
        }
    }
}

/// Most bands above N tried while the hold is weak or there is none.
const MORE: usize = 4;

/// The best `count` choices that differ from each other in at least half of their bands.
fn distinct(choices: &[Choice], count: usize) -> impl Iterator<Item = &Choice> {
    let mut kept: Vec<&Choice> = Vec::new();
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
