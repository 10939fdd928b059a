//! `mpcgear trial`: one design of an exploration, in a process of its own that may crash or take too long.

use std::io::{ErrorKind, Read};
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use mpcgear::disk::Folder;
use mpcgear::explore::measures;
use mpcgear::explore::trial::{Record, Stage, State, Trial};
use mpcgear::export::{self, File, Source};
use mpcgear::motion::MotionFile;
use mpcgear::pipeline::{self, Outcome};
use mpcgear::{Error, Result};
use serde::Serialize;

use super::design::summarise;
use super::{json, print_out, say};
use crate::cli::{Cli, TrialArgs};

/// How often time is looked at.
const LOOK: Duration = Duration::from_millis(10);

/// Files of a design that a trial keeps: bodies are made again by `mpcgear export`.
const KEPT: [&str; 3] = ["design.json", "summary.json", "report.html"];

/// The answer with `--json`.
#[derive(Serialize)]
struct Answer<'a> {
    /// Whether it had been computed before.
    reused: bool,
    #[serde(flatten)]
    record: &'a Record,
}

/// Runs a trial, or finds that it was run before; exit code 0 whatever came of it.
///
/// # Errors
/// A motion file that is bad without any change, folders that cannot be written, interruption.
pub fn run(cli: &Cli, args: &TrialArgs) -> Result<u8> {
    if args.unwatched {
        limit_memory(args.memory_mb);
        end_with_parent();
        compute(args)?;
        return Ok(0);
    }
    // Bad without any change: told as such, and no trial.
    let (_, _) = MotionFile::read_draft(&args.file)?;
    let (record, reused) = watched(args)?;
    if cli.json {
        let record = &record;
        print_out(&json(&Answer { reused, record })?)?;
        return Ok(0);
    }
    let state = match record.state {
        State::Complete => "a gear".to_owned(),
        State::Infeasible => format!("no gear: {}", record.reason),
        State::Poisoned => format!("cannot be computed: {}", record.reason),
    };
    let folder = args.into.join(&record.key);
    say(cli, &format!("{state}\nwritten: {}", folder.display()))
}

/// What of `args` makes the trial.
fn trial(args: &TrialArgs) -> Trial<'_> {
    Trial {
        motion: &args.file,
        changes: &args.set,
        stage: if args.draft {
            Stage::Draft
        } else {
            Stage::Design
        },
    }
}

/// The record of a trial, and whether it was there before. What crashes or takes too long is recorded as
/// poisoned.
///
/// # Errors
/// As [`run`].
pub fn watched(args: &TrialArgs) -> Result<(Record, bool)> {
    let mut record = trial(args).record()?;
    let path = args.into.join(&record.key);
    if let Some(found) = Record::read(&path) {
        return Ok((found, true));
    }
    let started = Instant::now();
    let mut child = spawn(args).map_err(Error::io("mpcgear"))?;
    let ended = wait(&mut child, Duration::from_secs_f64(args.timeout));
    let reason = match ended.map_err(Error::io("mpcgear"))? {
        None => format!("took longer than {} s", args.timeout),
        Some(status) if status.success() => {
            let missing = || Error::Internal(format!("{} has no record", path.display()));
            return Ok((Record::read(&path).ok_or_else(missing)?, false));
        }
        Some(status) => failure(status, &mut child, args)?,
    };
    let folder = taken(&path)?;
    if let Some(found) = Record::read(&path) {
        return Ok((found, true));
    }
    record.state = State::Poisoned;
    record.reason = reason;
    record.seconds = started.elapsed().as_secs_f64();
    folder.publish(&[record.file()?])?;
    Ok((record, false))
}

/// The folder of a trial for this process alone. Where another process is at it, its end is waited for.
fn taken(path: &Path) -> Result<Folder> {
    loop {
        match Folder::open(path) {
            Err(Error::Io { source, .. }) if source.kind() == ErrorKind::WouldBlock => {
                std::thread::sleep(LOOK);
            }
            other => return other,
        }
    }
}

/// The same command in a process that computes.
fn spawn(args: &TrialArgs) -> std::io::Result<Child> {
    let mut command = Command::new(std::env::current_exe()?);
    command
        .args(["--json", "trial", "--unwatched", "--into"])
        .arg(&args.into);
    command.args(["--memory-mb", &args.memory_mb.to_string()]);
    if args.draft {
        command.arg("--draft");
    }
    for change in &args.set {
        command.args(["--set", &change.to_string()]);
    }
    command.arg("--").arg(&args.file);
    if args.threads > 0 {
        command.env("RAYON_NUM_THREADS", args.threads.to_string());
    }
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command.spawn()
}

/// How the process ended; `None` where it had to be ended.
fn wait(child: &mut Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if started.elapsed() > limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(LOOK);
    }
}

