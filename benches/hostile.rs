//! Mutated input in large numbers: `cargo bench --bench hostile -- 100000`. Prints a table: inputs per
//! target, how many were accepted, crashes, the longest time and the memory that one took. Every target
//! runs in a process of its own; a crash does not end the run, and is named with the input's number.

#![allow(clippy::print_stdout)] // printing is what it is for

#[path = "../fuzz/mutate.rs"]
mod mutate;
#[path = "../fuzz/seeds.rs"]
mod seeds;
#[path = "../fuzz/targets.rs"]
mod targets;

use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

/// Inputs per target where no number is given.
const COUNT: u64 = 10_000;

fn main() -> ExitCode {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let count = arguments
        .first()
        .and_then(|n| n.parse().ok())
        .unwrap_or(COUNT);
    if let Some(target) = arguments.get(1) {
        return one(target, count);
    }
    println!("| target | inputs | accepted | crashes | longest ms | memory MB |");
    println!("|---|---|---|---|---|---|");
    let mut sound = true;
    for (name, _) in targets::ALL {
        let program = std::env::current_exe().expect("this program");
        let mut command = Command::new(program);
        command
            .args([&count.to_string(), name])
            .stdout(Stdio::inherit());
        let ended = command.status().expect("runs");
        if ended.code().is_none_or(|code| code > 1) {
            println!("| {name} | {count} | | aborted: {ended} | | |");
        }
        sound &= ended.success();
    }
    ExitCode::from(u8::from(!sound))
}

/// Runs one target and prints its line; exit code 1 after a panic.
fn one(target: &str, count: u64) -> ExitCode {
    let (name, run) = targets::ALL
        .into_iter()
        .find(|(name, _)| *name == target)
        .expect("one of the targets");
    let seeds = seeds::of(name);
    let (mut accepted, mut crashes, mut longest) = (0, 0, (Duration::ZERO, 0));
    for index in 0..count {
        let input = mutate::input(&seeds, index);
        let started = Instant::now();
        match std::panic::catch_unwind(|| run(&input)) {
            Ok(told) => accepted += u64::from(told),
            Err(_) => {
                crashes += 1;
                eprintln!("{name}: input {index} makes a panic");
            }
        }
        longest = longest.max((started.elapsed(), index));
    }
    eprintln!("{name}: input {} takes the longest", longest.1);
    let ms = longest.0.as_secs_f64() * 1e3;
    println!(
        "| {name} | {count} | {accepted} | {crashes} | {ms:.1} | {} |",
        memory()
    );
    ExitCode::from(u8::from(crashes > 0))
}

/// Most memory that this process has had, MB, where the system tells.
fn memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kilobytes.map_or("?".into(), |kilobytes| format!("{:.0}", kilobytes / 1000.0))
}
