//! `mpcgear explore`: the study is read and checked here; the search over trials is the Python package's, which
//! asks this program for every trial. Shards need no Python.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use mpcgear::disk;
use mpcgear::explore::plan;
use mpcgear::explore::study::Study;
use mpcgear::explore::trial::{State, base};
use mpcgear::motion::MotionFile;
use mpcgear::{Error, Problem, Result};
use serde::{Deserialize, Serialize};

use super::{json, print_out, say, trial};
use crate::cli::{Cli, ExploreArgs, Shard, TrialArgs};
use crate::terminal::Watch;

/// `study.json`: the study as it was read, for the Python package and for later runs.
#[derive(Debug, Serialize, Deserialize)]
struct Opened {
    /// Motion file.
    motion: PathBuf,
    /// Its key.
    base: String,
    /// The study.
    #[serde(flatten)]
    study: Study,
}

/// Name of the checked study in its folder.
const STUDY: &str = "study.json";
/// Folder of the trials in it.
const TRIALS: &str = "trials";
/// Variable of the environment with the Python interpreter to use.
const PYTHON: &str = "MPCGEAR_PYTHON";
/// Packages that the extra `explore` brings.
const NEEDED: [&str; 5] = [
    "mpcgear_explore",
    "optuna",
    "distributed",
    "pandas",
    "pyarrow",
];

/// Explores, or continues; the exit code of the Python program, or 0.
///
/// # Errors
/// Bad motion and study files, folders that cannot be written, a missing Python package.
pub fn run(cli: &Cli, args: &ExploreArgs) -> Result<u8> {
    let (_, motion) = MotionFile::read_draft(&args.file)?;
    let opened = Opened {
        motion: std::path::absolute(&args.file).map_err(Error::io(&args.file))?,
        base: base(&args.file)?,
        study: Study::read(&args.study, &args.file)?,
    };
    // A motion that no gear has may get one by a change; it is only told.
    if let Err(error) = motion
        && !cli.quiet
    {
        crate::terminal::warn(&format!("without changes the motion is {error}"));
    }
    if !args.watch {
        open(&opened, &args.out)?;
    } else if !args.out.join(STUDY).is_file() {
        let what = "there is no study yet";
        let hint = "start it with the same command without --watch";
        return Err(Error::input(&args.out, Problem::new("-o", what, hint)));
    }
    match args.shard {
        Some(shard) => compute(cli, (args, &opened), shard),
        None => python(cli, args),
    }
}

/// Makes the study's folder, or finds that it is the same study's.
fn open(opened: &Opened, folder: &Path) -> Result<()> {
    let path = folder.join(STUDY);
    if let Ok(text) = std::fs::read(&path) {
        let before: Option<Opened> = serde_json::from_slice(&text).ok();
        let same = before.is_some_and(|b| b.base == opened.base && b.study.is_same(&opened.study));
        if !same {
            let what = "belongs to another study or another motion";
            let hint = "choose another folder; in one study only budget and limits may change";
            return Err(Error::input(&path, Problem::new("study", what, hint)));
        }
    }
    std::fs::create_dir_all(folder.join(TRIALS)).map_err(Error::io(folder))?;
    disk::write_whole(&path, (json(opened)? + "\n").as_bytes())
}

/// The Python interpreter: the one that is named, or beside this program, where pip puts both, or on the path.
fn interpreter(own: &Path) -> PathBuf {
    if let Some(named) = std::env::var_os(PYTHON) {
        return named.into();
    }
    let beside = own.with_file_name(if cfg!(windows) {
        "python.exe"
    } else {
        "python3"
    });
    match beside.is_file() {
        true => beside,
        false => "python3".into(),
    }
}

/// Hands over to the Python package.
fn python(cli: &Cli, args: &ExploreArgs) -> Result<u8> {
    let own = std::env::current_exe().map_err(Error::io("mpcgear"))?;
    let program = interpreter(&own);
    let look = format!(
        "import sys; from importlib.util import find_spec\n\
         sys.exit(' '.join(n for n in {NEEDED:?} if not find_spec(n)) or 0)"
    );
    let looked = Command::new(&program)
        .args(["-c", &look])
        .stdin(Stdio::null())
        .output();
    let missing = match looked {
        Ok(output) if output.status.success() => None,
        Ok(output) => Some(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
        Err(error) => Some(error.to_string()),
    };
    if let Some(missing) = missing {
        let what = format!("exploring needs Python packages that are missing: {missing}");
        let hint = format!(
            "pip install \".[explore]\" in the folder of mpcgear, or set {PYTHON} to an interpreter that has them; \
             --shard needs none"
        );
        return Err(Error::input(program, Problem::new("python", what, hint)));
    }
    let mut command = Command::new(&program);
    command.args([
        "-m",
        "mpcgear_explore",
        if args.watch { "watch" } else { "run" },
    ]);
    command.arg(&args.out).arg("--binary").arg(own);
    match &args.scheduler {
        Some(address) => command.args(["--scheduler", address]),
        None => command.args(["--workers", &args.workers.to_string()]),
    };
    command.args(cli.quiet.then_some("--quiet"));
    command.args(cli.json.then_some("--json"));
    // Ctrl-C goes to both; the Python program ends its work, and this one waits for it.
    let _watch = Watch::new(true);
    let status = command.status().map_err(Error::io(program))?;
    Ok(status
        .code()
        .and_then(|code| u8::try_from(code).ok())
        .unwrap_or(1))
}

/// What a shard did, with `--json`.
#[derive(Debug, Default, Serialize)]
struct Done {
    /// Trials of this shard.
    trials: u64,
    /// Of them, found computed.
    reused: u64,
    /// Gears.
    complete: u64,
    /// No gears.
    infeasible: u64,
    /// Crashed or too slow.
    poisoned: u64,
}

/// Computes the trials of a shard one after the other.
fn compute(cli: &Cli, (args, opened): (&ExploreArgs, &Opened), shard: Shard) -> Result<u8> {
    let Some(all) = opened.study.budget.trials else {
        let what = "shards need a number of trials";
        let hint = "write trials = 200";
        return Err(Error::input(
            &args.study,
            Problem::new("budget.trials", what, hint),
        ));
    };
    let watch = Watch::new(cli.quiet || cli.json);
    let mut done = Done::default();
    for number in (shard.index..all).step_by(shard.count as usize) {
        let share = number as f64 / all as f64;
        if watch
            .step(&format!("draft {} of {all}", number + 1), share)
            .is_break()
        {
            watch.finish();
            return Ok(130);
        }
        let one = TrialArgs {
            file: args.file.clone(),
            set: plan::trial(&opened.study, number),
            into: args.out.join(TRIALS),
            draft: true,
            timeout: opened.study.limits.draft_s,
            memory_mb: opened.study.limits.memory_mb,
            threads: opened.study.limits.threads,
            unwatched: false,
        };
        let (record, reused) = match trial::watched(&one) {
            Err(Error::Interrupted) => {
                watch.finish();
                return Ok(130);
            }
            other => other?,
        };
        done.trials += 1;
        done.reused += u64::from(reused);
        *match record.state {
            State::Complete => &mut done.complete,
            State::Infeasible => &mut done.infeasible,
            State::Poisoned => &mut done.poisoned,
        } += 1;
    }
    watch.finish();
    if cli.json {
        print_out(&json(&done)?)?;
        return Ok(0);
    }
    say(
        cli,
        &format!(
            "{} drafts: {} gears, {} none, {} poisoned; {} were there before",
            done.trials, done.complete, done.infeasible, done.poisoned, done.reused
        ),
    )
}
