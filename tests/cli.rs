//! The compiled command as users call it: exit codes, what is printed where, what is written.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Output, Stdio};

use mpcgear::motion::{Class, MotionFile};
use serde_json::Value;
use tempfile::TempDir;

const BINARY: &str = env!("CARGO_BIN_EXE_mpcgear");
const UNIFORM: &str = "class = \"1R\"\n[motion]\nkind = \"formula\"\n";

/// A folder with a motion file `my.toml` in it.
fn folder(motion: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my.toml"), motion).unwrap();
    folder
}

/// Runs `mpcgear` in `folder`.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = assert_cmd::Command::new(BINARY);
    command
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Names in `folder`, sorted.
fn entries(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn summary(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap()).unwrap()
}

fn problems(summary: &Value) -> String {
    summary["problems"].to_string()
}

/// Runs `arguments` in `folder` and asserts exit code 2, a message with all `parts` on standard error,
/// nothing on standard output, and that no file or folder appeared.
fn refused(folder: &Path, arguments: &[&str], parts: &[&str]) {
    let before = entries(folder);
    let output = run(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(text(&output.stdout), "", "{arguments:?}");
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in:\n{message}");
    }
    assert_eq!(entries(folder), before, "{arguments:?}");
}

/// Asserts that designing `motion` is refused with all `parts`.
fn bad_motion(motion: &str, parts: &[&str]) {
    refused(
        folder(motion).path(),
        &["design", "my.toml", "-o", "out"],
        parts,
    );
}

/// Asserts that designing a table of `rows` of class 1R1T is refused with all `parts`.
fn bad_table(rows: &[[f64; 8]], parts: &[&str]) {
    let folder = folder("class = \"1R1T\"\n[motion]\nkind = \"table\"\nfile = \"poses.csv\"\n");
    let lines = rows
        .iter()
        .map(|r| r.map(|v| v.to_string()).join(",") + "\n");
    let csv = "phi_deg,x,y,z,qw,qx,qy,qz\n".to_owned() + &lines.collect::<String>();
    fs::write(folder.path().join("poses.csv"), csv).unwrap();
    refused(folder.path(), &["design", "my.toml", "-o", "out"], parts);
}

/// A uniform turn in steps of 10°, edited.
fn table(edit: impl Fn(&mut Vec<[f64; 8]>)) -> Vec<[f64; 8]> {
    let row = |i: u32| {
        let half = -f64::from(i).to_radians() * 5.0;
        [
            f64::from(10 * i),
            0.0,
            0.0,
            0.0,
            half.cos(),
            0.0,
            0.0,
            half.sin(),
        ]
    };
    let mut rows = (0..=36).map(row).collect();
    edit(&mut rows);
    rows
}

#[test]
fn bad_files_are_refused() {
    let design = ["design", "my.toml", "-o", "out"];
    let empty = tempfile::tempdir().unwrap();
    refused(empty.path(), &design, &["my.toml", "No such file"]);
    bad_motion("class = 1R", &["my.toml", "line 1", "not TOML"]);
    bad_motion(
        &format!("{UNIFORM}[gear]\ntooth = 12\n"),
        &["line 5, gear.tooth: unknown field", "did you mean `teeth`?"],
    );
    bad_motion(
        &UNIFORM.replace("1R", "2R"),
        &["line 1, class", "2R", "\"1R1T\""],
    );
    let huge = folder("");
    let file = fs::File::create(huge.path().join("my.toml")).unwrap();
    file.set_len(100_000_000).unwrap(); // sparse: takes no room
    refused(huge.path(), &design, &["100 MB", "allowed 4 MB"]);
}

#[test]
fn bad_tables_are_refused() {
    bad_table(&table(|rows| rows.truncate(5)), &["5 rows, at least 8"]);
    bad_table(
        &table(|rows| rows.swap(7, 8)),
        &["poses.csv row 9", "does not increase"],
    );
    bad_table(
        &table(|rows| rows[7][3] = f64::NAN),
        &["poses.csv line 9", "z is `NaN`"],
    );
    bad_table(&table(|rows| rows[7][4] = f64::INFINITY), &["qw is `inf`"]);
    bad_table(
        &table(|rows| rows[7][4..].fill(0.0)),
        &["row 8", "length zero"],
    );
    bad_table(
        &table(|rows| rows[36][3] = 1.0),
        &["does not close", "1.0000 mm"],
    );
    bad_table(
        &table(|rows| rows[9][3] = 8.0),
        &["row 9 to", "jump between rows", "8.00 mm"],
    );
}

