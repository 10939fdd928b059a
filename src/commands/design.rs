//! `mpcgear design`: the main job.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use mpcgear::design::{Design, file};
use mpcgear::disk::Folder;
use mpcgear::export::tables::{self, SUMMARY, Summary};
use mpcgear::export::{self, Source};
use mpcgear::motion::{Motion, MotionFile};
use mpcgear::pipeline::{self, Event, Outcome};
use mpcgear::remedy::{self, Remedy};
use mpcgear::search::StopReason;
use mpcgear::settings::Method;
use mpcgear::verify::{Check, PAYLOAD};
use mpcgear::{Error, Result};
use mpcgear::{bound, certified};

use super::{json, print_out, say};
use crate::cli::{self, Cli, DesignArgs};
use crate::terminal::Watch;

/// Designs, proves and writes; exit code 0, 3 or 130.
///
/// # Errors
/// Bad input and folders that cannot be written, before anything is computed; motions that cannot be
/// made, after their draft is written; an interrupt before there was a design; defects of ours.
pub fn run(cli: &Cli, args: &DesignArgs) -> Result<u8> {
    let watch = Arc::new(match args.progress {
        true => Watch::for_programs(),
        false => Watch::new(cli.quiet || cli.json),
    });
    let (mut file, motion) = MotionFile::read_changed(&args.file, &args.set)?;
    override_settings(&mut file, args)?;
    watch.limit(file.settings.search.time_limit_s);
    let job = Job {
        cli,
        target: Target::claim(&args.out)?,
        watch,
        remedies: Vec::new(),
    };
    let motion = match motion {
        Ok(motion) => motion,
        Err(error) => return job.give_up(&file, None, error),
    };
    let outcome = work(args.draft, &file, &motion, &job.watch);
    let remedies = match &outcome {
        Ok(outcome) if outcome.check.as_ref().is_none_or(is_only_too_weak) => Vec::new(),
        Ok(_) | Err(Error::Infeasible { .. }) if !args.draft => job.remedies(&file, &motion),
        _ => Vec::new(),
    };
    job.watch.finish();
    let outcome = outcome.map_err(|error| with_remedies(error, &remedies));
    let job = Job { remedies, ..job };
    match outcome {
        Ok(outcome) => job.deliver(args, &motion, &outcome),
        Err(Error::Interrupted) if !job.watch.interrupted() => {
            job.give_up(&file, Some(&motion), out_of_time(&file))
        }
        Err(error) => job.give_up(&file, Some(&motion), error),
    }
}

/// Runs the job on a thread of its own. When a step of it takes no notice of the time limit, it is left
/// behind and the best so far is the answer.
fn work(draft: bool, file: &MotionFile, motion: &Motion, watch: &Arc<Watch>) -> Result<Outcome> {
    let best: Arc<Mutex<Option<Outcome>>> = Arc::default();
    let (done, result) = channel();
    let (file, motion) = (file.clone(), motion.clone());
    let (teller, keeper) = (Arc::clone(watch), Arc::clone(&best));
    let worker = thread::spawn(move || {
        let job = if draft {
            pipeline::draft
        } else {
            pipeline::run
        };
        let outcome = job(&file, &motion, &mut |event| match event {
            Event::Progress(progress) => teller.tell(progress),
            Event::Best(outcome) => {
                let mut best = keeper.lock().unwrap_or_else(PoisonError::into_inner);
                *best = Some(outcome.clone());
                ControlFlow::Continue(())
            }
        });
        // Nobody listens any more to a run that was left behind.
        let _ = done.send(outcome);
    });
    loop {
        match result.recv_timeout(LOOK) {
            Ok(outcome) => return outcome,
            Err(RecvTimeoutError::Timeout) if watch.is_overdue() => {
                let best = best.lock().unwrap_or_else(PoisonError::into_inner).take();
                return best.map_or(Err(Error::Interrupted), |best| {
                    Ok(Outcome {
                        stop: StopReason::Stopped,
                        ..best
                    })
                });
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => match worker.join() {
                Ok(()) => return Err(Error::Interrupted),
                Err(panic) => std::panic::resume_unwind(panic),
            },
        }
    }
}

/// How often the time limit is looked at from outside.
const LOOK: Duration = Duration::from_millis(50);

fn override_settings(file: &mut MotionFile, args: &DesignArgs) -> Result<()> {
    let search = &mut file.settings.search;
    search.seed = args.seed.unwrap_or(search.seed);
    search.effort = args.effort.unwrap_or(search.effort);
    search.time_limit_s = args.max_time.unwrap_or(search.time_limit_s);
    match args.method {
        Some(cli::Method::Exact) => search.method = Method::Exact,
        Some(cli::Method::Paper) => search.method = Method::Paper,
        None => {}
    }
    let problems = file.settings.problems(file.class);
    if problems.is_empty() {
        Ok(())
    } else {
        Err(Error::Input {
            file: "command line".into(),
            problems: problems.into(),
        })
    }
}

/// One run: who asked, where the result goes, how long it takes.
struct Job<'a> {
    cli: &'a Cli,
    target: Target,
    watch: Arc<Watch>,
    /// What a motion that does not work would work with.
    remedies: Vec<Remedy>,
}

