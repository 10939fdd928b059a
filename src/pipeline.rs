//! The main job: motion file → search → solids → proof, falling back to the next best choice of bands
//! when the meshes refuse the best.

use std::collections::VecDeque;
use std::ops::ControlFlow;

use crate::design::Design;
use crate::flare;
use crate::motion::{Motion, MotionFile};
use crate::ranking;
use crate::search::{self, Progress, StopReason, paper_search};
use crate::settings::Method;
use crate::solid::Solids;
use crate::synthesis::{self, Bands, Flanks};
use crate::verify::{self, Check, CheckInput, Effort, Printer};
use crate::{Error, Result};

/// A finished job: the design with everything that was made from it and found out about it.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The design; its `problems` are empty when it works.
    pub design: Design,
    /// Bodies and print pieces; `None` when the run was stopped before, or when they cannot be built.
    pub solids: Option<Solids>,
    /// Every claim tried on the meshes; `None` when the run was stopped before.
    pub check: Option<Check>,
    /// Largest |n·v_rel|, |n·T²|, mm/rad.
    pub residual: f64,
    /// What a user should know that is no problem.
    pub remarks: Vec<String>,
    /// Whether no choice of the bands that were looked at holds better before the polish; `None` where it
    /// was not tried.
    pub is_proved: Option<bool>,
    /// Whether the run was cut short.
    pub stop: StopReason,
}

impl Outcome {
    /// What there is before the bodies are built.
    fn new(design: Design, motion: &Motion, stop: StopReason) -> Outcome {
        let mut outcome = Outcome {
            residual: synthesis::conjugation_residual(&design, motion),
            design,
            solids: None,
            check: None,
            remarks: Vec::new(),
            is_proved: None,
            stop,
        };
        outcome.design.problems = vec![UNBUILT.into()];
        outcome
    }

    /// Builds the bodies; what keeps them from being built is a problem of the design.
    fn build(&mut self, motion: &Motion) {
        let problem = match Solids::build(&self.design, motion) {
            Ok(solids) => {
                self.solids = Some(solids);
                UNPROVEN.into()
            }
            Err(error) => error.to_string(),
        };
        self.design.problems = vec![problem];
    }

    /// Tries every claim on the bodies, unless `tell` breaks; a proof that fails is a problem as well.
    fn prove(&mut self, motion: &Motion, tell: &mut verify::Progress) {
        let Some(solids) = &self.solids else { return };
        match prove(&self.design, motion, solids, tell) {
            Ok(check) => {
                self.design.problems = check.problems();
                self.remarks.extend(overloaded(&self.design, &check));
                self.check = Some(check);
            }
            Err(Error::Interrupted) => self.stop = StopReason::Stopped,
            Err(error) => self.design.problems = vec![error.to_string()],
        }
    }

    /// How much of their flare the ribs may keep, of which they had the share `flared`, where the bodies fail:
    /// half where walls are too thin, as between ribs that merge, none where bodies meet or cannot be built.
    fn less_flared(&self, flared: f64) -> Option<f64> {
        if flared == 0.0 || !flare::is_flared(&self.design) {
            return None;
        }
        let Some(check) = &self.check else {
            return self.solids.is_none().then_some(0.0);
        };
        let fails = |what: &str| {
            check
                .claims
                .iter()
                .any(|c| !c.holds && c.name.contains(what))
        };
        match (fails("walls of"), fails("stay apart")) {
            (_, true) => Some(0.0),
            (true, false) if flared == 1.0 => Some(0.5),
            (true, false) => Some(0.0),
            (false, false) => None,
        }
    }

    /// Smaller is better: whether there are no bodies, then the number of problems.
    fn rank(&self) -> (bool, usize) {
        (self.solids.is_none(), self.design.problems.len())
    }
}

/// What to say where the mechanism carries less than what its `[load]` puts on it.
fn overloaded(design: &Design, check: &Check) -> Option<String> {
    let mass = design.settings.load.mass_g;
    let payload = check.claims.iter().find(|c| c.name == verify::PAYLOAD)?;
    let carried = payload.value?;
    (carried < mass)
        .then(|| format!("overloaded: it carries {carried:.0} g, load.mass_g is {mass} g"))
}

