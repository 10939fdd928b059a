//! Exploring as users do it: trials, shards, study files, and the Python package's own tests.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

const BINARY: &str = env!("CARGO_BIN_EXE_mpcgear");

/// A motion that is drafted within a second.
const MOTION: &str = "class = \"1R\"\n[motion]\nkind = \"formula\"\nown_turn = \"-phi + a*sin(phi)\"\n\
    constants = { a = \"0.1\" }\n[search]\neffort = 0.05\n";

const STUDY: &str = "[variables]\n\"gear.center_distance_mm\" = { low = 24.0, high = 30.0, step = 0.5 }\n\
    \"motion.constants.a\" = { low = 0.0, high = 0.2 }\n\"load.driver_material\" = { choices = [\"PLA\", \"PA12\"] }\n\
    [objectives]\nplastic_g = \"down\"\nq_star_min = \"up\"\n[constraints]\nheight_mm = { most = 200 }\n\
    [budget]\ntrials = 4\nkeep = 0.25\n";

/// The study of such a folder.
const EXPLORE: [&str; 5] = ["explore", "my.toml", "study.toml", "-o", "study"];

/// A folder with `my.toml` and `study.toml`.
fn folder(study: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my.toml"), MOTION).unwrap();
    fs::write(folder.path().join("study.toml"), study).unwrap();
    folder
}

