//! OpenSCAD scripts: one self-contained parametric file per body, the animated assembly, and all of it in
//! one file.

use serde::Serialize;

use super::scad_csg;
use super::scad_customizer::{Entry, Group, Spokes, fixed, groups, tooth_group, used_parameters};
use super::scad_options::Options;
use super::scad_parameters::{self, Parameter};
use super::scad_part::{Part, part};
use super::scad_teeth::number;
use super::template::render;
use super::{Source, tables};
use crate::Result;
use crate::motion::Motion;
use crate::solid::recipe::{Body, Recipe};
use crate::solid::sweep;

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

/// Largest size of the one file for sites that customise, bytes.
const LARGEST: usize = 400_000;

/// Stations of a tooth in that file: as many as fit.
const STATIONS: [usize; 3] = [sweep::MAX_STATIONS, 17, 9];

/// All scripts of a design: one per body of `recipe`, the assembly, and everything in one file for sites
/// that customise (ASCII, at most 400 kB unless the teeth are too many).
///
/// # Errors
/// [`crate::Error::Internal`] when a template fails or the source has no solids, [`crate::Error::Infeasible`] when a
/// tooth folds.
pub fn scripts(source: &Source, recipe: &Recipe) -> Result<Vec<Script>> {
    let parts: Result<Vec<Part>> = recipe
        .bodies
        .iter()
        .map(|body| part(source, recipe, body))
        .collect();
    let mut parts = parts?;
    let mut scripts = bodies(source, recipe, &parts)?;
    let poses = tables::poses_of_turn(source.motion, source.design.settings.gear.drive(), POSES);
    let poses: Vec<String> = poses.iter().map(pose_line).collect();
    let whole = |template: &str, parts: &[Part], what: &str| {
        let page = Page {
            poses: poses.clone(),
            ..Page::new(source, recipe, &recipe.bodies, parts, what)
        };
        render(template, page)
    };
    scripts.push(Script {
        name: "assembly.scad".into(),
        text: whole("assembly.scad", &parts, "the whole mechanism, animated")?,
    });
    let mut text = String::new();
    for most in STATIONS {
        parts.iter_mut().for_each(|part| part.thin(most));
        text = ascii(&whole("customizer.scad", &parts, "every part in one file")?);
        if text.len() <= LARGEST {
            break;
        }
    }
    scripts.push(Script {
        name: "customizer.scad".into(),
        text,
    });
    Ok(scripts)
}

/// One script per body. Each knows the parameters of the others, so that it can tell who gives it one.
fn bodies(source: &Source, recipe: &Recipe, parts: &[Part]) -> Result<Vec<Script>> {
    let write = |body: &Body, part: &Part, others: Vec<Elsewhere>| {
        let name = &body.name;
        let (body, part) = (std::slice::from_ref(body), std::slice::from_ref(part));
        let page = Page {
            others,
            ..Page::new(source, recipe, body, part, &format!("the {name}"))
        };
        Ok(Script {
            name: format!("{name}.scad"),
            text: render("part.scad", page)?,
        })
    };
    let pairs = recipe.bodies.iter().zip(parts);
    let alone: Result<Vec<Script>> = pairs.map(|(b, p)| write(b, p, Vec::new())).collect();
    let alone = alone?;
    let text = |i: usize| alone.get(i).map_or("", |script| &script.text);
    let known: Vec<_> = alone
        .iter()
        .map(|s| scad_parameters::read(&s.text))
        .collect();
    let mut scripts = Vec::new();
    for (i, (body, part)) in recipe.bodies.iter().zip(parts).enumerate() {
        let has = |name: &str| text(i).contains(&format!("\n{name} = "));
        scripts.push(write(body, part, elsewhere(recipe, &known, has))?);
    }
    Ok(scripts)
}

/// The parameters of the bodies' scripts that the script which `has` some names does not have, by file.
fn elsewhere(
    recipe: &Recipe,
    known: &[Vec<Parameter>],
    has: impl Fn(&str) -> bool,
) -> Vec<Elsewhere> {
    let mut files: Vec<Elsewhere> = Vec::new();
    for (body, list) in recipe.bodies.iter().zip(known) {
        let new = |name: &&String| !has(name) && !files.iter().any(|f| f.names.contains(*name));
        let names: Vec<String> = list.iter().map(|p| &p.name).filter(new).cloned().collect();
        if !names.is_empty() {
            files.push(Elsewhere {
                file: format!("{}.scad", body.name),
                names,
            });
        }
    }
    files
}

/// With `?` for what some sites refuse. Only comments have such letters: names that people gave.
fn ascii(text: &str) -> String {
    let plain = |c: char| if c.is_ascii() { c } else { '?' };
    text.chars().map(plain).collect()
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
    /// What there is room for.
    offered: Options,
    /// Parameters of the other files.
    others: Vec<Elsewhere>,
    library: &'static str,
    poses: Vec<String>,
    /// Driver angles of a motion that goes there and back, deg.
    swing: Option<[String; 2]>,
    /// How far the first layers are drawn in, mm.
    elephant_foot: String,
}

/// Parameters that another file has.
#[derive(Serialize)]
struct Elsewhere {
    file: String,
    names: Vec<String>,
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
            offered: Options::of(recipe),
            others: Vec::new(),
            library: library(),
            poses: Vec::new(),
            swing: swing(source.motion),
            elephant_foot: number(source.design.settings.fit.elephant_foot_mm, 3),
        }
    }
}

/// The library without its own head comment.
fn library() -> &'static str {
    LIBRARY
        .split_once("\n\n")
        .map_or(LIBRARY, |(_, rest)| rest.trim_end())
}

/// Ends of the driver's range, deg, where it goes there and back.
fn swing(motion: &Motion) -> Option<[String; 2]> {
    let cycle = motion.cycle();
    let ends = [cycle.start(), cycle.end()];
    (!cycle.wraps()).then(|| ends.map(|phi| number(phi.to_degrees(), 3)))
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
    j: String,
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
        j: tables::teeth(design),
        q_min: q_min.map_or("not known".into(), |q| number(q, 3)),
        date: super::date::from_environment(),
    }
}