#[test]
fn bad_settings_are_refused() {
    for (field, parts) in [
        ("teeth = 2", ["gear.teeth", "allowed 3 to 60"]),
        ("contact_ratio = 1.0", ["gear.contact_ratio", "more than 1"]),
        (
            "tooth_thickness_mm = 0",
            ["gear.tooth_thickness_mm", "is 0"],
        ),
        (
            "center_distance_mm = -25",
            ["gear.center_distance_mm", "is -25"],
        ),
        ("tip_mm = nan", ["gear.tip_mm", "is NaN"]),
        ("root_mm = inf", ["gear.root_mm", "is inf"]),
        (
            "teeth = 60\nsub_gear_pairs = 12",
            ["gear.sub_gear_pairs", "more than 480 teeth"],
        ),
        ("root_mm = 13.0", ["gear.root_mm", "is 13"]),
        (
            "[support]\nscrew_hole_diameter_mm = 6.0",
            ["support.screw_hole_diameter_mm", "allowed 1.6 to 5"],
        ),
        (
            "[support]\npin_radius_mm = 1.5",
            ["support.pin_radius_mm", "at least 0.4 mm are needed"],
        ),
    ] {
        bad_motion(&format!("{UNIFORM}[gear]\n{field}\n"), &parts);
    }
    let folder = folder(UNIFORM);
    let with = |more: [&str; 2], parts: &[&str]| {
        let [option, value] = more;
        refused(
            folder.path(),
            &["design", "my.toml", "-o", "out", option, value],
            parts,
        );
    };
    with(
        ["--effort", "0"],
        &["command line", "search.effort", "is 0"],
    );
    with(
        ["--max-time", "nan"],
        &["command line", "search.time_limit_s", "NaN"],
    );
    with(["--method", "fast"], &["--method", "exact", "paper"]);
    with(["--colour", "red"], &["--colour"]);
}

#[test]
fn folders_that_cannot_be_written_are_refused_before_the_search() {
    let folder = folder(UNIFORM);
    fs::write(folder.path().join("way"), "").unwrap();
    for out in ["way", "way/below"] {
        refused(
            folder.path(),
            &["design", "my.toml", "-o", out],
            &["way is not a folder"],
        );
    }
    // A folder of somebody else that has one of our names in it.
    fs::create_dir_all(folder.path().join("theirs/meshes")).unwrap();
    let design = ["design", "my.toml", "-o", "theirs"];
    refused(folder.path(), &design, &["has `meshes` but no design.json"]);
    // The draft of a failed run would have no place.
    fs::create_dir(folder.path().join("old")).unwrap();
    fs::write(folder.path().join("old/design.json"), "").unwrap();
    fs::write(folder.path().join("old.draft"), "").unwrap();
    let design = ["design", "my.toml", "-o", "old"];
    refused(folder.path(), &design, &["old.draft is not a folder"]);
    // Read-only even for root.
    if cfg!(target_os = "linux") {
        let design = ["design", "my.toml", "-o", "/proc/out"];
        refused(
            folder.path(),
            &design,
            &["/proc/out", "nothing can be written in /proc"],
        );
    }
}

#[test]
fn new_writes_a_good_file_of_every_class_and_leaves_old_files_alone() {
    let folder = tempfile::tempdir().unwrap();
    for class in Class::ALL {
        let name = format!("{class}.toml");
        let output = run(
            folder.path(),
            &["new", "--class", &class.to_string(), &name],
        );
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains(&format!("{name} written")));
        let (file, motion) = MotionFile::read(&folder.path().join(&name)).unwrap();
        assert_eq!((file.class, motion.class()), (class, class));
    }
    fs::write(folder.path().join("1R.toml"), "mine").unwrap();
    refused(
        folder.path(),
        &["new", "--class", "1R", "1R.toml"],
        &["1R.toml", "exists already"],
    );
    assert_eq!(
        fs::read_to_string(folder.path().join("1R.toml")).unwrap(),
        "mine"
    );
    refused(
        folder.path(),
        &["new", "--class", "2R", "a.toml"],
        &["`2R`", "1R1T"],
    );
    refused(folder.path(), &["new", "a.toml"], &["--class"]);
    refused(
        folder.path(),
        &["new", "--class", "3R", "no/a.toml"],
        &["there is no folder no"],
    );
}

#[test]
fn examples_are_written_as_they_are_and_others_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), &["new", "--example", "trefoil", "my.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let written = fs::read_to_string(folder.path().join("my.toml")).unwrap();
    assert_eq!(written, include_str!("../examples/trefoil.toml"));
    for name in mpcgear::motion::examples::names() {
        let example = mpcgear::motion::examples::example(name).unwrap();
        assert!(
            MotionFile::parse(example, Path::new(name), folder.path()).is_ok(),
            "{name}"
        );
    }
    refused(
        folder.path(),
        &["new", "--example", "quatrefoil", "a.toml"],
        &["trefoil"],
    );
    refused(
        folder.path(),
        &["new", "--example", "trefoil", "--class", "3R", "a.toml"],
        &["--class"],
    );
}

