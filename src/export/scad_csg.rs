//! Recipe features as OpenSCAD code: one named module per feature, and the tree that joins them.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::solid::landmarks::{LANDMARKS, Landmark};
use crate::solid::recipe::{Feature, Operation, Shape};

/// Longest line of generated code.
const LINE: usize = 100;

/// A feature as a module of its own.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Module {
    /// Module name.
    pub name: String,
    /// The module's code.
    pub code: String,
}

/// The module of one feature; `owner` (body or piece) keeps names apart.
pub fn module(owner: &str, feature: &Feature) -> Module {
    let plain = identifier(&feature.name);
    let name = match plain.starts_with(owner) {
        true => plain,
        false => format!("{owner}_{plain}"),
    };
    let call = call(&feature.shape);
    let line = format!("module {name}() {{ {call}; }}");
    let code = match line.len() <= LINE {
        true => line,
        false => format!("module {name}() {{\n    {}\n}}", wrapped(&call)),
    };
    Module { name, code }
}

/// A call with `;`, on as many lines as it needs.
fn wrapped(call: &str) -> String {
    let short = format!("{call};");
    match call.split_once('(') {
        Some((name, arguments)) if short.len() > LINE - 4 => {
            let indent = " ".repeat(name.len() + 5);
            let lines = arguments.replace("], [", &format!("],\n{indent}["));
            format!("{name}({lines};")
        }
        _ => short,
    }
}

/// Lower case, with underscores for everything that OpenSCAD does not allow in a name.
fn identifier(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    text.to_lowercase().chars().map(plain).collect()
}

fn call(shape: &Shape) -> String {
    match shape {
        Shape::Cone {
            base: [x, y, bottom],
            axis: [0.0, 0.0, 1.0],
            length,
            r0,
            r1,
        } if r0 == r1 && upper_end(length, bottom).is_some() => {
            let top = readable(upper_end(length, bottom).unwrap_or_default());
            let [x, y, bottom, r0] = [x, y, bottom, r0].map(readable);
            format!("post([{x}, {y}], {bottom}, {top}, {r0})")
        }
        Shape::Cone {
            base,
            axis,
            length,
            r0,
            r1,
        } => {
            let (at, way) = (point(base), direction(axis));
            let [length, from, to] = [length, r0, r1].map(readable);
            match from == to {
                true => format!("rod({at}, {length}, {from}{way})"),
                false => format!("cone({at}, {length}, {from}, {to}{way})"),
            }
        }
        Shape::Block { min, max } => format!("block({}, {})", point(min), point(max)),
        Shape::Ball { center, radius } => {
            format!("ball({}, {})", point(center), readable(radius))
        }
        Shape::Prism {
            base,
            axis,
            length,
            width,
            sides,
        } => {
            let (at, way) = (point(base), direction(axis));
            let [length, width] = [length, width].map(readable);
            format!("prism({at}, {length}, {width}, {sides}{way})")
        }
    }
}

/// The upper end of an upright solid whose length is written as "upper end − (bottom)".
fn upper_end<'a>(length: &'a str, bottom: &str) -> Option<&'a str> {
    length.strip_suffix(&format!(" - ({bottom})"))
}

fn point(coordinates: &[String; 3]) -> String {
    let [x, y, z] = coordinates.each_ref().map(readable);
    format!("[{x}, {y}, {z}]")
}

fn direction(axis: &[f64; 3]) -> String {
    if *axis == [0.0, 0.0, 1.0] {
        String::new()
    } else {
        format!(", axis = [{}, {}, {}]", axis[0], axis[1], axis[2])
    }
}

/// The expression with its landmarks by name, without parentheses that say nothing.
pub fn readable(expression: impl AsRef<str>) -> String {
    let named = LANDMARKS
        .iter()
        .fold(expression.as_ref().to_string(), |text, l| {
            text.replace(l.expression, l.name)
        });
    tidy(&named)
}

