//! What the user sees while it works: progress bar, Ctrl-C, time limit, errors.

use std::cell::Cell;
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mpcgear::Error;
use mpcgear::escape::terminal;
use mpcgear::search::Progress;

/// Watches a design run: shows its progress and tells it when to stop.
pub struct Watch {
    bar: ProgressBar,
    /// Where there is no terminal to draw a bar on: the stage that was last written as a line.
    lines: Option<Cell<&'static str>>,
    interrupted: Arc<AtomicBool>,
    started: Instant,
    limit: Option<Duration>,
}

impl Watch {
    /// Installs the Ctrl-C handler; `limit_s` ≤ 0 means no limit.
    pub fn new(quiet: bool, limit_s: f64) -> Watch {
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&interrupted);
        // A second Ctrl-C ends the process at once, should a long step be under way.
        let handler = move || {
            if flag.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            eprintln!("warning: Ctrl-C will not stop cleanly: {error}");
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
            lines: (!quiet && !std::io::stderr().is_terminal()).then(|| Cell::new("")),
            interrupted,
            started: Instant::now(),
            limit: (limit_s > 0.0).then(|| Duration::from_secs_f64(limit_s)),
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

    /// Shows progress (a bar, or a line a stage where there is no terminal); stops on Ctrl-C, and the search (not what follows) at the time limit.
    pub fn tell(&self, progress: &Progress) -> ControlFlow<()> {
        let best = progress
            .best_q
            .map_or(String::new(), |q| format!(", best hold {q:.3}"));
        let count = match progress.candidates {
            0 => String::new(),
            n => format!(", {n} usable bands"),
        };
        let message = format!("{}{count}{best}", progress.stage);
        if let Some(last) = &self.lines
            && last.replace(progress.stage) != progress.stage
        {
            eprintln!("{:7.1} s  {message}", self.seconds());
        }
        self.bar.set_message(message);
        self.bar.set_position((progress.done * 1000.0) as u64);
        let late = self
            .limit
            .is_some_and(|limit| self.started.elapsed() > limit);
        if self.interrupted() || (late && progress.is_search()) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Shows a step of a job that has no time limit; stops on Ctrl-C.
    pub fn step(&self, what: &str, done: f64) -> ControlFlow<()> {
        self.bar.set_message(what.to_owned());
        self.bar.set_position((done * 1000.0) as u64);
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
