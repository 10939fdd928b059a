//! Joint polish of K chosen bands: a sequence of linear programs moves all design variables of all
//! bands together. A step counts only when what was newly traced and measured is better, so that the
//! result is never worse than its start.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use rayon::prelude::*;

use super::candidates::{Candidate, Workshop};
use super::near::Place;
use super::program::{Program, Row, Step, Stop};
use super::select::min_q;
use super::tooth::{self, Bounds, Tooth, VARIABLES};
use crate::closure::{Wrench, facets};
use crate::sub_gear::{BandLaw, OWN, SKETCH};

/// Chosen bands and their min Q.
#[derive(Debug, Clone)]
pub struct Team {
    /// Laws of the best K bands so far.
    pub bands: Vec<BandLaw>,
    /// Their smallest Q over the workshop's phases.
    pub q: f64,
    /// What each band has to keep: the room of the tallest at the start, and flanks that can be made flat.
    bounds: Vec<Bounds>,
    /// Where the steps have led, and how far the next may go.
    here: Option<State>,
    step: f64,
}

/// Bands as they were traced.
#[derive(Debug, Clone)]
struct State {
    bands: Vec<BandLaw>,
    teeth: Vec<Vec<Tooth>>,
    q: f64,
    /// Worst violation of a limit.
    violation: f64,
}

/// Largest step, in natural sizes; steps below the least are not worth their time.
const LARGEST: f64 = 1.0;
const LEAST: f64 = 0.01;

/// Growth of the hold, as a share of it, that a step of one natural size has to promise.
const WORTH: f64 = 0.02;

/// Violation of a limit that does not count, mm: below what the sampling of phases and stations leaves
/// unknown.
const TOLERANCE: f64 = 0.01;

/// Hold, as a share of the unit, that a violation of 1 mm is worth.
const PRICE: f64 = 4.0;

impl Team {
    /// Starts from compatible bands.
    pub fn new(workshop: &Workshop, bands: Vec<BandLaw>) -> Team {
        let bounds = bands.iter().map(|law| Bounds::of(workshop, law));
        let mut bounds: Vec<Bounds> = bounds.collect();
        let height = bounds.iter().map(|b| b.height).fold(0.0, f64::max);
        bounds.iter_mut().for_each(|b| b.height = height);
        let here = State::new(workshop, bands.clone(), &bounds);
        let here = here.map(|s| s.measured(workshop));
        Team {
            q: here.as_ref().map_or(f64::NEG_INFINITY, |s| s.q),
            bands,
            bounds,
            here,
            step: 0.3,
        }
    }

    /// Whether no step promises anything.
    pub fn is_done(&self) -> bool {
        self.here.is_none() || self.step < LEAST
    }

    /// One step, or none where nothing better is found or it is told to `stop`.
    pub(super) fn improve(&mut self, workshop: &Workshop, stop: &Stop) {
        let Some(here) = &self.here else { return };
        let price = PRICE * workshop.hold_unit();
        let merit = |q: f64, violation: f64| q - price * (violation - TOLERANCE).max(0.0);
        let Some(program) = here.program(workshop, (&self.bounds, self.step)) else {
            self.here = None;
            return;
        };
        let now = merit(here.q, here.violation);
        while self.step >= LEAST && !stop.load(Relaxed) {
            let Some(step) = program.solve((self.step, price), stop) else {
                self.step *= 0.25;
                continue;
            };
            let promised = merit(step.hold, step.violation) - now;
            let worth = WORTH * self.step * (here.q.abs() + 0.01 * workshop.hold_unit());
            if promised < worth {
                self.step = 0.0;
                return;
            }
            let next = here.after(workshop, &step, &self.bounds);
            let gained = next.as_ref().map_or(f64::NEG_INFINITY, |next| {
                merit(next.q, next.violation) - now
            });
            let Some(next) = next.filter(|_| gained > 0.1 * promised) else {
                self.step *= 0.4;
                continue;
            };
            if gained > 0.6 * promised {
                self.step = (2.0 * self.step).min(LARGEST);
            }
            if next.violation <= TOLERANCE && next.q > self.q {
                self.q = next.q;
                self.bands = next.bands.clone();
            }
            self.here = Some(next);
            return;
        }
    }

