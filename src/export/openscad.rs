//! OpenSCAD scripts: one self-contained parametric file per body, and the animated assembly.

use serde::Serialize;

use super::scad_csg::{self, Module};
use super::scad_customizer::{Entry, Group, Spokes, fixed, groups, tooth_group, used_parameters};
use super::scad_teeth::{self, number};
use super::template::render;
use super::{Source, tables};
use crate::motion::Class;
use crate::solid::expression::Values;
use crate::solid::recipe::{Body, Feature, Operation, Recipe};
use crate::solid::rib;
use crate::{Error, Result};

/// The library that every script carries a copy of.
const LIBRARY: &str = include_str!("../../cad/openscad/mpcgear.scad");

/// Poses in the assembly's table.
const POSES: u32 = 180;

/// A script with its file name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Script {
    /// `driver.scad` and so on.
    pub name: String,
    /// Contents.
    pub text: String,
}

/// All scripts of a design: one per body of `recipe`, then the assembly.
///
/// # Errors
/// [`Error::Internal`] when a template fails, [`Error::Infeasible`] when a tooth folds.
pub fn scripts(source: &Source, recipe: &Recipe) -> Result<Vec<Script>> {
    let parts: Result<Vec<Part>> = recipe
        .bodies
        .iter()
        .map(|body| part(source, recipe, body))
        .collect();
    let parts = parts?;
    let mut scripts = Vec::new();
    for (body, part) in recipe.bodies.iter().zip(&parts) {
        let (body, part) = (std::slice::from_ref(body), std::slice::from_ref(part));
        let name = &body[0].name;
        let page = Page::new(source, recipe, body, part, &format!("the {name}"));
        scripts.push(Script {
            name: format!("{name}.scad"),
            text: render("part.scad", page)?,
        });
    }
    let poses = tables::poses(source.motion, POSES);
    let what = "the whole mechanism, animated";
    let page = Page {
        poses: poses.iter().map(pose_line).collect(),
        ..Page::new(source, recipe, &recipe.bodies, &parts, what)
    };
    scripts.push(Script {
        name: "assembly.scad".into(),
        text: render("assembly.scad", page)?,
    });
    Ok(scripts)
}

fn pose_line(row: &tables::PoseRow) -> String {
    let numbers = [row.x, row.y, row.z, row.qw, row.qx, row.qy, row.qz];
    format!("[{}]", numbers.map(|x| number(x, 6)).join(", "))
}

/// What the script templates are filled from.
#[derive(Serialize)]
struct Page<'a> {
    about: About,
    groups: Vec<Group>,
    fixed: Vec<Entry>,
    landmarks: Vec<Named>,
    has_teeth: bool,
    spokes: Option<Spokes>,
    bodies: &'a [Part],
    library: &'static str,
    poses: Vec<String>,
}

/// A named expression.
#[derive(Serialize)]
struct Named {
    name: &'static str,
    expression: String,
    description: &'static str,
}

impl<'a> Page<'a> {
    /// A page about `bodies`, which `parts` describe.
    fn new(
        source: &Source,
        recipe: &Recipe,
        bodies: &[Body],
        parts: &'a [Part],
        what: &str,
    ) -> Self {
        let used = used_parameters(recipe, bodies);
        let has_teeth = bodies.iter().any(|b| b.teeth.is_some());
        let mut groups = groups(&used);
        if has_teeth {
            groups.push(tooth_group(source));
        }
        let own = bodies.iter().flat_map(|b| &b.features);
        let of_pieces = bodies
            .iter()
            .flat_map(|b| &b.pieces)
            .flat_map(|p| &p.features);
        let landmarks = scad_csg::landmarks(own.chain(of_pieces));
        Page {
            about: about(source, what),
            groups,
            fixed: fixed(&used),
            landmarks: landmarks
                .into_iter()
                .map(|l| Named {
                    name: l.name,
                    expression: l.expression.trim_matches(['(', ')']).into(),
                    description: l.description,
                })
                .collect(),
            has_teeth,
            spokes: has_teeth.then(|| Spokes::of(source.design)),
            bodies: parts,
            library: library(),
            poses: Vec::new(),
        }
    }
}

/// The library without its own head comment.
fn library() -> &'static str {
    LIBRARY
        .split_once("\n\n")
        .map_or(LIBRARY, |(_, rest)| rest.trim_end())
}

#[derive(Serialize)]
struct About {
    what: String,
    name: String,
    motion: String,
    class: String,
    generator: String,
    center_distance: String,
    k: usize,
    j: usize,
    q_min: String,
    date: Option<String>,
}

fn about(source: &Source, what: &str) -> About {
    let design = source.design;
    let kind = serde_json::to_value(&design.motion)
        .ok()
        .and_then(|v| v.get("kind")?.as_str().map(String::from));
    let q_min = tables::Summary::of(design).q_min;
    About {
        what: what.into(),
        name: design.name.clone(),
        motion: kind.unwrap_or_else(|| "motion".into()),
        class: design.class.to_string(),
        generator: super::maker(design),
        center_distance: number(design.settings.gear.center_distance_mm, 4),
        k: design.sub_gear_pairs.len(),
        j: design.settings.gear.teeth,
        q_min: q_min.map_or("not known".into(), |q| number(q, 3)),
        date: super::date::from_environment(),
    }
}

/// A body as the templates need it.
#[derive(Serialize)]
struct Part {
    name: String,
    colour: &'static str,
    /// Template of the options that only the part's own file has.
    options: Option<&'static str>,
    modules: Vec<Module>,
    tree: String,
    teeth: Option<TeethPart>,
    /// The printed pieces; a body that is printed whole has one of its own name.
    pieces: Vec<PiecePart>,
    /// Height of the lowest face of the whole body without its teeth.
    bottom: String,
    /// Row-major 4×4 pose at φ = 0, if it is not the identity.
    pose: Option<String>,
}

