//! Output folders as the command line leaves them: on a disk that is full, beside another writer, and
//! onto things that are no folders.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A motion that is refused at once: all there is to write is its draft.
const MOTION: &str =
    "name = \"still\"\nclass = \"1R\"\n[motion]\nkind = \"formula\"\nown_turn = \"0.2*sin(phi)\"\n";

fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().expect("a folder");
    fs::write(place.path().join("still.toml"), MOTION).expect("written");
    place
}

/// Runs `script` in `place`; `$0` is the program.
fn sh(place: &Path, script: &str) -> (Output, String) {
    let output = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_mpcgear")])
        .current_dir(place)
        .output()
        .expect("sh runs");
    let told = String::from_utf8(output.stderr.clone()).expect("text");
    (output, told)
}

fn listing(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|e| e.expect("an entry").file_name().to_string_lossy().into())
        .collect();
    names.sort();
    names
}

#[test]
fn a_full_disk_leaves_nothing_and_names_the_users_file() {
    let place = place();
    // Files of at most one block: writing ends as on a full disk.
    let full = "trap '' XFSZ; ulimit -f 1; exec \"$0\" design still.toml -o out";
    let (output, told) = sh(place.path(), full);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("out/design.json"), "{told}");
    assert!(!told.contains(".mpcgear-"), "{told}");
    assert_eq!(listing(place.path()), ["still.toml"]);
    // Over an earlier draft: it stays.
    sh(place.path(), "exec \"$0\" design still.toml -o out");
    sh(place.path(), "exec \"$0\" design still.toml -o out");
    let before = fs::read(place.path().join("out.draft/design.json")).expect("a draft");
    sh(place.path(), full);
    let after = fs::read(place.path().join("out.draft/design.json")).expect("the draft");
    assert_eq!(before, after);
    assert_eq!(listing(place.path()), ["out", "out.draft", "still.toml"]);
}

#[test]
fn the_second_writer_is_told() {
    let place = place();
    let lock = fs::File::create(place.path().join(".mpcgear-out.lock")).expect("made");
    lock.lock().expect("locked");
    let (output, told) = sh(place.path(), "exec \"$0\" design still.toml -o out");
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("another mpcgear is writing there"), "{told}");
    drop(lock);
    let (output, told) = sh(place.path(), "exec \"$0\" design still.toml -o out");
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert_eq!(listing(place.path()), ["out", "still.toml"]);
}

#[test]
fn what_is_no_folder_is_left_alone() {
    let place = place();
    sh(place.path(), "mkfifo pipe; ln -s /dev/null null");
    for out in ["pipe", "null", "still.toml", "/dev/null"] {
        let (output, told) = sh(
            place.path(),
            &format!("exec \"$0\" design still.toml -o {out}"),
        );
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(
            told.contains(out) && told.contains("is not a folder"),
            "{told}"
        );
    }
    assert_eq!(listing(place.path()), ["null", "pipe", "still.toml"]);
}

#[test]
fn links_in_a_folder_lead_nowhere() {
    let place = place();
    let victim = "mkdir elsewhere; echo mine > elsewhere/file; for i in 1 2; do \"$0\" design still.toml -o out; done;
        ln -sf ../elsewhere out.draft/meshes; ln -sf ../elsewhere/file out.draft/summary.json;
        exec \"$0\" design still.toml -o out";
    let (output, told) = sh(place.path(), victim);
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert_eq!(listing(&place.path().join("elsewhere")), ["file"]);
    let kept = fs::read_to_string(place.path().join("elsewhere/file")).expect("there");
    assert_eq!(kept, "mine\n");
    let summary = place.path().join("out.draft/summary.json");
    assert!(summary.symlink_metadata().expect("there").is_file());
}