    /// This team and the one of `candidates` that goes with all of its bands and adds most to Q; `None`
    /// when none fits.
    pub fn grow(&self, workshop: &Workshop, candidates: &[Candidate]) -> Option<Team> {
        let own: Vec<Vec<Wrench>> = self
            .bands
            .iter()
            .map(|law| Some(workshop.wrenches(&workshop.trace(law.clone()).ok()?)))
            .collect::<Option<_>>()?;
        let q = |i: usize| {
            let team = own.iter().map(Vec::as_slice);
            team_q(workshop, team.chain([candidates[i].wrenches.as_slice()]))
        };
        let mut order: Vec<(f64, usize)> = (0..candidates.len())
            .into_par_iter()
            .map(|i| (q(i), i))
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        order.truncate(GROWTH);
        let team = |&(_, i): &(f64, usize)| {
            let bands = self.bands.iter().chain([&candidates[i].law]);
            Team::new(workshop, bands.cloned().collect())
        };
        let fits = |team: &Team| {
            let here = team.here.as_ref();
            here.is_some_and(|s| s.violation <= workshop.scene.gap())
        };
        order.par_iter().map(team).find_first(fits)
    }
}

impl State {
    /// Traces `bands` and takes their hold; what they violate is not known yet. `None` where one
    /// degenerates.
    fn new(workshop: &Workshop, bands: Vec<BandLaw>, bounds: &[Bounds]) -> Option<State> {
        let teeth = bands
            .par_iter()
            .zip(bounds)
            .map(|(law, &bounds)| tooth::teeth(workshop, law, bounds))
            .collect::<Option<Vec<_>>>()?;
        let wrenches: Vec<Vec<Wrench>> = teeth
            .iter()
            .map(|band| {
                band.iter()
                    .flat_map(|t| t.wrenches.iter().copied())
                    .collect()
            })
            .collect();
        let q = team_q(workshop, wrenches.iter().map(Vec::as_slice));
        Some(State {
            bands,
            teeth,
            q,
            violation: f64::NAN,
        })
    }

    /// With the worst violation.
    fn measured(mut self, workshop: &Workshop) -> State {
        let slacks = self.teeth.iter().flatten().flat_map(|t| &t.slacks);
        let own = slacks.copied().fold(0.0, f64::min);
        let places = workshop.places(&self.teeth, 0.0);
        let least = places.iter().map(|p| p.slack).fold(own, f64::min);
        self.violation = -least;
        self
    }

    /// The state that `step` leads to.
    fn after(&self, workshop: &Workshop, step: &Step, bounds: &[Bounds]) -> Option<State> {
        let count = self.variables();
        let bands = self.bands.iter().zip(step.moves.chunks(count));
        let bands = bands.map(|(law, moves)| tooth::moved(workshop, law, moves));
        let state = State::new(workshop, bands.collect(), bounds)?;
        Some(state.measured(workshop))
    }

    /// Design variables of a band.
    fn variables(&self) -> usize {
        SKETCH + OWN * self.teeth[0].len()
    }

    /// Where a variable of tooth `j` of band `b` stands in the program.
    fn column(&self, b: usize, j: usize, v: usize) -> usize {
        let own = if v < SKETCH { 0 } else { OWN * j };
        b * self.variables() + own + v
    }

    /// Everything that a step of up to `step` natural sizes has to heed.
    fn program(&self, workshop: &Workshop, (bounds, step): (&[Bounds], f64)) -> Option<Program> {
        let teeth: Vec<(usize, usize)> = (0..self.bands.len())
            .flat_map(|b| (0..self.teeth[b].len()).map(move |j| (b, j)))
            .collect();
        let flat: Option<Vec<Vec<Tooth>>> = teeth
            .par_iter()
            .map(|&(b, j)| self.teeth[b][j].slopes(workshop, j, &self.bands[b], bounds[b]))
            .collect();
        let flat = flat?;
        let slopes: Vec<&[Vec<Tooth>]> = flat.chunks(self.teeth[0].len()).collect();
        let mut limits: Vec<Row> = Vec::new();
        for &(b, j) in &teeth {
            for (i, &value) in self.teeth[b][j].slacks.iter().enumerate() {
                let slope =
                    (0..VARIABLES).map(|v| (self.column(b, j, v), slopes[b][j][v].slacks[i]));
                limits.push(Row {
                    value,
                    slope: slope.collect(),
                });
            }
        }
        let window = WINDOW * step * workshop.scale();
        let places = workshop.places(&self.teeth, window);
        limits.extend(places.iter().map(|place| self.row(place, &slopes)));
        Some(Program {
            variables: self.bands.len() * self.variables(),
            holds: self.holds(workshop, &slopes),
            limits,
        })
    }

