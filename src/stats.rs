//! The table of many designs: what came out, how long it took, how large it is.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::design::{Design, Stored};
use crate::export::figures::{ClosureFigures, rounded};
use crate::export::{stl, tables};
use crate::solid::Mesh;
pub use crate::table::{Format, Table};
use crate::{Error, Problem, Result};

/// One design as found on disk.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Its `design.json`.
    pub path: PathBuf,
    /// The design.
    pub design: Design,
    /// Seconds it took; `None` without `summary.json`.
    pub seconds: Option<f64>,
    /// Whether it was proven to work; `None` without `summary.json`.
    pub feasible: Option<bool>,
    /// Triangles of all meshes; `None` without meshes.
    pub triangles: Option<usize>,
    /// Volume of driver and follower, mm³; `None` without their meshes.
    pub volume: Option<f64>,
}

/// What of `summary.json` the table shows.
#[derive(Debug, Default, Deserialize)]
struct Summary {
    feasible: Option<bool>,
    wall_seconds: Option<f64>,
}

/// Finds designs: a `design.json`, a folder with one, or a folder of such folders (sorted by name).
///
/// # Errors
/// [`Error::Io`] for a path that cannot be read, [`Error::Input`] for a file that is no design or a
/// folder without any.
pub fn collect(paths: &[PathBuf]) -> Result<Vec<Entry>> {
    let mut entries = Vec::new();
    for path in paths {
        if !path.is_dir() || path.join("design.json").exists() {
            entries.push(entry(path)?);
        } else {
            let mut inside: Vec<PathBuf> = std::fs::read_dir(path)
                .map_err(Error::io(path))?
                .filter_map(|item| Some(item.ok()?.path().join("design.json")))
                .filter(|file| file.is_file())
                .collect();
            inside.sort();
            if inside.is_empty() {
                return Err(not_a_design(
                    path,
                    "holds no design.json, nor does a folder in it".into(),
                ));
            }
            for file in inside {
                entries.push(entry(&file)?);
            }
        }
    }
    Ok(entries)
}

fn not_a_design(path: &Path, what: String) -> Error {
    Error::Input {
        file: path.into(),
        problems: vec![Problem {
            place: "design.json".into(),
            what,
            hint: "give the output folder of `mpcgear design`".into(),
        }]
        .into(),
    }
}

fn entry(path: &Path) -> Result<Entry> {
    let Stored { file, design, .. } = Stored::read(path)?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let summary: Summary = match std::fs::read(folder.join("summary.json")) {
        Ok(text) => serde_json::from_slice(&text)
            .map_err(|e| not_a_design(&folder.join("summary.json"), e.to_string()))?,
        Err(_) => Summary::default(),
    };
    let mesh = |name: &str| stl::read(&folder.join("meshes").join(format!("{name}.stl"))).ok();
    let meshes: Vec<Mesh> = ["driver", "follower", "support", "slider"]
        .into_iter()
        .filter_map(mesh)
        .collect();
    Ok(Entry {
        path: file,
        design,
        seconds: summary.wall_seconds,
        feasible: summary.feasible,
        triangles: (!meshes.is_empty()).then(|| meshes.iter().map(|m| m.triangles.len()).sum()),
        volume: (meshes.len() >= 2).then(|| meshes[..2].iter().map(Mesh::volume).sum()),
    })
}

/// The statistics table of `entries`.
pub fn table(entries: &[Entry]) -> Table {
    let optional = |x: Option<f64>, digits: usize| x.map_or("–".into(), |x| rounded(x, digits));
    let row = |e: &Entry| {
        let d = &e.design;
        let closure = ClosureFigures::of(d);
        let figure = |get: fn(&ClosureFigures) -> f64, digits: usize| {
            optional(closure.as_ref().map(get), digits)
        };
        vec![
            d.name.clone(),
            d.class.to_string(),
            d.sub_gear_pairs.len().to_string(),
            tables::teeth(d),
            figure(|c| c.q_min, 3),
            figure(|c| c.q_mean, 3),
            figure(|c| c.q_star_min, 3),
            figure(|c| c.eta_min, 2),
            figure(|c| 100.0 * c.valid_time, 3),
            e.feasible
                .map_or("–", |yes| if yes { "yes" } else { "no" })
                .into(),
            optional(e.seconds, 2),
            e.triangles.map_or("–".into(), |t| t.to_string()),
            optional(e.volume.map(|v| v / 1000.0), 3),
        ]
    };
    let columns = [
        "design",
        "class",
        "K",
        "J",
        "min Q",
        "mean Q",
        "min Q*",
        "min η",
        "held %",
        "works",
        "time s",
        "triangles",
        "volume cm³",
    ];
    Table {
        columns: columns.map(String::from).to_vec(),
        names: 2,
        rows: entries.iter().map(row).collect(),
    }
}