const UNBUILT: &str = "stopped before the bodies were built: not known to work";
const DRAFT: &str = "a first look: neither polished nor proved, not known to work";
const UNPROVEN: &str = "stopped before the proof on the meshes: not known to work";

/// What a run tells while it works.
#[derive(Debug)]
pub enum Event<'a> {
    /// Where it is.
    Progress(&'a Progress),
    /// What it would return if it were stopped now.
    Best(&'a Outcome),
}

/// Told what happens; `Break` in answer to progress stops the search, which then hands over the best
/// that it has, or the proof.
pub type Observer<'a> = dyn FnMut(Event) -> ControlFlow<()> + 'a;

/// Designs the mechanism of `file`. When no choice of bands passes the proof, the one with the fewest
/// problems is returned with them.
///
/// # Errors
/// As [`search::run`]; [`Error::Infeasible`] when no choice leaves room for the joint;
/// [`Error::Internal`] when no choice can be traced.
pub fn run(file: &MotionFile, motion: &Motion, observer: &mut Observer) -> Result<Outcome> {
    let found = choices(file, motion, &mut |progress| {
        observer(Event::Progress(progress))
    })?;
    finish((file, motion), found, observer)
}

/// The mechanism of the best of the choices that were `found`, as [`run`].
pub(crate) fn finish(
    (file, motion): (&MotionFile, &Motion),
    found: Choices,
    observer: &mut Observer,
) -> Result<Outcome> {
    let Choices {
        bands: choices,
        contact_ratio,
        is_proved,
        stop,
    } = found;
    let (file, remark) = &at_ratio(file, contact_ratio);
    let mut choices = ranking::by_payload(file, motion, choices);
    let count = choices.len();
    let mut best: Option<Outcome> = None;
    let mut failure = None;
    let mut is_flat = true;
    // Flanks as flat as contact allows, then round ones between straight ribs, of each choice.
    let attempts = (0..count).flat_map(|i| [(i, Flanks::Flat, 1.0), (i, Flanks::Round, 0.0)]);
    let mut attempts: VecDeque<_> = attempts.collect();
    while let Some((i, flanks, flared)) = attempts.pop_front() {
        let (q, flat) = (choices[i].hold, choices[i].flat.take());
        if flanks == Flanks::Round && !is_flat {
            continue;
        }
        let at = |stage: &'static str, done: f64| Progress {
            stage,
            done: (i as f64 + done) / count as f64,
            candidates: 0,
            best_q: Some(q),
        };
        // Choices come best first: one draft of bands that do not close the follower is enough.
        if best.is_some() && q <= 0.0 {
            break;
        }
        // Once the search was told to stop, there is only the best choice to be finished.
        if let Some(best) = &mut best
            && (stop == StopReason::Stopped
                || observer(Event::Progress(&at(search::FALLBACK, 0.0))).is_break())
        {
            best.stop = StopReason::Stopped;
            break;
        }
        let made = match flat {
            Some(design) => Ok(design),
            None => synthesis::design(file, motion, &choices[i].bands, flanks),
        };
        let made = made.and_then(|design| flare::flared(design, motion, flared));
        let mut outcome = match made {
            Ok(design) => Outcome {
                remarks: remark.clone(),
                is_proved,
                ..Outcome::new(design, motion, stop)
            },
            Err(error) => {
                failure = Some(error);
                continue;
            }
        };
        let mut pairs = outcome.design.sub_gear_pairs.iter();
        is_flat = pairs.any(|pair| pair.flank_radius.is_some());
        let first = best.is_none();
        if first {
            let _ = observer(Event::Best(&outcome));
        }
        // After an interrupt the best choice is still built, but not proven.
        let stopped = observer(Event::Progress(&at("solids", 0.0))).is_break();
        outcome.build(motion);
        if first {
            let _ = observer(Event::Best(&outcome));
        }
        match stopped {
            true => outcome.stop = StopReason::Stopped,
            false => outcome.prove(motion, &mut |what, done| {
                observer(Event::Progress(&at(what, 0.1 + 0.9 * done)))
            }),
        }
        let (works, stop) = (outcome.design.problems.is_empty(), outcome.stop);
        let less = outcome.less_flared(flared);
        if best.as_ref().is_none_or(|b| outcome.rank() < b.rank()) {
            best = Some(outcome);
        }
        if let Some(best) = &mut best {
            best.stop = stop;
        }
        if works || stopped {
            break;
        }
        if let Some(less) = less {
            attempts.push_front((i, flanks, less));
        }
        if let Some(best) = &best
            && !first
        {
            let _ = observer(Event::Best(best));
        }
    }
    best.ok_or_else(|| failure.unwrap_or(Error::Interrupted))
}

