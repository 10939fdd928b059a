//! What a recipe that was read has to be like: names, sizes, expressions, counts.

use std::collections::BTreeSet;

use super::check::{REACH, text, unit};
use crate::motion::Class;
use crate::solid::expression::Values;
use crate::solid::recipe::{Body, Feature, Parameter, Recipe, Shape};
use crate::{Problem, Problems};

/// Longest name of a body, piece, feature or parameter.
const NAME: usize = 64;

/// Largest counts. Our own recipes have 43 parameters and at most 20 features a piece.
const PARAMETERS: usize = 200;
const FEATURES: usize = 200;
const PIECES: usize = 20;

/// Corners of a prism, fewest and most.
const SIDES: [u32; 2] = [3, 360];

/// The bodies that a mechanism of `class` has.
fn bodies(class: Class) -> &'static [&'static str] {
    match class {
        Class::R3T1 => &["driver", "follower", "support", "slider"],
        Class::R1 | Class::R1T1 | Class::R3 => &["driver", "follower", "support"],
    }
}

/// Whether `name` may become part of a path, a script or a tree: lower-case letters, digits, `_`
/// and `-`.
pub fn is_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_-".contains(c);
    !name.is_empty() && name.len() <= NAME && name.chars().all(plain)
}

/// Everything that is wrong with the recipe of a mechanism of `class`.
pub(super) fn recipe(found: &mut Problems, recipe: &Recipe, class: Class) {
    let parameters = &recipe.parameters;
    if found.count(|| "recipe.parameters".into(), parameters.len(), PARAMETERS) {
        self::parameters(found, parameters);
    }
    let allowed = bodies(class);
    let mut names = BTreeSet::new();
    let values = Values::new(parameters);
    if !found.count(
        || "recipe.bodies".into(),
        recipe.bodies.len(),
        allowed.len(),
    ) {
        return;
    }
    for (i, body) in recipe.bodies.iter().enumerate() {
        if !allowed.contains(&body.name.as_str()) || !names.insert(body.name.as_str()) {
            let what = format!(
                "is {:?}, allowed once each: {}",
                short(&body.name),
                allowed.join(", ")
            );
            found.add(|| Problem::new(format!("recipe.bodies[{i}].name"), what, ""));
        }
        self::body(found, &|| format!("recipe.bodies[{i}]"), (body, &values));
    }
    let pieces = recipe.bodies.iter().flat_map(|body| &body.pieces);
    let mut names = BTreeSet::new();
    for piece in pieces {
        if !is_name(&piece.name) || !names.insert(piece.name.as_str()) {
            let what = format!(
                "is {:?}, allowed 1 to {NAME} lower-case letters, digits, _ and -, each name once",
                short(&piece.name)
            );
            found.add(|| Problem::new("name of a piece", what, "it becomes a file name"));
        }
    }
}

/// Text of any length, to be quoted.
fn short(text: &str) -> String {
    let start: String = text.chars().take(NAME).collect();
    match start.len() < text.len() {
        true => start + "…",
        false => start,
    }
}

fn parameters(found: &mut Problems, parameters: &[Parameter]) {
    let mut names = BTreeSet::new();
    for (i, p) in parameters.iter().enumerate() {
        let place = |field: &str| format!("recipe.parameters[{i}].{field}");
        let snake = p
            .name
            .chars()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        let starts = p.name.starts_with(|c: char| c.is_ascii_lowercase());
        if !(snake && starts && p.name.len() <= NAME && names.insert(p.name.as_str())) {
            let what = format!(
                "is {:?}, allowed 1 to {NAME} lower-case letters, digits and _, each name once",
                short(&p.name)
            );
            found.add(|| Problem::new(place("name"), what, ""));
        }
        let group =
            !p.group.is_empty() && p.group.chars().all(|c| c.is_ascii_alphabetic() || c == ' ');
        if !group || p.group.len() > NAME {
            let what = format!("is {:?}, allowed 1 to {NAME} letters", short(&p.group));
            found.add(|| Problem::new(place("group"), what, ""));
        }
        text(found, || place("description"), &p.description);
        for (field, value) in [("value", p.value), ("min", p.min), ("max", p.max)] {
            found.range(|| place(field), value, [-REACH, REACH]);
        }
    }
}

