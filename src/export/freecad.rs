//! FreeCAD: the macro that rebuilds a design as a parametric tree, and STEP by running it.
//!
//! The macro is the add-on's own builder (`cad/freecad/freecad/mpcgear`), inlined, with the design's
//! numbers behind it; so the macro, the add-on and the STEP file are one and the same geometry.

use std::path::{Path, PathBuf};
use std::process::Command;

use minijinja::{Environment, UndefinedBehavior, context};
use serde::Deserialize;
use serde_json::{Value, json};

use super::tables;
use crate::design::{Design, Station};
use crate::motion::Motion;
use crate::solid::{rib, sweep};
use crate::{Error, Result, escape};

const TEMPLATE: &str = include_str!("../../templates/macro.FCMacro.jinja");
/// The add-on's modules that the macro consists of, in the order of their imports.
const MODULES: [&str; 12] = [
    include_str!("../../cad/freecad/freecad/mpcgear/parameters.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/progress.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/poses.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/options.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/sections.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/teeth.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/datums.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/check.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/step.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/printing.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/files.py"),
    include_str!("../../cad/freecad/freecad/mpcgear/builder.py"),
];

/// Every which frame of the mesh's tooth carries a section of the loft: lofts through every third
/// one stay within 4e-4 mm of those through all and fuse twice as fast.
const FRAME_STEP: usize = 3;

/// Poses of the follower in a period; between them FreeCAD interpolates.
const POSES: u32 = 360;

/// Decimals of the numbers in a macro, mm: far below any tolerance of FreeCAD (1e-7).
const DECIMALS: i32 = 9;

/// Longest line of the macro's numbers, characters; a contact station fits on one.
const LINE: usize = 420;

/// Name of the document and its files: the design's name in CamelCase, letters and digits only.
pub fn stem(design: &Design) -> String {
    let words = design.name.split(|c: char| !c.is_ascii_alphanumeric());
    let camel: String = words
        .filter_map(|word| {
            let mut letters = word.chars();
            let first = letters.next()?.to_ascii_uppercase();
            Some(std::iter::once(first).chain(letters).collect::<String>())
        })
        .collect();
    match camel.chars().next() {
        Some(c) if c.is_ascii_alphabetic() => camel,
        _ => format!("Gear{camel}"),
    }
}

/// Text of `NAME.FCMacro` for a design that has its recipe; `date` (YYYY-MM-DD) goes into the header.
///
/// # Errors
/// [`Error::Internal`] when the recipe is missing or the template fails.
pub fn macro_text(design: &Design, date: &str) -> Result<String> {
    if design.recipe.bodies.is_empty() {
        return Err(Error::Internal(
            "the design has no recipe to build from: build its solids first".into(),
        ));
    }
    let mut environment = Environment::new();
    escape::filters(&mut environment);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let min_q = design.closure.iter().map(|s| s.q).reduce(f64::min);
    environment
        .render_str(
            TEMPLATE,
            context! {
                stem => stem(design),
                name => design.name.clone(),
                generator => super::maker(design),
                version => env!("CARGO_PKG_VERSION"),
                date => date,
                class => design.class.to_string(),
                pairs => design.sub_gear_pairs.len(),
                teeth => tables::teeth(design),
                distance => design.settings.gear.center_distance_mm,
                min_q => min_q.map_or("not measured".into(), |q| format!("{q:.3}")),
                code => MODULES.map(standalone).join("\n\n"),
                design => outline(&essence(design)?, 0),
            },
        )
        .map_err(|e| Error::Internal(format!("FreeCAD macro: {e:#}")))
}

/// A module without its imports from its neighbours, which stand before it in the macro.
fn standalone(module: &str) -> String {
    let lines = module.lines().filter(|line| !line.starts_with("from ."));
    lines.map(|line| format!("{line}\n")).collect()
}

