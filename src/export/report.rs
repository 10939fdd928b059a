//! The report: one HTML file with the mechanism in motion, its figures and its proof, for people
//! who have never heard of form closure. Needs no network and no server.

use std::path::{Path, PathBuf};

use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, Value, context};
use serde::Serialize;

use super::chart;
use super::compact::CompactMesh;
use super::curves::{self, Plot};
use super::figures::{self, Figure};
use super::picture::{self, View};
use super::tables;
use crate::design::Design;
use crate::disk::write_whole;
use crate::load::contacts::Configuration;
use crate::load::sensitivity::Sensitivity;
use crate::load::{LoadReport, Sampling};
use crate::motion::Motion;
use crate::solid::assembly::{Carrier, SolidBody};
pub use crate::verify::Claim;
use crate::{Error, Result};

/// Size of the pictures of curves, pixels.
const CHART: (u32, u32) = (1200, 480);

/// Everything a report shows. Slices may be empty and options absent: the report leaves out what it
/// is not given, except that a design without `claims` is shown as not checked.
#[derive(Debug, Clone)]
pub struct ReportInput<'a> {
    /// The design.
    pub design: &'a Design,
    /// Its motion.
    pub motion: &'a Motion,
    /// Driver angles that are shown and plotted.
    pub sampling: Sampling,
    /// Bodies at φ = 0 in Σ; empty for a draft that could not be built.
    pub bodies: &'a [SolidBody],
    /// Verdicts of the proof.
    pub claims: &'a [Claim],
    /// Load figures.
    pub load: Option<&'a LoadReport>,
    /// Effect of assembly errors.
    pub sensitivity: Option<&'a Sensitivity>,
    /// Files beside the report.
    pub files: &'a [FileLink],
    /// Motion file as the user wrote it, to be shown; may be empty.
    pub motion_file: &'a str,
}

/// Colour of the parts of a carrier, CSS.
pub fn color(carrier: Carrier) -> &'static str {
    match carrier {
        Carrier::Driver => "#e8833a",
        Carrier::Follower => "#3f86d6",
        Carrier::Slider => "#4fa36b",
        Carrier::Support => "#a9b2bd",
    }
}

/// Name of a carrier in the page's script.
fn carrier_name(carrier: Carrier) -> &'static str {
    match carrier {
        Carrier::Driver => "driver",
        Carrier::Follower => "follower",
        Carrier::Slider => "slider",
        Carrier::Support => "support",
    }
}

/// A file beside the report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileLink {
    /// Path relative to the report.
    pub path: String,
    /// What it is for.
    pub note: String,
    /// Group it is listed under (Print, Meshes, OpenSCAD, …).
    pub group: String,
}

/// Data of the page's script.
#[derive(Debug, Serialize)]
struct Scene<'a> {
    name: &'a str,
    class: String,
    center_distance: f64,
    /// Driver angle per φ.
    driver_rate: f64,
    phi_deg: Vec<f64>,
    whole_turn: bool,
    /// x, y, z, qw, qx, qy, qz of the follower per angle, as in poses.csv.
    poses: Vec<[f64; 7]>,
    /// Height of the joint centre per angle, mm.
    lift: Vec<f64>,
    parts: Vec<ScenePart<'a>>,
    /// Per sub-gear pair: contact point and normal per angle.
    contacts: Vec<Vec<[f64; 6]>>,
    end_effector: [f64; 3],
    plots: &'a [Plot],
}

#[derive(Debug, Serialize)]
struct ScenePart<'a> {
    label: &'a str,
    moves: &'static str,
    color: &'a str,
    mesh: CompactMesh,
}

/// Writes the report to `path`; the file appears whole or not at all.
///
/// # Errors
/// [`Error::Io`] when the file cannot be written,
/// [`Error::Internal`] when the template fails.
pub fn write(input: &ReportInput, path: &Path) -> Result<()> {
    write_whole(path, html(input)?.as_bytes())
}