/// A first look at the mechanism of `file`: teeth and bodies of a choice that was neither polished nor
/// proved; its only problem says so.
///
/// # Errors
/// As [`run`]; [`Error::Interrupted`] when `observer` breaks before there are bands.
pub fn draft(file: &MotionFile, motion: &Motion, observer: &mut Observer) -> Result<Outcome> {
    let found = search::draft(motion, &file.settings, &mut |progress| {
        observer(Event::Progress(progress))
    })?;
    let (file, remarks) = &at_ratio(file, found.contact_ratio);
    let mut failure = Error::Interrupted;
    for (bands, _) in found.choices {
        match synthesis::design(file, motion, &Bands::Exact(bands), Flanks::Flat) {
            Ok(design) => {
                let mut outcome = Outcome {
                    remarks: remarks.clone(),
                    ..Outcome::new(design, motion, found.stop)
                };
                let _ = observer(Event::Best(&outcome));
                outcome.build(motion);
                if outcome.solids.is_some() {
                    outcome.design.problems = vec![DRAFT.into()];
                }
                return Ok(outcome);
            }
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// `file` with the contact ratio that was found, and what to say about it where it is not the one asked
/// for.
fn at_ratio(file: &MotionFile, contact_ratio: f64) -> (MotionFile, Vec<String>) {
    let mut found = file.clone();
    let asked = std::mem::replace(&mut found.settings.gear.contact_ratio, contact_ratio);
    let remarks = (asked != contact_ratio).then(|| {
        format!(
            "contact ratio {contact_ratio}: at {asked} no gear was found, or only one that holds less"
        )
    });
    (found, remarks.into_iter().collect())
}

/// What the search hands over.
#[derive(Debug, Clone)]
pub(crate) struct Choices {
    /// Choices of bands, best first, with their hold.
    pub bands: Vec<(Bands, f64)>,
    /// Contact ratio of their teeth.
    pub contact_ratio: f64,
    /// As in [`Outcome`].
    pub is_proved: Option<bool>,
    /// Whether the search was cut short.
    pub stop: StopReason,
}

/// Searches by the method that the settings ask for.
///
/// # Errors
/// As [`search::run`].
pub(crate) fn choices(
    file: &MotionFile,
    motion: &Motion,
    observer: &mut search::Observer,
) -> Result<Choices> {
    let settings = &file.settings;
    Ok(match settings.search.method {
        Method::Exact => {
            let found = search::run(motion, settings, observer)?;
            let choices = found.choices.into_iter();
            Choices {
                bands: choices.map(|(b, q)| (Bands::Exact(b), q)).collect(),
                contact_ratio: found.contact_ratio,
                is_proved: found.is_proved,
                stop: found.stop,
            }
        }
        Method::Paper => {
            let found = paper_search::run(motion, settings, observer)?;
            let choices = found.choices.into_iter();
            Choices {
                bands: choices.map(|(b, q)| (Bands::Paper(b), q)).collect(),
                contact_ratio: settings.gear.contact_ratio,
                is_proved: None,
                stop: found.stop,
            }
        }
    })
}

fn prove(
    design: &Design,
    motion: &Motion,
    solids: &Solids,
    tell: &mut verify::Progress,
) -> Result<Check> {
    let pieces = solids.pieces.iter();
    let pieces: Vec<_> = pieces.map(|p| (p.name.clone(), p.mesh.clone())).collect();
    let input = CheckInput {
        design,
        motion,
        bodies: &solids.bodies,
        pieces: &pieces,
        printer: Printer::of(&design.settings.fit),
        effort: Effort::default(),
    };
    verify::check(&input, tell)
}