/// What the builder reads of a design: `design.json` without the motion and the search's variables,
/// with the stations of the lofts as they are on the gears.
fn essence(design: &Design) -> Result<Value> {
    let mut slim = design.clone();
    for pair in &mut slim.sub_gear_pairs {
        pair.parameters.clear();
        for tooth in &mut pair.teeth {
            tooth.control_points.clear();
            let chosen = loft_stations(tooth.stations.len());
            tooth.stations = chosen.iter().map(|&i| tooth.stations[i]).collect();
        }
    }
    let mut value =
        serde_json::to_value(&slim).map_err(|e| Error::Internal(format!("FreeCAD macro: {e}")))?;
    for (k, pair) in slim.sub_gear_pairs.iter().enumerate() {
        for (j, tooth) in pair.teeth.iter().enumerate() {
            let rows = tooth.stations.iter().map(on_gears).collect();
            value["sub_gear_pairs"][k]["teeth"][j]["stations"] = rows;
        }
    }
    if let Some(fields) = value.as_object_mut() {
        fields.remove("motion");
        fields.insert("poses".into(), poses(design)?);
    }
    round(&mut value);
    Ok(value)
}

/// A station with all that it is in Σ and on the gears, but for its velocity.
fn on_gears(s: &Station) -> Value {
    json!({"phi": s.phi, "p": s.p, "n": s.n, "p1": s.p1, "n1": s.n1, "t1": s.t1,
        "p2": s.p2, "n2": s.n2, "t2": s.t2})
}

/// Rows of driver angle (rad), position and quaternion (real part last) of the follower over one turn.
fn poses(design: &Design) -> Result<Value> {
    let motion = Motion::new(design.class, &design.motion)?;
    let rows = tables::poses_of_turn(&motion, design.settings.gear.drive(), POSES);
    let row = |r: &tables::PoseRow| {
        Value::from(vec![
            r.phi_deg.to_radians(),
            r.x,
            r.y,
            r.z,
            r.qx,
            r.qy,
            r.qz,
            r.qw,
        ])
    };
    // FreeCAD counts driver angles from 0; what a range leaves out of the turn has no rows.
    let (before, after): (Vec<&tables::PoseRow>, Vec<&tables::PoseRow>) =
        rows.iter().partition(|r| r.phi_deg < 0.0);
    let turned = before.into_iter().map(|r| tables::PoseRow {
        phi_deg: r.phi_deg + 360.0,
        ..*r
    });
    Ok(after
        .into_iter()
        .copied()
        .chain(turned)
        .map(|r| row(&r))
        .collect())
}

/// Which of a tooth's `stations` carry a section of its loft: both ends, and between them the ribs'
/// own, of which the first and the last stand where the ribs of the mesh end.
fn loft_stations(stations: usize) -> Vec<usize> {
    let frames = sweep::chosen(stations);
    let inner = rib::span(&frames);
    let steps = (inner.len().saturating_sub(1) / FRAME_STEP).max(1);
    let ribs = (0..=steps).map(|i| inner[i * (inner.len() - 1) / steps]);
    let mut chosen: Vec<usize> = frames.first().copied().into_iter().chain(ribs).collect();
    chosen.extend(frames.last());
    chosen.dedup();
    chosen
}

fn round(value: &mut Value) {
    match value {
        Value::Number(number) => {
            let scale = 10f64.powi(DECIMALS);
            let rounded = number.as_f64().map(|x| (x * scale).round() / scale + 0.0);
            if !number.is_u64()
                && let Some(x) = rounded.and_then(serde_json::Number::from_f64)
            {
                *number = x;
            }
        }
        Value::Array(items) => items.iter_mut().for_each(round),
        Value::Object(fields) => fields.values_mut().for_each(round),
        _ => {}
    }
}