/// The landmarks that the features' expressions use.
pub fn landmarks<'a>(features: impl Iterator<Item = &'a Feature>) -> Vec<&'static Landmark> {
    let all: Vec<&str> = features.flat_map(|f| expressions(&f.shape)).collect();
    let used = |l: &&Landmark| all.iter().any(|e| e.contains(l.expression));
    LANDMARKS.iter().filter(used).collect()
}

/// The expression without parentheses around single names or numbers, or around the whole.
fn tidy(expression: &str) -> String {
    let mut text = expression.trim().to_string();
    let mut from = 0;
    while let Some(open) = text[from..].find('(').map(|i| from + i) {
        let Some(close) = closing(&text, open) else {
            break;
        };
        let inner = &text[open + 1..close];
        let single = !inner.is_empty() && inner.chars().all(|c| is_word(c) || c == '.');
        let whole = open == 0 && close + 1 == text.len();
        if single || whole {
            text.remove(close);
            text.remove(open);
        } else {
            from = open + 1;
        }
    }
    text
}

fn closing(text: &str, open: usize) -> Option<usize> {
    let mut depth = 0;
    for (i, c) in text.char_indices().skip_while(|(i, _)| *i < open) {
        match c {
            '(' => depth += 1,
            ')' if depth == 1 => return Some(i),
            ')' => depth -= 1,
            _ => {}
        }
    }
    None
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Names that the features' expressions use.
pub fn names(features: &[Feature]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for feature in features {
        for expression in expressions(&feature.shape) {
            let words = expression.split(|c| !is_word(c));
            found.extend(
                words
                    .filter(|w| w.starts_with(|c: char| c.is_ascii_alphabetic()))
                    .map(String::from),
            );
        }
    }
    found
}

fn expressions(shape: &Shape) -> Vec<&str> {
    match shape {
        Shape::Cone {
            base,
            length,
            r0,
            r1,
            ..
        } => base.iter().chain([length, r0, r1]).map(|e| &**e).collect(),
        Shape::Block { min, max } => min.iter().chain(max).map(|e| &**e).collect(),
        Shape::Ball { center, radius } => center.iter().chain([radius]).map(|e| &**e).collect(),
        Shape::Prism {
            base,
            length,
            width,
            ..
        } => base.iter().chain([length, width]).map(|e| &**e).collect(),
    }
}

/// The tree of unions, differences and intersections that `steps` describe in order, as indented
/// code; a step is an operation and the call of a module.
pub fn tree(steps: &[(Operation, String)]) -> String {
    let mut lines: Vec<String> = Vec::new();
    for group in steps.chunk_by(|a, b| a.0 == b.0) {
        let calls = group.iter().map(|(_, call)| format!("{call};"));
        let word = match group[0].0 {
            Operation::Add => "union",
            Operation::Cut => "difference",
            Operation::Keep => "intersection",
        };
        let mut inside = std::mem::take(&mut lines);
        inside.extend(calls);
        lines = if inside.len() == 1 {
            inside
        } else {
            let indented = inside.iter().map(|line| format!("    {line}"));
            std::iter::once(format!("{word}() {{"))
                .chain(indented)
                .chain(["}".into()])
                .collect()
        };
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tidy_drops_only_what_is_not_needed() {
        assert_eq!(tidy("(a - b)"), "a - b");
        assert_eq!(tidy("top - (bottom)"), "top - bottom");
        assert_eq!(tidy("top - (a - b)"), "top - (a - b)");
        assert_eq!(tidy("(a) + (b)"), "a + b");
        assert_eq!(tidy("-(a + 2)"), "-(a + 2)");
        assert_eq!(tidy("((2.5))"), "2.5");
    }

    #[test]
    fn tree_nests_in_order() {
        let steps = [
            (Operation::Add, "a()".to_string()),
            (Operation::Cut, "b()".to_string()),
            (Operation::Add, "c()".to_string()),
        ];
        assert_eq!(
            tree(&steps),
            "union() {\n    difference() {\n        a();\n        b();\n    }\n    c();\n}"
        );
    }
}