    fn row(&self, place: &Place, slopes: &[&[Vec<Tooth>]]) -> Row {
        let mut slope: Vec<(usize, f64)> = Vec::with_capacity(2 * VARIABLES);
        for spot in &place.spots {
            for (v, by) in slopes[spot.band][spot.tooth].iter().enumerate() {
                let column = self.column(spot.band, spot.tooth, v);
                let change = spot.change(by);
                match slope.iter_mut().find(|s| s.0 == column) {
                    Some(entry) => entry.1 += change,
                    None => slope.push((column, change)),
                }
            }
        }
        Row {
            value: place.slack,
            slope,
        }
    }

    /// Facets at all phases.
    fn holds(&self, workshop: &Workshop, slopes: &[&[Vec<Tooth>]]) -> Vec<Row> {
        let dof = workshop.class.dof();
        let mut rows = Vec::new();
        for j in 0..self.teeth[0].len() {
            for i in 0..self.teeth[0][j].wrenches.len() {
                let wrenches: Vec<Wrench> = self.teeth.iter().map(|t| t[j].wrenches[i]).collect();
                for facet in facets(&wrenches, dof) {
                    let slope = facet.weights.iter().flat_map(|&(b, weight)| {
                        let tooth = &slopes[b][j];
                        (0..VARIABLES).map(move |v| {
                            let by = &tooth[v].wrenches[i];
                            let along: f64 = facet.normal.iter().zip(by).map(|(n, w)| n * w).sum();
                            (self.column(b, j, v), weight * along)
                        })
                    });
                    rows.push(Row {
                        value: facet.distance,
                        slope: slope.collect(),
                    });
                }
            }
        }
        rows
    }
}

/// Polishes the teams side by side, `rounds` steps each at most; `Break` when `tell` breaks, which is asked
/// all the time.
pub(super) fn race(
    teams: &mut [Team],
    workshop: &Workshop,
    rounds: usize,
    tell: &mut dyn FnMut(f64, f64) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut racing: Vec<usize> = (0..teams.len()).collect();
    for round in 0..rounds {
        let q = teams.iter().map(|t| t.q).fold(f64::NEG_INFINITY, f64::max);
        let done = round as f64 / rounds as f64;
        tell(done, q)?;
        // Most of what there is to gain comes in the first rounds.
        if HEATS.contains(&round) {
            racing.sort_by(|&a, &b| teams[b].q.total_cmp(&teams[a].q));
            racing.truncate(racing.len().div_ceil(2).max(FINISHERS));
        }
        let on = |(i, team): &(usize, &mut Team)| racing.contains(i) && !team.is_done();
        let mut on: Vec<&mut Team> = teams
            .iter_mut()
            .enumerate()
            .filter(on)
            .map(|t| t.1)
            .collect();
        if on.is_empty() {
            break;
        }
        let stop = Stop::default();
        std::thread::scope(|scope| {
            let (done_with_it, ended) = mpsc::channel::<()>();
            let work = || {
                on.par_iter_mut()
                    .for_each(|team| team.improve(workshop, &stop));
                drop(done_with_it);
            };
            scope.spawn(work);
            // Nothing is ever sent: the channel closes when the work ends.
            while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(LOOK) {
                if tell(done, q).is_break() {
                    stop.store(true, Relaxed);
                }
            }
        });
    }
    ControlFlow::Continue(())
}

/// Rounds before which the lesser half of the teams drops out.
const HEATS: [usize; 2] = [3, 8];

/// So many are polished to the end: now and then the proof refuses one.
const FINISHERS: usize = 3;

/// How often the observer is asked whether to go on.
const LOOK: Duration = Duration::from_millis(20);

/// Candidates tried as one more band, those that add most to Q first.
const GROWTH: usize = 200;

/// Gaps that a step of one natural size may use up, mm at L = 25.
const WINDOW: f64 = 1.5;

fn team_q<'a>(workshop: &Workshop, team: impl Iterator<Item = &'a [Wrench]>) -> f64 {
    let team: Vec<&[Wrench]> = team.collect();
    let phases: Vec<usize> = (0..team.first().map_or(0, |w| w.len())).collect();
    min_q(&team, &phases, workshop.class.dof(), f64::NEG_INFINITY)
}