impl Job<'_> {
    /// Tries what would work, for a minute at the most and within the time limit.
    fn remedies(&self, file: &MotionFile, motion: &Motion) -> Vec<Remedy> {
        if file.settings.search.method != Method::Exact {
            return Vec::new();
        }
        let started = self.watch.seconds();
        remedy::find(motion, &file.settings, &mut |progress| {
            let late = self.watch.seconds() - started > REMEDIES_S;
            match self.watch.tell(progress) {
                ControlFlow::Continue(()) if !late => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        })
    }

    /// Writes what was found and tells of it. A first look has no report, which would take longer than
    /// the rest of it.
    fn deliver(&self, args: &DesignArgs, motion: &Motion, outcome: &Outcome) -> Result<u8> {
        let design = &outcome.design;
        let works = design.problems.is_empty();
        let mut summary = summarise(outcome, motion);
        let remedies = self.remedies.iter().map(Remedy::to_string);
        summary.remarks.extend(remedies);
        if !works && outcome.check.as_ref().is_some_and(is_only_too_weak) {
            summary
                .remarks
                .push("`mpcgear size` looks for the smallest gear that carries a payload".into());
        }
        summary.remedies = self.remedies.clone();
        summary.draft = args.draft;
        self.watch.enter("report and files");
        let source = Source {
            design,
            motion,
            solids: outcome.solids.as_ref(),
        };
        let mut files = export::files(&source, &summary)?;
        if outcome.solids.is_some() && !args.draft && !self.watch.is_overdue() {
            let paths: Vec<PathBuf> = files.iter().map(|f| f.path.clone()).collect();
            let text = std::fs::read_to_string(&args.file).unwrap_or_default();
            files.push(super::report::page(
                &source,
                outcome.check.as_ref(),
                (&paths, &text),
            )?);
        }
        summary.wall_seconds = self.watch.seconds();
        summary.stages = self.watch.stages();
        if let Some(file) = files.iter_mut().find(|f| f.path == Path::new(SUMMARY)) {
            file.bytes = tables::summary_json(&summary)?.into();
        }
        let folder = self.target.folder(works);
        folder.publish(&files)?;
        show(self.cli, &summary, folder.path())?;
        let asked_for = works || (args.draft && outcome.solids.is_some());
        Ok(match (self.watch.interrupted(), asked_for) {
            (true, _) => 130,
            (false, true) => 0,
            (false, false) => 3,
        })
    }

    /// Writes the draft of a motion that cannot be made and hands the error on; other errors leave nothing.
    fn give_up(&self, file: &MotionFile, motion: Option<&Motion>, error: Error) -> Result<u8> {
        if let Error::Infeasible {
            reason,
            place,
            hint,
        } = &error
        {
            let mut draft = Design::draft(file);
            draft.problems = vec![format!("{reason} ({place}); {hint}")];
            let mut summary = Summary::of(&draft);
            summary.stopped = reason == OUT_OF_TIME;
            summary.remedies = self.remedies.clone();
            summary.wall_seconds = self.watch.seconds();
            let files = match motion {
                Some(motion) => export::files(
                    &Source {
                        design: &draft,
                        motion,
                        solids: None,
                    },
                    &summary,
                )?,
                None => vec![
                    export::File::new("design.json", file::text(&draft)?),
                    export::File::new(SUMMARY, tables::summary_json(&summary)?),
                ],
            };
            let folder = self.target.folder(false);
            folder.publish(&files)?;
            show(self.cli, &summary, folder.path())?;
        }
        Err(error)
    }
}

/// Whether nothing stands against it but the payload that its settings demand, which no other motion helps.
fn is_only_too_weak(check: &Check) -> bool {
    let mut failed = check.claims.iter().filter(|c| !c.holds);
    failed.all(|c| c.name == PAYLOAD)
}

/// The figures of what was found; remedies and time stay open.
pub(super) fn summarise(outcome: &Outcome, motion: &Motion) -> Summary {
    let design = &outcome.design;
    let mut summary = Summary::of(design);
    summary.conjugation_residual_max = Some(outcome.residual);
    if let Some(proof) = outcome.check.as_ref().and_then(|c| c.proof.as_ref()) {
        let overlap = proof.overlap_max_mm3();
        summary.overlap_max_mm3 = overlap.is_finite().then_some(overlap);
        summary.escapes = Some(proof.escapes.len());
        let all_thicker = 1.25 * design.settings.gear.minimum_wall_mm;
        summary.wall_min_mm = Some(proof.wall_min_mm().unwrap_or(all_thicker));
    }
    summary.choice_proved = outcome.is_proved;
    summary.remarks = outcome.remarks.clone();
    let certified = match &outcome.check {
        Some(check) => check.certified,
        None => certified::of(design, motion),
    };
    summary.q_certified = certified.map(|c| c.q);
    summary.q_star_certified = certified.map(|c| c.q_star);
    let bound = bound::of(design, motion);
    summary.q_bound = bound.map(|b| b.q);
    summary.q_star_bound = bound.map(|b| b.q_star);
    summary.stopped = outcome.stop == StopReason::Stopped;
    summary
}