fn mpcgear(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(BINARY);
    command
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null());
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    mpcgear(folder, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The answer of a command with `--json` that has to succeed.
fn answer(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, &[&["--json"], arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// What standard error says of a command that has to end with exit code 2.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    told
}

#[test]
fn a_trial_is_computed_once_and_says_what_came_of_it() {
    let folder = folder(STUDY);
    let one = [
        "trial",
        "my.toml",
        "--set",
        "gear.center_distance_mm=26",
        "--into",
        "trials",
        "--draft",
    ];
    let first = answer(folder.path(), &one);
    assert_eq!(first["state"], "complete", "{first}");
    assert_eq!(first["reused"], false);
    for figure in ["plastic_g", "height_mm", "print_h", "q_min"] {
        assert!(first["figures"][figure].as_f64().unwrap() > 0.0, "{figure}");
    }
    assert_eq!(
        first["figures"]["payload_g"], 1e6,
        "weight does not load a gear that turns about z"
    );
    let mut again = answer(folder.path(), &one);
    assert_eq!(again["reused"], true);
    again["reused"] = false.into();
    assert_eq!(again, first);
    // Written otherwise it is the same trial; another value is another.
    let with = |value: &str| {
        let set = format!("gear.center_distance_mm={value}");
        answer(
            folder.path(),
            &[
                "trial", "my.toml", "--set", &set, "--into", "trials", "--draft",
            ],
        )
    };
    assert_eq!(with("26.0")["reused"], true);
    assert_eq!(with("27")["reused"], false);
}

#[test]
fn a_draft_that_carries_a_weight_has_every_figure_but_the_wall_of_the_proof() {
    let folder = tempfile::tempdir().unwrap();
    let tray = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/studies/tray_800g/motion.toml");
    let tray = tray.to_str().unwrap();
    // Of each kind of variable one that differs from the default.
    let set = [
        "gear.center_distance_mm=27",
        "gear.teeth=9",
        "gear.contact_ratio=1.4",
        "gear.sub_gear_pairs=4",
        "gear.tooth_thickness_mm=1.9",
        "gear.tip_mm=0.8",
        "gear.root_mm=0.5",
        "fit.clearance_mm=0.09",
        "load.driver_material=\"PA12\"",
        "load.point_mm[2]=55",
        "motion.constants.dip=0.04",
    ];
    let set = set.iter().flat_map(|change| ["--set", change]);
    let arguments: Vec<&str> = ["trial", tray, "--into", "trials", "--draft"]
        .into_iter()
        .chain(set)
        .collect();
    let made = answer(folder.path(), &arguments);
    assert_eq!(made["state"], "complete", "{made}");
    assert_eq!(made["set"].as_object().unwrap().len(), 11);
    let figures = made["figures"].as_object().unwrap();
    for (name, figure) in figures {
        let there = figure.as_f64().is_some_and(|value| value > 0.0);
        assert_eq!(there, name != "wall_min_mm", "{name} is {figure}");
    }
    assert_eq!(figures["bands"], 4.0);
    let number = |name: &str| figures[name].as_f64().unwrap();
    let sides = number("width_mm") * number("depth_mm") * number("height_mm");
    assert!((number("box_cm3") - 1e-3 * sides).abs() < 1e-9 * sides);
    // Driver and frame of PA12 (1.01 g/cm³), follower of PLA (1.24 g/cm³).
    let density = number("plastic_g") / number("plastic_cm3");
    assert!((1.01..1.24).contains(&density), "{density}");
    assert!(number("sag_mm") <= number("play_mm") && number("efficiency") < 1.0);
}

#[test]
fn what_cannot_be_computed_is_recorded_and_not_tried_again() {
    let folder = folder(STUDY);
    let with = |more: &[&str]| {
        let trial = ["trial", "my.toml", "--into", "trials", "--draft"];
        answer(folder.path(), &[&trial, more].concat())
    };
    let slow = with(&["--timeout", "0.001"]);
    assert_eq!(slow["state"], "poisoned");
    assert_eq!(slow["reason"], "took longer than 0.001 s");
    assert_eq!(with(&[])["reused"], true, "it is not tried again");
    let set = ["--set", "gear.center_distance_mm=25.5"];
    let small = with(&[&set[..], &["--memory-mb", "30"]].concat());
    assert_eq!(small["state"], "poisoned", "{small}");
    assert!(
        small["reason"].as_str().unwrap().contains("crashed"),
        "{small}"
    );
    let refused = with(&[
        "--set",
        "gear.teeth=60",
        "--set",
        "gear.tooth_thickness_mm=6",
    ]);
    assert_eq!(refused["state"], "infeasible", "{refused}");
    assert!(
        refused["reason"].as_str().unwrap().contains("refused"),
        "{refused}"
    );
}

#[test]
fn two_processes_compute_a_trial_once() {
    let folder = folder(STUDY);
    let spawn = || {
        let arguments = ["--json", "trial", "my.toml", "--into", "trials", "--draft"];
        mpcgear(folder.path(), &arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let [one, two] = [spawn(), spawn()].map(|child| child.wait_with_output().unwrap());
    let [one, two]: [Value; 2] = [one, two].map(|o| serde_json::from_slice(&o.stdout).unwrap());
    assert_eq!(one["state"], "complete");
    // Both tell of the same computation.
    assert_eq!(one["seconds"], two["seconds"]);
}

#[test]
fn shards_share_the_trials_and_need_no_python() {
    let folder = folder(STUDY);
    let shard = |part: &str| answer(folder.path(), &[&EXPLORE[..], &["--shard", part]].concat());
    let (one, two) = (shard("0/3"), shard("1/3"));
    assert_eq!((&one["trials"], &two["trials"]), (&2.into(), &1.into()));
    assert_eq!(shard("2/3")["trials"], 1);
    assert_eq!(
        fs::read_dir(folder.path().join("study/trials"))
            .unwrap()
            .count(),
        4
    );
    let again = shard("0/1");
    assert_eq!((&again["trials"], &again["reused"]), (&4.into(), &4.into()));
}

#[test]
fn a_bad_study_is_told_whole_and_leaves_nothing() {
    let folder = folder(
        "[variables]\n\"gear.tooth\" = { low = 8, high = 12 }\n\"gear.teeth\" = { low = 2, high = 12 }\n\
         [objectives]\nplastik_g = \"down\"\n[budget]\nkeep = 2\n",
    );
    let told = refused(folder.path(), &EXPLORE);
    for part in [
        "study.toml: 5 problem(s)",
        "line 2",
        "did you mean `teeth`?",
        "gear.teeth=2: is 2, allowed 3 to 60",
        "did you mean `plastic_g`?",
        "has neither trials nor minutes",
        "budget.keep: is 2",
    ] {
        assert!(told.contains(part), "{part:?} is not in:\n{told}");
    }
    assert!(!folder.path().join("study").exists());
}

#[test]
fn a_study_keeps_its_folder() {
    let folder = folder(STUDY);
    let shard = [&EXPLORE[..], &["--shard", "3/4"]].concat();
    answer(folder.path(), &shard);
    fs::write(
        folder.path().join("study.toml"),
        STUDY.replace("trials = 4", "trials = 8"),
    )
    .unwrap();
    answer(folder.path(), &shard);
    fs::write(
        folder.path().join("study.toml"),
        STUDY.replace("high = 0.2", "high = 0.3"),
    )
    .unwrap();
    let told = refused(folder.path(), &shard);
    assert!(told.contains("belongs to another study"), "{told}");
}

#[test]
fn a_missing_python_package_is_named_with_the_way_to_get_it() {
    let folder = folder(STUDY);
    let output = mpcgear(folder.path(), &EXPLORE)
        .env("MPCGEAR_PYTHON", "no-such-python")
        .output()
        .unwrap();
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(
        told.contains("pip install \".[explore]\"") && told.contains("--shard"),
        "{told}"
    );
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_named_and_the_trial_is_made_later() {
    let folder = folder(STUDY);
    // Files of at most 512 bytes are as good as a full disk for a record.
    let script =
        format!("trap '' XFSZ; ulimit -f 1; exec {BINARY:?} trial my.toml --into trials --draft");
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(
        told.contains("trials") && told.contains("File too large"),
        "{told}"
    );
    let made = answer(
        folder.path(),
        &["trial", "my.toml", "--into", "trials", "--draft"],
    );
    assert_eq!(
        (&made["state"], &made["reused"]),
        (&"complete".into(), &false.into())
    );
}

/// What the tests of the Python packages need.
const MISSING: &str =
    "optuna, optuna-dashboard, distributed, pandas, pyarrow or pytest is not installed";

/// Python with the packages of the extra `explore` and pytest. Without it the tests that need it are skipped,
/// unless MPCGEAR_REQUIRE_CAD=1.
fn python() -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/python/bin/python3");
    let python = std::env::var_os("MPCGEAR_PYTHON").map_or(own, PathBuf::from);
    let look = [
        "-c",
        "import optuna, optuna_dashboard, distributed, pandas, pyarrow, pytest",
    ];
    let found = Command::new(&python).args(look).output();
    let found = found.is_ok_and(|output| output.status.success());
    let required = std::env::var("MPCGEAR_REQUIRE_CAD").is_ok_and(|v| v == "1");
    assert!(found || !required, "{MISSING}");
    if !found {
        eprintln!("skipped: {MISSING}");
    }
    found.then_some(python)
}

/// The packages of this repository.
fn packages() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("python")
}

/// What `explore` answers in such a folder with the packages of this repository.
fn explored(folder: &Path, python: &Path, more: &[&str]) -> Value {
    let output = mpcgear(folder, &[&["--json"], &EXPLORE[..], more].concat())
        .env("MPCGEAR_PYTHON", python)
        .env("PYTHONPATH", packages())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_study_ends_with_designs_that_are_proved_and_a_report() {
    let Some(python) = python() else { return };
    let folder = folder(STUDY);
    let told = explored(folder.path(), &python, &["--workers", "2"]);
    assert_eq!(told["trials"], serde_json::json!([4, 1]));
    let pick = &told["picks"][0];
    assert!(
        pick["tolerances"]["works"].as_f64().unwrap() > 0.9,
        "{pick}"
    );
    let made = folder.path().join(pick["folder"].as_str().unwrap());
    let summary = fs::read(made.join("summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    assert_eq!(summary["feasible"], true);
    for path in [
        "study/report.html",
        "study/study.csv",
        "study/study.parquet",
    ] {
        assert!(folder.path().join(path).is_file(), "{path}");
    }
    assert!(made.join("report.html").is_file());
}

#[test]
fn a_study_passes_over_trials_that_take_too_long() {
    let Some(python) = python() else { return };
    let folder = folder(&format!("{STUDY}[limits]\ndraft_s = 0.1\n"));
    let told = explored(folder.path(), &python, &[]);
    assert_eq!(told["trials"], serde_json::json!([4, 0]));
    let table = fs::read_to_string(folder.path().join("study/study.csv")).unwrap();
    let slow = table
        .lines()
        .filter(|line| line.contains("took longer than 0.1 s"));
    assert_eq!(slow.count(), 4, "{table}");
}

#[test]
fn the_python_packages_pass_their_tests() {
    let Some(python) = python() else { return };
    let output = Command::new(python)
        .args([
            "-m",
            "pytest",
            "-q",
            "-p",
            "no:cacheprovider",
            "python/tests",
        ])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("MPCGEAR_BINARY", BINARY)
        .output()
        .unwrap();
    let told = text(&output.stdout);
    assert!(output.status.success(), "{told}\n{}", text(&output.stderr));
    assert!(
        told.contains(" passed") && !told.contains("skipped"),
        "{told}"
    );
}