#[test]
fn programs_are_told_of_progress_in_lines_of_json() {
    let folder = folder(UNIFORM);
    let arguments = [
        "--json",
        "design",
        "my.toml",
        "-o",
        "out",
        "--effort",
        "0.1",
        "--progress",
    ];
    let output = run(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let lines = text(&output.stderr);
    let lines: Vec<Value> = lines
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    let done = |l: &Value| l["done"].as_f64().is_some_and(|d| (0.0..=1.0).contains(&d));
    assert!(lines.len() > 2 && lines.iter().all(done), "{lines:?}");
    let seconds: Vec<f64> = lines.iter().filter_map(|l| l["seconds"].as_f64()).collect();
    assert!(
        seconds.is_sorted() && seconds.len() == lines.len(),
        "{lines:?}"
    );
    let best = lines
        .iter()
        .filter_map(|l| l["best_hold"].as_f64())
        .next_back();
    assert!(best.is_some_and(|q| q > 5.0), "{lines:?}");
}

#[test]
fn errors_are_json_where_that_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), &["--json", "design", "my.toml", "-o", "out"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(text(&output.stdout), "");
    let error: Value = serde_json::from_slice(&output.stderr).unwrap();
    assert_eq!(error["exit_code"], 2);
    assert!(error["error"].as_str().unwrap().contains("my.toml"));
}

#[test]
fn a_motion_that_no_gear_makes_leaves_a_draft_and_says_why() {
    // Refused while reading: turns the wrong way. Refused by the search: leans by 50°.
    let backwards = format!("{UNIFORM}own_turn = \"phi\"\n");
    let leaning = "class = \"3R\"\n[motion]\nkind = \"formula\"\n\
        rotation = [\"50*deg*sin(phi)\", \"0\", \"0\"]\n[search]\neffort = 0.02\n";
    for (motion, reason) in [
        (backwards.as_str(), "net turn"),
        (leaning, "candidate bands is usable"),
    ] {
        let folder = folder(motion);
        let output = run(folder.path(), &["--json", "design", "my.toml", "-o", "out"]);
        assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
        let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
        let error: Value = serde_json::from_slice(&output.stderr).unwrap();
        assert!(error["error"].as_str().unwrap().contains(reason), "{error}");
        let written = summary(&folder.path().join("out"));
        assert_eq!(written, printed);
        assert_eq!(written["feasible"], false);
        assert!(problems(&written).contains(reason), "{written}");
        assert!(folder.path().join("out/design.json").exists());
        assert_eq!(entries(folder.path()), ["my.toml", "out"]);
    }
}

#[test]
fn a_design_survives_a_failed_run_into_its_folder() {
    let folder = folder(&format!("{UNIFORM}[search]\neffort = 0.1\n"));
    let output = run(folder.path(), &["--json", "design", "my.toml", "-o", "out"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "progress is for people");
    let out = folder.path().join("out");
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        printed,
        summary(&out),
        "exactly one document, the same as in the file"
    );
    assert_eq!(printed["feasible"], true);
    assert_eq!(printed["stopped"], false);
    for name in [
        "poses.csv",
        "parts.md",
        "report.html",
        "meshes/driver.stl",
        "print",
        "openscad",
    ] {
        assert!(out.join(name).exists(), "{name}");
    }

    let design = fs::read(out.join("design.json")).unwrap();
    let all = entries(&out);
    fs::write(
        folder.path().join("my.toml"),
        format!("{UNIFORM}own_turn = \"phi\"\n"),
    )
    .unwrap();
    let failed = run(folder.path(), &["design", "my.toml", "-o", "out"]);
    assert_eq!(failed.status.code(), Some(3));
    assert!(
        text(&failed.stdout).contains("out.draft"),
        "{}",
        text(&failed.stdout)
    );
    assert_eq!(summary(&folder.path().join("out.draft"))["feasible"], false);
    assert_eq!(fs::read(out.join("design.json")).unwrap(), design);
    assert_eq!(entries(&out), all);
    assert_eq!(entries(folder.path()), ["my.toml", "out", "out.draft"]);
}

#[test]
fn a_run_that_is_out_of_time_leaves_a_draft_and_quiet_says_nothing_but_the_error() {
    let folder = folder(UNIFORM);
    let limited = [
        "--quiet",
        "design",
        "my.toml",
        "-o",
        "out",
        "--max-time",
        "0.001",
    ];
    let output = run(folder.path(), &limited);
    assert_eq!(text(&output.stdout), "");
    let summary = summary(&folder.path().join("out"));
    assert_eq!(summary["stopped"], true);
    assert_eq!(summary["feasible"], false);
    assert_eq!(output.status.code(), Some(3));
    let said = summary["problems"].to_string();
    assert!(said.contains("stopped before") || said.contains("the time limit ended the search"));
}