/// Why a trial has no answer. Ends that are not its fault are errors: Ctrl-C, a full disk.
fn failure(status: ExitStatus, child: &mut Child, args: &TrialArgs) -> Result<String> {
    let mut said = String::new();
    if let Some(stderr) = &mut child.stderr {
        // What cannot be read is not told.
        let _ = stderr.take(100_000).read_to_string(&mut said);
    }
    let said = said.trim();
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        const INTERRUPTS: [i32; 3] = [1, 2, 15];
        match status.signal() {
            Some(signal) if INTERRUPTS.contains(&signal) => return Err(Error::Interrupted),
            Some(signal) => {
                let limit = args.memory_mb;
                return Ok(format!(
                    "crashed (signal {signal}; it may have {limit} MB): {said}"
                ));
            }
            None => {}
        }
    }
    match status.code() {
        Some(2) => {
            let told: Option<serde_json::Value> = serde_json::from_str(said).ok();
            let told = told.and_then(|value| Some(value.get("error")?.as_str()?.to_owned()));
            let what = told.unwrap_or_else(|| said.to_owned());
            Err(Error::io(&args.into)(std::io::Error::other(what)))
        }
        _ => Ok(format!("crashed: {said}")),
    }
}

/// Memory that this process may have from here on.
#[cfg(target_os = "linux")]
fn limit_memory(megabytes: u64) {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let most = Some(megabytes * 1_000_000);
    // Where limits cannot be set the machine's own is what holds.
    let _ = setrlimit(
        Resource::As,
        Rlimit {
            current: most,
            maximum: most,
        },
    );
}

/// No such limit here.
#[cfg(not(target_os = "linux"))]
fn limit_memory(_: u64) {}

/// Ends this process with the one that watches its time, so that none goes on for ever.
#[cfg(target_os = "linux")]
fn end_with_parent() {
    use rustix::process::{Signal, set_parent_process_death_signal};
    // Where that cannot be asked for the process ends by itself, as most trials do.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
}

/// Nobody tells here.
#[cfg(not(target_os = "linux"))]
fn end_with_parent() {}

/// Computes a trial and writes its folder, whole or not at all.
fn compute(args: &TrialArgs) -> Result<()> {
    let started = Instant::now();
    let trial = trial(args);
    let mut record = trial.record()?;
    let path = args.into.join(&record.key);
    let folder = taken(&path)?;
    if Record::read(&path).is_some() {
        return Ok(());
    }
    let mut files = match made(&trial, &mut record) {
        Ok(files) => files,
        Err(Error::Infeasible { reason, place, .. }) => {
            record.reason = format!("{reason} ({place})");
            Vec::new()
        }
        // The file is good without the changes, so it is they that do not fit together.
        Err(Error::Input { problems, .. }) => {
            record.reason = format!("refused: {problems}");
            Vec::new()
        }
        Err(error) => return Err(error),
    };
    record.seconds = started.elapsed().as_secs_f64();
    (record.cpu_seconds, record.memory_mb) = spent();
    files.push(record.file()?);
    folder.publish(&files)
}

/// Makes the design and fills in its record; the files to keep.
fn made(trial: &Trial, record: &mut Record) -> Result<Vec<File>> {
    let (file, motion) = MotionFile::read_changed(trial.motion, trial.changes)?;
    let motion = motion?;
    let go = &mut |_: pipeline::Event| ControlFlow::Continue(());
    let outcome = match trial.stage {
        Stage::Draft => pipeline::draft(&file, &motion, go)?,
        Stage::Design => pipeline::run(&file, &motion, go)?,
    };
    let Outcome { design, solids, .. } = &outcome;
    let summary = summarise(&outcome, &motion);
    let figures = measures::figures(&outcome, &motion, &summary);
    record.figures = figures
        .into_iter()
        .map(|(name, v)| (name.to_owned(), v))
        .collect();
    let works = match trial.stage {
        Stage::Draft => solids.is_some(),
        Stage::Design => design.problems.is_empty(),
    };
    match works {
        true => record.state = State::Complete,
        false => record.reason = design.problems.join("; "),
    }
    if trial.stage == Stage::Draft {
        return Ok(Vec::new());
    }
    let source = Source {
        design,
        motion: &motion,
        solids: solids.as_ref(),
    };
    let mut files = export::files(&source, &summary)?;
    files.retain(|file| KEPT.iter().any(|name| file.path == Path::new(name)));
    if solids.is_some() {
        let text = std::fs::read_to_string(trial.motion).unwrap_or_default();
        let mut beside: Vec<_> = files.iter().map(|f| f.path.clone()).collect();
        beside.push(mpcgear::explore::trial::RECORD.into());
        files.push(super::report::page(
            &source,
            outcome.check.as_ref(),
            (&beside, &text),
        )?);
    }
    Ok(files)
}

/// Processor time (s) and largest memory (MB) of this process.
#[cfg(target_os = "linux")]
fn spent() -> (Option<f64>, Option<f64>) {
    /// Ticks of a second in `/proc`.
    const TICKS: f64 = 100.0;
    let read = |name: &str| std::fs::read_to_string(format!("/proc/self/{name}")).ok();
    // The name of the program, in parentheses, may have blanks; fields 14 and 15 are the times.
    let ticks = read("stat").and_then(|text| {
        let (_, after) = text.rsplit_once(')')?;
        let fields: Vec<&str> = after.split_whitespace().collect();
        let tick = |i: usize| fields.get(i)?.parse::<f64>().ok();
        Some(tick(11)? + tick(12)?)
    });
    let memory = read("status").and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()
    });
    (ticks.map(|t| t / TICKS), memory.map(|kb| kb * 1.024e-3))
}

/// Not told here.
#[cfg(not(target_os = "linux"))]
fn spent() -> (Option<f64>, Option<f64>) {
    (None, None)
}
