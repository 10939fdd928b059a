//! OpenSCAD scripts: one self-contained parametric file per body, and the animated assembly.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};
use serde::Serialize;

use super::scad_csg::{self, Module};
use super::scad_teeth::{self, number};
use super::{Source, tables};
use crate::design::Design;
use crate::motion::Class;
use crate::solid::expression::Values;
use crate::solid::recipe::{Body, Feature, Operation, Parameter, Recipe};
use crate::solid::rib;
use crate::{Error, Result};

/// The library that every script carries a copy of.
const LIBRARY: &str = include_str!("../../cad/openscad/mpcgear.scad");

/// Poses in the assembly's table.
const POSES: u32 = 180;

const TEMPLATES: [(&str, &str); 12] = [
    ("header", include_str!("../../templates/scad_header.jinja")),
    (
        "parameters",
        include_str!("../../templates/scad_parameters.jinja"),
    ),
    ("hidden", include_str!("../../templates/scad_hidden.jinja")),
    ("body", include_str!("../../templates/scad_body.jinja")),
    ("spokes", include_str!("../../templates/scad_spokes.jinja")),
    (
        "options_driver",
        include_str!("../../templates/scad_driver.jinja"),
    ),
    (
        "options_follower",
        include_str!("../../templates/scad_follower.jinja"),
    ),
    (
        "options_support",
        include_str!("../../templates/scad_support.jinja"),
    ),
    ("part.scad", include_str!("../../templates/part.scad.jinja")),
    (
        "assembly.scad",
        include_str!("../../templates/assembly.scad.jinja"),
    ),
    ("card.md", include_str!("../../templates/card.md.jinja")),
    ("parts.md", include_str!("../../templates/parts.md.jinja")),
];

/// A script with its file name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Script {
    /// `driver.scad` and so on.
    pub name: String,
    /// Contents.
    pub text: String,
}

/// Renders one of the templates; a value that is missing is an error.
///
/// # Errors
/// [`Error::Internal`] when the template fails.
pub fn render(template: &str, values: impl Serialize) -> Result<String> {
    let fail = |e: minijinja::Error| Error::Internal(format!("template {template}: {e:#}"));
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_syntax(
        SyntaxConfig::builder()
            .trim_blocks(true)
            .lstrip_blocks(true)
            .keep_trailing_newline(true)
            .build()
            .map_err(fail)?,
    );
    for (name, text) in TEMPLATES {
        environment.add_template(name, text).map_err(fail)?;
    }
    environment
        .get_template(template)
        .and_then(|t| t.render(Serde(&values)))
        .map_err(fail)
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
        name: one_line(&design.name),
        motion: kind.unwrap_or_else(|| "motion".into()),
        class: design.class.to_string(),
        generator: one_line(&super::maker(design)),
        center_distance: number(design.settings.gear.center_distance_mm, 4),
        k: design.sub_gear_pairs.len(),
        j: design.settings.gear.teeth,
        q_min: q_min.map_or("not known".into(), |q| number(q, 3)),
        date: super::date::from_environment(),
    }
}

/// Text that cannot end a comment.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A Customizer entry.
#[derive(Serialize)]
struct Entry {
    name: String,
    value: String,
    min: String,
    max: String,
    step: &'static str,
    description: String,
}

impl Entry {
    fn new(p: &Parameter) -> Entry {
        Entry {
            name: p.name.clone(),
            value: number(p.value, 4),
            min: number(p.min, 4),
            max: number(p.max, 4),
            step: if p.max - p.min < 2.0 { "0.01" } else { "0.1" },
            description: one_line(&p.description),
        }
    }
}

#[derive(Serialize)]
struct Group {
    name: String,
    entries: Vec<Entry>,
}

/// Parameters that the bodies' features and pieces use, in display order.
fn used_parameters<'a>(recipe: &'a Recipe, bodies: &[Body]) -> Vec<&'a Parameter> {
    let mut names = std::collections::BTreeSet::new();
    for body in bodies {
        names.extend(scad_csg::names(&body.features));
        for piece in &body.pieces {
            names.extend(scad_csg::names(&piece.features));
        }
    }
    let parameters = recipe.parameters.iter();
    parameters.filter(|p| names.contains(&p.name)).collect()
}

fn groups(parameters: &[&Parameter]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for p in parameters.iter().filter(|p| p.min < p.max) {
        match groups.iter_mut().find(|g| g.name == p.group) {
            Some(group) => group.entries.push(Entry::new(p)),
            None => groups.push(Group {
                name: p.group.clone(),
                entries: vec![Entry::new(p)],
            }),
        }
    }
    groups
}

/// What teeth and motion dictate: not in the Customizer.
fn fixed(parameters: &[&Parameter]) -> Vec<Entry> {
    let dictated = parameters.iter().filter(|p| p.min >= p.max);
    dictated.map(|p| Entry::new(p)).collect()
}

/// Customizer group of the section.
fn tooth_group(source: &Source) -> Group {
    let s = &source.design.section;
    let wall = source.design.settings.gear.minimum_wall_mm;
    let entry = |name: &str, value: f64, (min, max): (f64, f64), description: &str| Entry {
        name: name.into(),
        value: number(value, 4),
        min: number(min.min(value), 4),
        max: number(max.max(value), 4),
        step: "0.01",
        description: description.into(),
    };
    let teeth = vec![
        entry(
            "tooth_thickness",
            s.thickness,
            (wall, s.thickness),
            "thickness across the bead, measured away from the contact; a thicker one would meet the next tooth",
        ),
        entry(
            "flank_radius",
            s.flank_radius,
            (0.4, s.flank_radius),
            "radius of the flanks; a larger one would break conjugation, a smaller one keeps the contact",
        ),
        entry(
            "tooth_tip",
            s.tip,
            (0.3 * s.flank_radius, s.tip),
            "height beyond the contact point; lower is harmless",
        ),
        entry(
            "tooth_root",
            s.root,
            (0.1, s.root),
            "depth of the section behind the contact point; harmless while the wall covers it",
        ),
        entry(
            "clearance",
            s.clearance,
            (0.0, 2.0 * scad_teeth::SPARE),
            "flank-to-flank gap, half of it off this gear; both gears want the same value; 0 is the exact contact and binds, more is play",
        ),
    ];
    Group {
        name: "Teeth".into(),
        entries: teeth,
    }
}

/// Limits of the walls that carry the teeth, mm.
#[derive(Serialize)]
struct Spokes {
    /// Least wall.
    wall: String,
    /// Thickness of the walls as designed.
    rib: String,
    /// Thickness of the teeth, which no wall may exceed.
    thickness: String,
    /// Largest fillet: with the thinnest wall.
    fillet: String,
}

impl Spokes {
    fn of(design: &Design) -> Spokes {
        let section = &design.section;
        let wall = design.settings.gear.minimum_wall_mm.min(section.rib);
        Spokes {
            wall: number(wall, 4),
            rib: number(section.rib, 4),
            thickness: number(section.thickness, 4),
            fillet: number(0.5 * (section.thickness - wall).max(0.0), 4),
        }
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
    beads_apart: bool,
    ribs_apart: bool,
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
                beads_apart: teeth.beads_apart,
                ribs_apart: teeth.ribs_apart,
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
    if pieces.is_empty() {
        let up = [0.0, 0.0, 1.0];
        pieces.push(PiecePart {
            name: body.name.clone(),
            modules: Vec::new(),
            tree: String::new(),
            up: direction(up),
            bottom: super::scad_bed::bottom(&body.features, up, &values)?,
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
        pose: (body.name == "follower").then(|| pose(source)),
    })
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