/// Writes pictures of the mechanism and of every curve into `folder` and returns their paths.
///
/// # Errors
/// [`Error::Io`] when a file cannot be written, [`Error::Internal`] when a picture cannot be drawn.
pub fn write_pictures(input: &ReportInput, folder: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    let mut pictures = vec![(
        "mechanism",
        picture::mechanism(input.bodies, View::default())?,
    )];
    for plot in curves::plots(input) {
        pictures.push((plot.id, chart::png(&plot, CHART)?));
    }
    pictures
        .into_iter()
        .map(|(name, bytes)| {
            let path = folder.join(format!("{name}.png"));
            write_whole(&path, &bytes)?;
            Ok(path)
        })
        .collect()
}

/// The report as text.
///
/// # Errors
/// As [`write()`], without files.
pub fn html(input: &ReportInput) -> Result<String> {
    let design = input.design;
    let plots = curves::plots(input);
    let figures = grouped(figures::all(input), |f: &Figure| f.group.to_string());
    let files = grouped(input.files.to_vec(), |f: &FileLink| f.group.clone());
    let scene = scene(input, &plots);
    let failed = input.claims.iter().filter(|c| !c.holds).count();
    let verdict = match (design.problems.len() + failed, input.claims.len()) {
        (0, 0) => "unchecked",
        (0, _) => "works",
        _ => "draft",
    };
    let picture = picture::mechanism(input.bodies, View::default())?;
    render(
        "report.html",
        context! {
            title => &design.name,
            class => design.class.to_string(),
            joint => joint_words(design.class),
            k => design.sub_gear_pairs.len(),
            j => tables::teeth(design),
            q_min => design.closure.iter().map(|c| c.q).reduce(f64::min),
            generator => &design.generator,
            verdict,
            claims => Value::from(Serde(input.claims)),
            problems => &design.problems,
            figures => Value::from(Serde(&figures)),
            plots => plots.iter().map(|p| context! { id => p.id, title => p.title, hint => p.hint, unit => p.unit }).collect::<Vec<_>>(),
            parameters => Value::from(Serde(&design.recipe.parameters)),
            settings => toml::to_string_pretty(&design.settings).map_err(|e| Error::Internal(e.to_string()))?,
            motion_file => input.motion_file,
            files => Value::from(Serde(&files)),
            picture => data_uri(&picture),
            scene => script_json(&scene)?,
        },
    )
}

/// Items under one heading.
#[derive(Debug, Serialize)]
struct Group<T> {
    name: String,
    items: Vec<T>,
}

/// Items by heading, both in the order they come in.
fn grouped<T>(items: Vec<T>, heading: impl Fn(&T) -> String) -> Vec<Group<T>> {
    let mut groups: Vec<Group<T>> = Vec::new();
    for item in items {
        let name = heading(&item);
        match groups.iter_mut().find(|g| g.name == name) {
            Some(group) => group.items.push(item),
            None => groups.push(Group {
                name,
                items: vec![item],
            }),
        }
    }
    groups
}

fn joint_words(class: crate::motion::Class) -> &'static str {
    use crate::motion::Class;
    match class {
        Class::R1 => "a pin it can only turn on",
        Class::R1T1 => "a pin it can turn on and slide along",
        Class::R3 => "a ball joint that lets it turn every way",
        Class::R3T1 => "a ball joint that also slides up and down",
    }
}

