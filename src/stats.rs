//! The table of many designs: what came out, how long it took, how large it is.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::design::Design;
use crate::export::figures::{ClosureFigures, rounded};
use crate::export::stl;
use crate::solid::Mesh;
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

/// How the table is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Format {
    /// Columns in line, for terminals.
    #[default]
    Text,
    /// Comma separated, with a header line.
    Csv,
    /// A Markdown table.
    Markdown,
}

/// A table of text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Headings.
    pub columns: Vec<&'static str>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<String>>,
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
        if path.is_file() {
            entries.push(entry(path)?);
        } else if path.join("design.json").is_file() {
            entries.push(entry(&path.join("design.json"))?);
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
        }],
    }
}

fn entry(path: &Path) -> Result<Entry> {
    let text = std::fs::read(path).map_err(Error::io(path))?;
    let design: Design =
        serde_json::from_slice(&text).map_err(|e| not_a_design(path, e.to_string()))?;
    let folder = path.parent().unwrap_or(Path::new("."));
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
        path: path.into(),
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
            d.settings.gear.teeth.to_string(),
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
    Table {
        columns: vec![
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
        ],
        rows: entries.iter().map(row).collect(),
    }
}

impl Table {
    /// The table as text that ends with a line break.
    ///
    /// # Errors
    /// [`Error::Internal`] when the CSV writer fails.
    pub fn render(&self, format: Format) -> Result<String> {
        Ok(match format {
            Format::Csv => return self.csv(),
            Format::Markdown => {
                let escaped = |cells: &[String]| {
                    cells
                        .iter()
                        .map(|c| c.replace('|', "\\|"))
                        .collect::<Vec<_>>()
                        .join(" | ")
                };
                let mut text = format!(
                    "| {} |\n|{}\n",
                    self.columns.join(" | "),
                    "---|".repeat(self.columns.len())
                );
                for row in &self.rows {
                    text += &format!("| {} |\n", escaped(row));
                }
                text
            }
            Format::Text => self.aligned(),
        })
    }

    fn csv(&self) -> Result<String> {
        let failed = |e: &dyn std::fmt::Display| Error::Internal(format!("table: {e}"));
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.columns).map_err(|e| failed(&e))?;
        for row in &self.rows {
            writer.write_record(row).map_err(|e| failed(&e))?;
        }
        let bytes = writer.into_inner().map_err(|e| failed(&e))?;
        String::from_utf8(bytes).map_err(|e| failed(&e))
    }

    /// Names to the left, numbers to the right.
    fn aligned(&self) -> String {
        let width = |i: usize| {
            let cells = self.rows.iter().map(|r| r[i].chars().count());
            cells
                .chain([self.columns[i].chars().count()])
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |cells: Vec<&str>| {
            let padded: Vec<String> = cells
                .iter()
                .zip(&widths)
                .enumerate()
                .map(|(i, (cell, &w))| {
                    if i < 2 {
                        format!("{cell:<w$}")
                    } else {
                        format!("{cell:>w$}")
                    }
                })
                .collect();
            padded.join("  ").trim_end().to_string() + "\n"
        };
        let mut text = line(self.columns.clone());
        for row in &self.rows {
            text += &line(row.iter().map(String::as_str).collect());
        }
        text
    }
}