/// JSON with one line for everything that fits on one, indented by one space per level.
fn outline(value: &Value, depth: usize) -> String {
    let compact = value.to_string();
    let inner = |lines: Vec<String>, (open, close): (char, char)| {
        let pad = " ".repeat(depth + 1);
        let body: Vec<String> = lines.iter().map(|line| format!("{pad}{line}")).collect();
        format!("{open}\n{}\n{}{close}", body.join(",\n"), " ".repeat(depth))
    };
    match value {
        _ if compact.len() <= LINE => compact,
        Value::Array(items) => inner(
            items.iter().map(|item| outline(item, depth + 1)).collect(),
            ('[', ']'),
        ),
        Value::Object(fields) => inner(
            fields
                .iter()
                .map(|(key, item)| format!("\"{key}\": {}", outline(item, depth + 1)))
                .collect(),
            ('{', '}'),
        ),
        _ => compact,
    }
}

/// What a headless run of the macro left behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Built {
    /// The FreeCAD document.
    pub document: PathBuf,
    /// STEP AP214, mm, one named, coloured solid per part below a root with the design's name, in
    /// assembled position at the first phase; beside them the pieces of what is printed in pieces.
    pub step: PathBuf,
    /// Volume of every part, mm³, by name in order of the recipe.
    pub volumes: Vec<(String, f64)>,
}

/// The result file of a headless run.
#[derive(Deserialize)]
struct Outcome {
    ok: bool,
    #[serde(default)]
    error: String,
    #[serde(default)]
    parts: std::collections::BTreeMap<String, PartFacts>,
}

#[derive(Deserialize)]
struct PartFacts {
    volume_mm3: f64,
}

/// How a macro is run without a window.
#[derive(Debug, Clone, Copy)]
pub struct Headless<'a> {
    /// FreeCAD's command line, usually `freecadcmd`.
    pub program: &'a Path,
    /// Where the files go; it has to exist.
    pub folder: &'a Path,
    /// Also look for self-intersections of every solid: takes as long as building them.
    pub thorough: bool,
}

/// Builds a design's document with FreeCAD and leaves it, the STEP file and one STL per part in the
/// folder; nothing is left there when it fails. `date` is for the macro's header.
///
/// # Errors
/// [`Error::Io`] when FreeCAD cannot be started or a file cannot be written, [`Error::Internal`]
/// with FreeCAD's reason when the parts do not come out as one valid solid each.
pub fn run(design: &Design, date: &str, headless: &Headless) -> Result<Built> {
    let &Headless {
        program,
        folder,
        thorough,
    } = headless;
    let stem = stem(design);
    let work = tempfile::Builder::new()
        .prefix(".freecad")
        .tempdir_in(folder)
        .map_err(Error::io(folder))?;
    let script = work.path().join(format!("{stem}.FCMacro"));
    std::fs::write(&script, macro_text(design, date)?).map_err(Error::io(&script))?;
    let output = Command::new(program)
        .arg(&script)
        .env("MPCGEAR_OUT", work.path())
        .env("MPCGEAR_CHECK", if thorough { "full" } else { "" })
        .env("HOME", work.path()) // FreeCAD writes its settings there
        .output()
        .map_err(Error::io(program))?;
    let report = work.path().join(format!("{stem}.result.json"));
    let outcome: Outcome = std::fs::read_to_string(&report)
        .ok()
        .and_then(|text| serde_json::from_str(&text).ok())
        .ok_or_else(|| {
            let said = String::from_utf8_lossy(&output.stderr);
            Error::Internal(format!("FreeCAD left no result: {}", said.trim()))
        })?;
    if !outcome.ok || !output.status.success() {
        return Err(Error::Internal(format!("FreeCAD: {}", outcome.error)));
    }
    let keep = |name: String| -> Result<PathBuf> {
        let target = folder.join(&name);
        std::fs::rename(work.path().join(&name), &target).map_err(Error::io(&target))?;
        Ok(target)
    };
    let volumes: Vec<(String, f64)> = outcome
        .parts
        .into_iter()
        .map(|(name, facts)| (name, facts.volume_mm3))
        .collect();
    for (name, _) in &volumes {
        keep(format!("{stem}-{name}.stl"))?;
    }
    Ok(Built {
        document: keep(format!("{stem}.FCStd"))?,
        step: keep(format!("{stem}.step"))?,
        volumes,
    })
}
