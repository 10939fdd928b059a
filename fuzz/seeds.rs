//! The good input that hostile input is made of: the shipped examples and `seeds`.

use std::path::{Path, PathBuf};

/// Seeds of a target, sorted by file name.
pub fn of(target: &str) -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (folder, extension) = match target {
        "motion" => (root.join("examples"), "toml"),
        "csv" => (root.join("examples"), "csv"),
        target => (root.join("fuzz/seeds").join(target), ""),
    };
    let fits =
        |path: &PathBuf| extension.is_empty() || path.extension().is_some_and(|e| e == extension);
    read(&folder, fits)
}

/// Input that broke a target once, or is built like input that did.
#[allow(dead_code)] // the benchmark has no use for it
pub fn known(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/known");
    read(&folder.join(target), |_| true)
}

fn read(folder: &Path, fits: impl Fn(&PathBuf) -> bool) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(fits)
        .collect();
    paths.sort();
    assert!(!paths.is_empty(), "{} is empty", folder.display());
    let read =
        |path: &PathBuf| std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    paths.iter().map(read).collect()
}