#[derive(Serialize)]
struct TeethPart {
    stations: Vec<String>,
    axis: String,
    foot: String,
    /// Stations at both ends that have no rib.
    inset: usize,
    /// Calls that make all beads, and all ribs, of as few polyhedra as may be.
    beads: String,
    ribs: String,
    /// Parameter with the hub's radius, its smallest and its largest value.
    hub: String,
    smallest: String,
    free: String,
    /// Middle heights of the sub-gear pairs.
    bands: String,
}

#[derive(Serialize)]
struct PiecePart {
    name: String,
    modules: Vec<Module>,
    tree: String,
    /// Direction that points up on the print bed.
    up: String,
    /// Coordinate along `up` of the face that lies on the bed.
    bottom: String,
}

fn part(source: &Source, recipe: &Recipe, body: &Body) -> Result<Part> {
    let values = Values::new(&recipe.parameters);
    let mut modules = Vec::new();
    let mut steps = steps(&body.name, &body.features, &mut modules);
    let teeth = match body.teeth {
        Some(gear) => {
            steps.push((Operation::Add, format!("{}_teeth()", body.name)));
            let teeth = scad_teeth::teeth(source.design, gear)?;
            let a = teeth.axis;
            let hub = format!("{}_hub_radius", body.name);
            let range = recipe.parameters.iter().find(|p| p.name == hub);
            let range = range.ok_or_else(|| Error::Internal(format!("no parameter `{hub}`")))?;
            let bands: Vec<String> = teeth.bands.iter().map(|&z| number(z, 4)).collect();
            Some(TeethPart {
                smallest: number(range.min, 4),
                free: number(range.max, 4),
                hub,
                bands: format!("[{}]", bands.join(", ")),
                stations: teeth.stations,
                axis: format!(
                    "[{}, {}, {}]",
                    number(a.x, 4),
                    number(a.y, 4),
                    number(a.z, 4)
                ),
                foot: number(teeth.foot, 4),
                inset: rib::INSET,
                beads: shells("beads", &teeth.beads),
                ribs: shells("ribs", &teeth.ribs),
            })
        }
        None => None,
    };
    let mut pieces = Vec::new();
    for piece in &body.pieces {
        let mut own = Vec::new();
        let tree = scad_csg::tree(&self::steps(&piece.name, &piece.features, &mut own));
        pieces.push(PiecePart {
            name: piece.name.clone(),
            modules: own,
            tree,
            up: direction(piece.up),
            bottom: super::scad_bed::bottom(&piece.features, piece.up, &values)?,
        });
    }
    let up = [0.0, 0.0, 1.0];
    let bottom = super::scad_bed::bottom(&body.features, up, &values)?;
    if pieces.is_empty() {
        pieces.push(PiecePart {
            name: body.name.clone(),
            modules: Vec::new(),
            tree: String::new(),
            up: direction(up),
            bottom: bottom.clone(),
        });
    }
    Ok(Part {
        name: body.name.clone(),
        colour: super::threemf::colour(&body.name),
        options: options(source, &body.name),
        tree: scad_csg::tree(&steps),
        modules,
        teeth,
        pieces,
        bottom,
        pose: (body.name == "follower").then(|| pose(source)),
    })
}

/// Longest line of generated code.
const LINE: usize = 96;

/// One polyhedron of all `what` if they are apart, else one for every list of numbers.
fn shells(what: &str, apart: &[Vec<usize>]) -> String {
    if apart.len() < 2 {
        return format!("shells({what});");
    }
    let mut text = String::from("for (apart = [");
    let mut column = text.len() + 4;
    for (k, list) in apart.iter().enumerate() {
        for (i, number) in list.iter().enumerate() {
            let start = if i == 0 { "[" } else { "" };
            let end = match (i + 1 == list.len(), k + 1 == apart.len()) {
                (false, _) => ",",
                (true, false) => "],",
                (true, true) => "]]",
            };
            let word = format!("{start}{number}{end}");
            if column + word.len() + 1 > LINE {
                text = text.trim_end().to_string() + "\n         ";
                column = 13;
            }
            column += word.len() + 1;
            text += &word;
            text += " ";
        }
    }
    format!(
        "{})\n        shells([for (i = apart) {what}[i]]);",
        text.trim_end()
    )
}

fn options(source: &Source, body: &str) -> Option<&'static str> {
    match body {
        "driver" => Some("options_driver"),
        // The mount of 1R has the pocket of the pin's cap where a boss would stand.
        "follower" if source.design.class != Class::R1 => Some("options_follower"),
        "support" => Some("options_support"),
        _ => None,
    }
}

/// The calls of `features` in order, after putting their modules into `modules`.
fn steps(owner: &str, features: &[Feature], modules: &mut Vec<Module>) -> Vec<(Operation, String)> {
    let step = |feature: &Feature| {
        let module = scad_csg::module(owner, feature);
        let call = format!("{}()", module.name);
        modules.push(module);
        (feature.operation, call)
    };
    features.iter().map(step).collect()
}

fn direction(v: [f64; 3]) -> String {
    format!("[{}, {}, {}]", v[0], v[1], v[2])
}

/// The follower's pose at φ = 0 as an OpenSCAD matrix.
fn pose(source: &Source) -> String {
    let pose = source.motion.state(0.0).pose;
    let row = |i: usize| {
        let r = pose.rotation.row(i);
        let numbers = [r[0], r[1], r[2], pose.translation[i]].map(|x| number(x, 9));
        format!("[{}]", numbers.join(", "))
    };
    format!("[{}, {}, {}]", row(0), row(1), row(2))
}
