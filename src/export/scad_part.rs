//! A body as the script templates need it: its modules, teeth and pieces as OpenSCAD code.

use serde::Serialize;

use super::Source;
use super::scad_bed;
use super::scad_csg::{self, Module};
use super::scad_options::Options;
use super::scad_teeth::{self, Teeth, number};
use crate::motion::Class;
use crate::solid::expression::Values;
use crate::solid::recipe::{Body, Feature, Operation, Recipe};
use crate::solid::sweep;
use crate::{Error, Result};

/// A body as the templates need it.
#[derive(Serialize)]
pub(super) struct Part {
    pub(super) name: String,
    colour: &'static str,
    /// Template of the options that only the part's own file has.
    options: Option<&'static str>,
    modules: Vec<Module>,
    tree: String,
    teeth: Option<TeethPart>,
    /// The printed pieces; a body that is printed whole has one of its own name.
    pieces: Vec<PiecePart>,
    /// Row-major 4×4 pose at φ = 0, if it is not the identity.
    pose: Option<String>,
}

#[derive(Serialize)]
struct TeethPart {
    #[serde(skip)]
    teeth: Teeth,
    /// One line of stations per tooth.
    stations: Vec<String>,
    axis: String,
    foot: String,
    /// Stations at both ends that have no rib.
    inset: usize,
    /// How much every rib thickens, a list.
    flares: String,
    /// Calls that make all beads, and all ribs, of as few polyhedra as may be.
    beads: String,
    ribs: String,
    /// Whether discs can be wider than the smallest hub.
    webs: bool,
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
    /// Corners of the rectangle on the bed that holds the piece.
    corners: String,
}

/// `body` of a recipe as code.
///
/// # Errors
/// [`Error::Internal`] when a parameter or the body's mesh is missing, [`Error::Infeasible`] when a tooth
/// folds.
pub(super) fn part(source: &Source, recipe: &Recipe, body: &Body) -> Result<Part> {
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
                webs: range.max - range.min > NARROWEST_WEB,
                smallest: number(range.min, 4),
                free: number(range.max, 4),
                hub,
                bands: format!("[{}]", bands.join(", ")),
                stations: teeth.lines(sweep::MAX_STATIONS),
                axis: format!(
                    "[{}, {}, {}]",
                    number(a.x, 4),
                    number(a.y, 4),
                    number(a.z, 4)
                ),
                foot: number(teeth.foot, 4),
                inset: Teeth::inset(sweep::MAX_STATIONS),
                flares: teeth.flare_list(),
                beads: shells("beads", &teeth.beads),
                ribs: shells("ribs", &teeth.ribs),
                teeth,
            })
        }
        None => None,
    };
    let mut pieces = Vec::new();
    for piece in &body.pieces {
        let mut own = Vec::new();
        let tree = scad_csg::tree(&self::steps(&piece.name, &piece.features, &mut own));
        let bottom = scad_bed::bottom(&piece.features, piece.up, &values)?;
        pieces.push(PiecePart {
            name: piece.name.clone(),
            modules: own,
            tree,
            up: direction(piece.up),
            // Feet are under the base plate.
            bottom: match piece.name == "base" {
                true => format!("{bottom} - feet_height"),
                false => bottom,
            },
            corners: scad_bed::corners(&piece.features, piece.up, &values)?,
        });
    }
    if pieces.is_empty() {
        let up = [0.0, 0.0, 1.0];
        pieces.push(PiecePart {
            name: body.name.clone(),
            modules: Vec::new(),
            tree: String::new(),
            up: direction(up),
            bottom: scad_bed::bottom(&body.features, up, &values)?,
            corners: corners(source, &body.name)?,
        });
    }
    Ok(Part {
        name: body.name.clone(),
        colour: super::threemf::colour(&body.name),
        options: options(source, recipe, &body.name),
        tree: scad_csg::tree(&steps),
        modules,
        teeth,
        pieces,
        pose: (body.name == "follower").then(|| pose(source)),
    })
}

/// Least width of a disc between the ribs, mm.
const NARROWEST_WEB: f64 = 0.5;

/// The rectangle that holds a body which is printed whole, as it was built: teeth and hub only become
/// smaller by the parameters.
fn corners(source: &Source, name: &str) -> Result<String> {
    let bodies = source.solids.iter().flat_map(|solids| &solids.bodies);
    let body = bodies.into_iter().find(|body| body.name == name);
    let body = body.ok_or_else(|| Error::Internal(format!("no mesh of the {name}")))?;
    let (low, high) = body.mesh.bounds();
    let [a, b, c, d] = [low.x, low.y, high.x, high.y].map(|x| number(x, 2));
    Ok(format!("[[{a}, {b}], [{c}, {d}]]"))
}

impl Part {
    /// Keeps at most `most` stations of every tooth.
    pub(super) fn thin(&mut self, most: usize) {
        if let Some(part) = &mut self.teeth {
            part.stations = part.teeth.lines(most);
            part.inset = Teeth::inset(most);
        }
    }
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

/// The template of the options that `body` has room for.
fn options(source: &Source, recipe: &Recipe, body: &str) -> Option<&'static str> {
    let offered = Options::of(recipe);
    match body {
        "driver" => offered.shaft.map(|_| "options_driver"),
        // The mount of 1R has the pocket of the pin's cap where a boss would stand.
        "follower" if source.design.class != Class::R1 => offered.boss.map(|_| "options_follower"),
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
