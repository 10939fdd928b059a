//! What the user sees while it works: progress bar, Ctrl-C, time limit, errors.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mpcgear::Error;
use mpcgear::escape::terminal;
use mpcgear::export::tables::Stage;
use mpcgear::search::Progress;

/// Watches a run: shows its progress and tells it when to stop.
#[derive(Debug)]
pub struct Watch {
    bar: ProgressBar,
    /// Where there is no terminal to draw a bar on: the stage that was last written as a line.
    lines: Option<Mutex<&'static str>>,
    /// Where a program reads: when the last line of JSON was written, s, and for which stage.
    records: Option<Mutex<(f64, &'static str)>>,
    interrupted: Arc<AtomicBool>,
    started: Instant,
    stages: Mutex<Stages>,
    /// Time for the whole run, s; none before it is known.
    limit_s: OnceLock<f64>,
}

/// Share of the time limit after which the search ends; bodies and proof follow.
const SEARCH: f64 = 0.5;
/// Share of the time limit after which bodies and proof end; the rest is for the files.
const PROOF: f64 = 0.85;
/// Least time between two lines for programs, s.
const RECORD_S: f64 = 0.2;
/// Seconds after that in which a step under way may come to its end.
const GRACE_S: f64 = 0.5;

impl Watch {
    /// Starts the clock and installs the Ctrl-C handler.
    pub fn new(quiet: bool) -> Watch {
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&interrupted);
        // A second Ctrl-C ends the process at once, should a long step be under way.
        let handler = move || {
            if flag.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            warn(&format!("Ctrl-C will not stop cleanly: {error}"));
        }
        let bar = ProgressBar::new(1000);
        if quiet {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template("{elapsed_precise} {bar:30} {msg}") {
            bar.set_style(style);
        }
        Watch {
            bar,
            lines: (!quiet && !std::io::stderr().is_terminal()).then(|| Mutex::new("")),
            records: None,
            interrupted,
            started: Instant::now(),
            stages: Mutex::default(),
            limit_s: OnceLock::new(),
        }
    }

    /// As [`Watch::new`], with progress as lines of JSON on standard error: seconds, stage, share of the
    /// stage that is done, usable bands, best hold so far.
    pub fn for_programs() -> Watch {
        Watch {
            records: Some(Mutex::new((f64::NEG_INFINITY, ""))),
            ..Watch::new(true)
        }
    }

    /// Sets how long the run may take since [`Watch::new`], s; ≤ 0 means no limit. Once only.
    pub fn limit(&self, seconds: f64) {
        if seconds > 0.0 {
            let _ = self.limit_s.set(seconds);
        }
    }

    /// Whether Ctrl-C was pressed.
    pub fn interrupted(&self) -> bool {
        self.interrupted.load(Ordering::SeqCst)
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Whether the time limit, if there is one, times `share` plus `grace` seconds is over.
    fn is_late(&self, share: f64, grace: f64) -> bool {
        self.limit_s
            .get()
            .is_some_and(|limit| self.seconds() > share * limit + grace)
    }

    /// Whether a step that takes no notice of the time limit is to be left behind.
    pub fn is_overdue(&self) -> bool {
        self.is_late(PROOF, GRACE_S)
    }

    /// Ends the stage under way and begins `stage`.
    pub fn enter(&self, stage: &'static str) {
        let now = (self.seconds(), cpu_seconds());
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        stages.enter(stage, now);
    }

    /// What each stage took until now, in the order in which they began.
    pub fn stages(&self) -> Vec<Stage> {
        self.enter("");
        let stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        stages.done.clone()
    }

    /// Shows progress (a bar, or a line a stage where there is no terminal); stops on Ctrl-C, and
    /// search and proof each when its share of the time limit is over.
    pub fn tell(&self, progress: &Progress) -> ControlFlow<()> {
        let best = progress
            .best_q
            .map_or(String::new(), |q| format!(", best hold {q:.3}"));
        let count = match progress.candidates {
            0 => String::new(),
            n => format!(", {n} usable bands"),
        };
        let message = format!("{}{count}{best}", progress.stage);
        self.enter(progress.stage);
        if let Some(last) = &self.lines {
            let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
            if std::mem::replace(&mut *last, progress.stage) != progress.stage {
                eprintln!("{:7.1} s  {}", self.seconds(), terminal(&message));
            }
        }
        self.show(&message, progress.done);
        self.record(progress);
        let share = if progress.is_search() { SEARCH } else { PROOF };
        if self.interrupted() || self.is_late(share, 0.0) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Writes a line for programs: at every new stage, and a few a second.
    fn record(&self, progress: &Progress) {
        let Some(last) = &self.records else { return };
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        let now = self.seconds();
        if now - last.0 < RECORD_S && last.1 == progress.stage {
            return;
        }
        *last = (now, progress.stage);
        let line = serde_json::json!({
            "seconds": now,
            "stage": progress.stage,
            "done": progress.done,
            "bands": progress.candidates,
            "best_hold": progress.best_q,
        });
        eprintln!("{line}");
    }

    fn show(&self, message: &str, done: f64) {
        self.bar.set_message(terminal(message));
        self.bar.set_position((done * 1000.0) as u64);
    }

    /// Shows a step of a job that has no time limit; stops on Ctrl-C.
    pub fn step(&self, what: &str, done: f64) -> ControlFlow<()> {
        self.show(what, done);
        match self.interrupted() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Time of the stages of a run.
#[derive(Debug, Default)]
struct Stages {
    done: Vec<Stage>,
    /// The one under way, with wall and processor time when it began, s.
    now: Option<(&'static str, (f64, Option<f64>))>,
}

impl Stages {
    fn enter(&mut self, stage: &'static str, (wall, cpu): (f64, Option<f64>)) {
        let (last, (began, cpu_began)) = match self.now {
            Some((last, _)) if last == stage => return,
            Some(under_way) => under_way,
            // What comes before the first stage is reading.
            None => ("", (wall, cpu)),
        };
        self.now = Some((stage, (wall, cpu)));
        let cpu_s = cpu.zip(cpu_began).map(|(cpu, began)| cpu - began);
        let wall_s = wall - began;
        match self.done.iter_mut().find(|s| s.name == last) {
            Some(again) => {
                again.wall_s += wall_s;
                again.cpu_s = again.cpu_s.zip(cpu_s).map(|(a, b)| a + b);
            }
            None if last.is_empty() => {}
            None => self.done.push(Stage {
                name: last.into(),
                wall_s,
                cpu_s,
            }),
        }
    }
}

/// Processor time of this process so far, all threads, s; `None` where the system does not tell.
#[cfg(unix)]
pub fn cpu_seconds() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

/// Not told here.
#[cfg(not(unix))]
pub fn cpu_seconds() -> Option<f64> {
    None
}

/// Prints a warning on standard error.
pub fn warn(text: &str) {
    eprintln!("warning: {}", terminal(text));
}

/// Prints an error on standard error, as JSON if asked.
pub fn complain(error: &Error, json: bool) {
    if json {
        let value =
            serde_json::json!({ "error": error.to_string(), "exit_code": error.exit_code() });
        eprintln!("{}", terminal(&value.to_string()));
    } else {
        eprintln!("error: {}", terminal(&error.to_string()));
    }
}
