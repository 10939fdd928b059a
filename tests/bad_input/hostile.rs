//! Input that is large or strange on purpose: told in few lines, in bounded time and space.

use std::path::Path;

use mpcgear::motion::{MotionFile, starter};

use crate::{contains, error, message, refused, table_refused, uniform, with};

/// Asserts that the list of problems ends after twenty and says how many more there are.
fn cut_after_twenty(message: &str, all: usize) {
    contains(message, &[&format!("{all} problem(s)")]);
    assert!(
        message.ends_with(&format!("… and {} more", all - 20)),
        "{message}"
    );
    assert!(message.len() < 20_000, "{} bytes", message.len());
}

#[test]
fn a_hundred_thousand_unknown_keys() {
    let keys: String = (0..100_000).map(|i| format!("k{i} = 1\n")).collect();
    let found = message(&uniform(&format!("[gear]\n{keys}")));
    cut_after_twenty(&found, 100_000);
    contains(&found, &["line 5, gear.k0: unknown field"]);
}

#[test]
fn three_hundred_thousand_bad_keyframes() {
    let keyframes = ["{a=1}"; 300_000].join(",");
    let motion = format!("kind = \"keyframes\"\nkeyframes = [{keyframes}]");
    cut_after_twenty(&message(&with("3R", &motion, "")), 300_000);
    let keyframes = ["{phi_deg=1}"; 300_000].join(",");
    let motion = format!("kind = \"keyframes\"\nkeyframes = [{keyframes}]");
    cut_after_twenty(&message(&with("3R", &motion, "")), 299_999);
}

#[test]
fn tables_of_millions_of_rows() {
    table_refused(
        "1R",
        &"x\n".repeat(1_000_000),
        &["line 2: has 1 values", "… and ", " more"],
    );
    table_refused(
        "1R",
        &"0,0,0,0,1,0,0,0\n".repeat(1_000_000),
        &["poses.csv: the file has more than 100000 rows"],
    );
    table_refused(
        "1R",
        &format!("1,2\n{}\n", ",".repeat(3_000_000)),
        &["poses.csv line 2: has 3000000 characters, allowed 10000"],
    );
}

#[test]
fn values_of_a_million_letters() {
    let long = "x".repeat(1_000_000);
    for text in [
        uniform(&format!("[gear]\nteeth = \"{long}\"")),
        uniform(&format!("[gear]\n{long} = 1")),
        with("1R", &format!("kind = \"{long}\""), ""),
        with(
            "1R",
            &format!("kind = \"formula\"\nown_turn = \"{long}\""),
            "",
        ),
        with(
            "1R",
            &format!("kind = \"formula\"\nconstants = {{ {long} = \"1\" }}\nown_turn = \"q\""),
            "",
        ),
        with(&long, "kind = \"formula\"", ""),
    ] {
        assert!(message(&text).len() < 5_000, "{}", message(&text).len());
    }
}

#[test]
fn strange_keys_keep_their_lines() {
    for key in ["my key", "teeth[2]", "a.b", "é", ""] {
        let text = uniform(&format!("[gear]\nteeth = 10\n\"{key}\" = 1"));
        refused(&text, &["line 6, gear.", "unknown field"]);
    }
    let text = "class = \"1R\"\n\"my file\" = 1\n[motion]\nkind = \"formula\"\n";
    refused(text, &["line 2, \"my file\": unknown field"]);
    let constant = "kind = \"formula\"\nconstants = { \"my speed\" = \"1/\" }";
    refused(
        &with("1R", constant, ""),
        &["line 4, motion.constants.\"my speed\""],
    );
}

#[test]
fn names_that_files_cannot_hold() {
    let named = |name: &str| {
        let name = toml::Value::from(name);
        format!("name = {name}\n{}", uniform(""))
    };
    for (name, code) in [
        ("a\u{1}b", "U+0001 at letter 2"),
        ("\u{ffff}", "U+FFFF"),
        ("a\nb", "U+000A"),
    ] {
        refused(
            &named(name),
            &["line 1, name", code, "allowed are U+0020 to U+FFFD", "hint"],
        );
    }
    refused(
        &named(&"é".repeat(301)),
        &["line 1, name: has 301 letters, allowed 300"],
    );
    for name in ["é".repeat(300), "*/ echo(\"x\"); <b>&\u{1f600}".into()] {
        let (file, _) =
            MotionFile::parse(&named(&name), Path::new("my.toml"), Path::new(".")).unwrap();
        assert_eq!(file.name, name);
    }
    // The name of a file without one is held to the same.
    let text = starter(mpcgear::motion::Class::R1).replacen("name =", "# name =", 1);
    let file = MotionFile::parse(&text, Path::new("a\u{1}.toml"), Path::new("."));
    contains(&file.unwrap_err().to_string(), &["name: has U+0001"]);
}

#[cfg(unix)]
#[test]
fn tables_are_regular_files() {
    let folder = tempfile::tempdir().unwrap();
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path().join("pipe.csv"))
        .status();
    assert!(made.unwrap().success());
    for (name, kind) in [
        ("pipe.csv", "pipe or device"),
        ("/dev/zero", "pipe or device"),
        (".", "folder"),
    ] {
        let text = with("1R", &format!("kind = \"table\"\nfile = \"{name}\""), "");
        let found = error(&text, folder.path());
        assert_eq!(found.exit_code(), 2);
        contains(&found.to_string(), &["line 4, motion.file", kind]);
    }
}