fn body(found: &mut Problems, place: &dyn Fn() -> String, (body, values): (&Body, &Values)) {
    features(found, place, (&body.features, values));
    if !found.count(|| place() + ".pieces", body.pieces.len(), PIECES) {
        return;
    }
    for (i, piece) in body.pieces.iter().enumerate() {
        let place = || format!("{}.pieces[{i}]", place());
        unit(found, || place() + ".up", piece.up);
        features(found, &place, (&piece.features, values));
    }
}

fn features(
    found: &mut Problems,
    place: &dyn Fn() -> String,
    (features, values): (&[Feature], &Values),
) {
    if !found.count(|| place() + ".features", features.len(), FEATURES) {
        return;
    }
    for (i, feature) in features.iter().enumerate() {
        let place = || format!("{}.features[{i}]", place());
        let plain = |c: char| c.is_ascii_alphanumeric() || " _-".contains(c);
        let name = &feature.name;
        let starts = name.starts_with(|c: char| c.is_ascii_alphabetic());
        if !starts || name.len() > NAME || !name.chars().all(plain) {
            let what = format!(
                "is {:?}, allowed 1 to {NAME} letters, digits, spaces, _ and -",
                short(name)
            );
            found.add(|| Problem::new(place() + ".name", what, ""));
        }
        shape(found, &place, (&feature.shape, values));
    }
}

fn shape(found: &mut Problems, place: &dyn Fn() -> String, (shape, values): (&Shape, &Values)) {
    // Thinner than this is nothing that a kernel can build on.
    let (least, anywhere) = (1e-6, -REACH);
    let point = |field, at: &'_ [String; 3]| at.clone().map(|e| (field, e, anywhere)).to_vec();
    let (sizes, axis, sides) = match shape {
        Shape::Cone {
            base,
            axis,
            length,
            r0,
            r1,
        } => {
            let sizes = [("length", length), ("r0", r0), ("r1", r1)];
            let sizes = sizes.map(|(field, e)| (field, e.clone(), least));
            (
                [point("base", base), sizes.to_vec()].concat(),
                Some(axis),
                None,
            )
        }
        Shape::Block { min, max } => {
            let sizes = min.iter().zip(max);
            let sizes = sizes.map(|(a, b)| ("max - min", format!("{b} - ({a})"), least));
            let ends = [point("min", min), point("max", max), sizes.collect()];
            (ends.concat(), None, None)
        }
        Shape::Ball { center, radius } => {
            let radius = vec![("radius", radius.clone(), least)];
            ([point("center", center), radius].concat(), None, None)
        }
        Shape::Prism {
            base,
            axis,
            length,
            width,
            sides,
        } => {
            let sizes = [("length", length), ("width", width)];
            let sizes = sizes.map(|(field, e)| (field, e.clone(), least));
            let all = [point("base", base), sizes.to_vec()].concat();
            (all, Some(axis), Some(*sides))
        }
    };
    for (field, expression, min) in sizes {
        let place = || format!("{}.{field}", place());
        match values.try_eval(&expression) {
            Ok(value) => found.range(place, value, [min, REACH]),
            Err(what) => {
                let what = format!("`{}` {what}", short(&expression));
                found.add(|| Problem::new(place(), what, ""));
            }
        }
    }
    if let Some(axis) = axis {
        unit(found, || place() + ".axis", *axis);
    }
    let [fewest, most] = SIDES;
    if let Some(sides) = sides
        && !(fewest..=most).contains(&sides)
    {
        let what = format!("is {sides}, allowed {fewest} to {most}");
        found.add(|| Problem::new(place() + ".sides", what, ""));
    }
}