#[test]
fn a_first_look_has_bodies_and_figures_and_no_proof() {
    let folder = folder(UNIFORM);
    let look = ["design", "my.toml", "-o", "out", "--draft"];
    let output = run(folder.path(), &look);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("first look, not proved"));
    assert!(text(&output.stdout).ends_with("next: look at the bodies in out/meshes\n"));
    let out = folder.path().join("out");
    let first = summary(&out);
    assert_eq!(first["draft"], true);
    assert_eq!(first["feasible"], false);
    assert_eq!(first["k"], 2);
    assert!(first["q_min"].as_f64().unwrap() > 5.0);
    assert!(first["escapes"].is_null());
    assert!(out.join("meshes/follower.stl").exists());
    let design = fs::read(out.join("design.json")).unwrap();
    // A second look replaces the first and is the same; one beside a design leaves the design alone.
    assert_eq!(run(folder.path(), &look).status.code(), Some(0));
    assert!(design == fs::read(out.join("design.json")).unwrap());
    assert_eq!(entries(folder.path()), ["my.toml", "out"]);
    let finished = fs::read_to_string(out.join("summary.json")).unwrap();
    let finished = finished.replace("\"draft\": true", "\"draft\": false");
    fs::write(out.join("summary.json"), &finished).unwrap();
    assert_eq!(run(folder.path(), &look).status.code(), Some(0));
    assert_eq!(
        fs::read_to_string(out.join("summary.json")).unwrap(),
        finished
    );
    assert_eq!(entries(folder.path()), ["my.toml", "out", "out.draft"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_best_so_far_beside_an_older_design() {
    let folder = folder(UNIFORM);
    fs::create_dir(folder.path().join("out")).unwrap();
    fs::write(folder.path().join("out/design.json"), "older").unwrap();
    let mut child = std::process::Command::new(BINARY)
        .current_dir(folder.path())
        .args(["design", "my.toml", "-o", "out"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let polishing = lines.any(|line| line.unwrap().contains("polish"));
    assert!(polishing, "the stage is told where there is no terminal");
    let kill = format!("kill -INT {}", child.id());
    assert!(
        std::process::Command::new("sh")
            .args(["-c", &kill])
            .status()
            .unwrap()
            .success()
    );
    let rest: Vec<String> = lines.map(|line| line.unwrap()).collect();
    let mut said = String::new();
    child
        .stdout
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said}{rest:?}");
    assert!(
        said.contains("stopped early") && said.contains("out.draft"),
        "{said}"
    );
    let draft = folder.path().join("out.draft");
    let summary = summary(&draft);
    assert_eq!(summary["stopped"], true);
    assert_eq!(summary["feasible"], false);
    assert!(
        problems(&summary).contains("stopped before the proof"),
        "{summary}"
    );
    assert!(draft.join("meshes/driver.stl").exists());
    assert_eq!(
        fs::read_to_string(folder.path().join("out/design.json")).unwrap(),
        "older"
    );
    assert_eq!(entries(&folder.path().join("out")), ["design.json"]);
}

#[test]
fn bash_completes_commands_and_man_has_a_page_for_each() {
    let folder = tempfile::tempdir().expect("folder");
    let script = run(folder.path(), &["completions", "bash"]);
    assert!(script.status.success());
    std::fs::write(folder.path().join("mpcgear.bash"), &script.stdout).expect("script");
    let asks = "source ./mpcgear.bash; COMP_WORDS=(mpcgear de); COMP_CWORD=1; \
                _mpcgear mpcgear de mpcgear; echo ${COMPREPLY[@]}";
    let answer = std::process::Command::new("bash")
        .args(["--norc", "-c", asks])
        .current_dir(folder.path())
        .output()
        .expect("bash");
    assert_eq!(
        text(&answer.stdout).trim(),
        "design",
        "{}",
        text(&answer.stderr)
    );

    assert!(run(folder.path(), &["man", "."]).status.success());
    for (page, says) in [
        ("mpcgear.1", "mpcgear\\-design(1)"),
        ("mpcgear-design.1", "\\-\\-max\\-time"),
        ("mpcgear-motion-show.1", "Motion file"),
    ] {
        let page = std::fs::read_to_string(folder.path().join(page)).expect(page);
        assert!(page.contains(says), "{page}");
    }
    refused(folder.path(), &["man", "nowhere"], &["nowhere"]);
}