/// Time for the search of remedies, s.
const REMEDIES_S: f64 = 60.0;

/// The error with what would work as part of its hint.
fn with_remedies(error: Error, remedies: &[Remedy]) -> Error {
    match error {
        Error::Infeasible {
            reason,
            place,
            hint,
        } if !remedies.is_empty() => {
            let found: Vec<String> = remedies.iter().map(Remedy::to_string).collect();
            Error::Infeasible {
                reason,
                place,
                hint: format!("{hint}\n  found: {}", found.join("; ")),
            }
        }
        error => error,
    }
}

const OUT_OF_TIME: &str = "the time limit ended the search before there was any design";

fn out_of_time(file: &MotionFile) -> Error {
    Error::Infeasible {
        reason: OUT_OF_TIME.into(),
        place: format!(
            "limit {} s, half of it for the search",
            file.settings.search.time_limit_s
        ),
        hint: "allow more time (--max-time, search.time_limit_s)".into(),
    }
}

/// Where the result goes: a draft does not replace an existing design, it goes beside it. A first look
/// is replaced by anything.
struct Target {
    out: Folder,
    draft: Option<Folder>,
}

impl Target {
    /// Takes the folders, before any long work.
    fn claim(path: &Path) -> Result<Target> {
        let out = Folder::claim(path)?;
        let draft = match out.has_design() && !is_first_look(path) {
            true => Some(Folder::claim(&beside(path)?)?),
            false => None,
        };
        Ok(Target { out, draft })
    }

    fn folder(&self, works: bool) -> &Folder {
        match &self.draft {
            Some(draft) if !works => draft,
            _ => &self.out,
        }
    }
}

/// Whether the design in a folder says of itself that it is a first look.
fn is_first_look(folder: &Path) -> bool {
    let text = std::fs::read_to_string(folder.join(SUMMARY)).unwrap_or_default();
    serde_json::from_str(&text).is_ok_and(|summary: Summary| summary.draft)
}

/// The folder for a draft beside `out`.
fn beside(out: &Path) -> Result<PathBuf> {
    // `.` and `..` have no name of their own.
    let whole = if out.file_name().is_some() {
        out.to_path_buf()
    } else {
        out.canonicalize().map_err(Error::io(out))?
    };
    let mut name = whole.file_name().unwrap_or_default().to_os_string();
    name.push(".draft");
    Ok(whole.with_file_name(name))
}

/// What to open first of a folder that was written: the report, or the bodies where there is none. Only
/// what works is to be printed.
fn next(written: &Path, works: bool) -> Option<String> {
    let there = |name: &str| Some(written.join(name)).filter(|path| path.exists());
    let Some(page) = there("report.html") else {
        let meshes = there("meshes")?;
        return Some(format!("look at the bodies in {}", meshes.display()));
    };
    let mut next = format!("open {} in a browser", page.display());
    if works {
        let parts = written.join("parts.md");
        next += &format!("; {} says how to print it", parts.display());
    }
    Some(next)
}

fn show(cli: &Cli, summary: &Summary, written: &Path) -> Result<()> {
    if cli.json {
        return print_out(&json(summary)?);
    }
    let figure = |value: Option<f64>| value.map_or("–".into(), |v| format!("{v:.3}"));
    let state = match (summary.feasible, summary.draft) {
        (true, _) => "works",
        (false, true) => "first look, not proved",
        (false, false) => "draft, does not work",
    };
    let mut text = format!(
        "{} ({}): {state}. K = {}, min Q {}, η {}, overlap {} mm³, escapes {}, thinnest wall {} mm, {:.1} s\n",
        summary.name,
        summary.class,
        summary.k,
        figure(summary.q_min),
        figure(summary.eta_min),
        figure(summary.overlap_max_mm3),
        summary.escapes.map_or("–".into(), |n| n.to_string()),
        figure(summary.wall_min_mm),
        summary.wall_seconds,
    );
    for problem in &summary.problems {
        text += &format!("  - {problem}\n");
    }
    for remark in &summary.remarks {
        text += &format!("{remark}\n");
    }
    if summary.stopped {
        text += "stopped early: the best so far; more time may give a better design\n";
    }
    text += &format!("written: {}", written.display());
    if let Some(next) = next(written, summary.feasible) {
        text += &format!("\nnext: {next}");
    }
    say(cli, &text).map(|_| ())
}