fn scene<'a>(input: &ReportInput<'a>, plots: &'a [Plot]) -> Scene<'a> {
    let (design, motion) = (input.design, input.motion);
    let sampling = input.sampling;
    let whole_turn = sampling.is_whole_turn();
    // The last angle of a turn is shown too, so that the slider reaches 360°.
    let mut angles: Vec<f64> = sampling.angles().collect();
    if whole_turn {
        angles.push(sampling.end);
    }
    let poses = angles.iter().map(|&phi| {
        let pose = motion.state(phi).pose;
        let q = pose.quaternion();
        let t = pose.translation;
        [t.x, t.y, t.z, q.w, q.i, q.j, q.k]
    });
    // A draft may lack teeth: it is shown without contacts.
    let at_all: Result<Vec<Configuration>> = angles
        .iter()
        .map(|&phi| Configuration::at(design, motion, phi))
        .collect();
    let at_all = at_all.unwrap_or_default();
    let contacts = (0..design.sub_gear_pairs.len())
        .filter(|_| !at_all.is_empty())
        .map(|k| at_all.iter().map(move |at| &at.contacts[k]))
        .map(|track| {
            track
                .map(|c| [c.p.x, c.p.y, c.p.z, c.n.x, c.n.y, c.n.z])
                .collect()
        })
        .collect();
    Scene {
        name: &design.name,
        class: design.class.to_string(),
        center_distance: design.settings.gear.center_distance_mm,
        driver_rate: design.settings.gear.drive().rate(),
        whole_turn,
        poses: poses.collect(),
        lift: angles
            .iter()
            .map(|&phi| motion.joint_centre(phi).z)
            .collect(),
        phi_deg: angles.iter().map(|phi| phi.to_degrees()).collect(),
        parts: input
            .bodies
            .iter()
            .map(|part| ScenePart {
                label: &part.name,
                moves: carrier_name(part.carrier),
                color: color(part.carrier),
                mesh: CompactMesh::new(&part.mesh),
            })
            .collect(),
        contacts,
        end_effector: design.settings.load.point_mm,
        plots,
    }
}

/// Renders one of the page templates with the shared style and the vendored libraries in it.
pub(super) fn render(template: &str, values: Value) -> Result<String> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let failed = |e: minijinja::Error| Error::Internal(format!("{template}: {e:#}"));
    for (name, text) in [
        (
            "report.html",
            include_str!("../../templates/report.html.jinja"),
        ),
        (
            "compare.html",
            include_str!("../../templates/compare.html.jinja"),
        ),
    ] {
        environment.add_template(name, text).map_err(failed)?;
    }
    // Inlined as they are: the page has to work without anything beside it.
    let inlined = SCRIPTS.into_iter().chain(STYLES);
    for (name, text) in inlined {
        environment.add_global(name, Value::from_safe_string(text.to_string()));
    }
    environment.add_global("policy", Value::from_safe_string(policy()));
    environment
        .get_template(template)
        .and_then(|t| t.render(values))
        .map_err(failed)
}

/// Scripts of the pages, by the name that the templates call them.
const SCRIPTS: [(&str, &str); 5] = [
    ("viewer", include_str!("../../templates/viewer.js")),
    ("charts", include_str!("../../templates/charts.js")),
    ("compare", include_str!("../../templates/compare.js")),
    (
        "three",
        include_str!("../../templates/vendor/three/three.bundle.min.js"),
    ),
    (
        "uplot",
        include_str!("../../templates/vendor/uplot/uPlot.iife.min.js"),
    ),
];
const STYLES: [(&str, &str); 2] = [
    ("style", include_str!("../../templates/page.css")),
    (
        "uplot_style",
        include_str!("../../templates/vendor/uplot/uPlot.min.css"),
    ),
];

/// Content security policy of the pages: they load nothing, and of scripts only ours run, told by
/// their hashes; text that slipped into a page could not become one.
fn policy() -> String {
    use base64::{Engine, engine::general_purpose::STANDARD};
    use sha2::{Digest, Sha256};
    let hashes =
        SCRIPTS.map(|(_, text)| format!("'sha256-{}'", STANDARD.encode(Sha256::digest(text))));
    format!(
        "default-src 'none'; script-src {}; style-src 'unsafe-inline'; img-src data: blob:; \
         font-src data:; base-uri 'none'; form-action 'none'",
        hashes.join(" ")
    )
}

/// JSON that can stand inside a script element: nothing in it can end the element.
pub(super) fn script_json(value: &impl Serialize) -> Result<Value> {
    let text = serde_json::to_string(value).map_err(|e| Error::Internal(e.to_string()))?;
    Ok(Value::from_safe_string(text.replace('<', "\\u003c")))
}

fn data_uri(png: &[u8]) -> Value {
    use base64::Engine;
    let text = base64::engine::general_purpose::STANDARD.encode(png);
    Value::from_safe_string(format!("data:image/png;base64,{text}"))
}
