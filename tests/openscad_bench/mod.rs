//! Scripts of a small design, changed one parameter at a time.

#![allow(dead_code)]

use std::cell::RefCell;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::path::PathBuf;

use mpcgear::design::{Design, Section};
use mpcgear::export::{Source, format};
use mpcgear::motion::{Class, Motion};
use mpcgear::solid::{Mesh, Solids};

use crate::openscad_run::Run;
use crate::synthetic;

/// Teeth per band: enough to see what the section's parameters do.
const TEETH: usize = 1;

/// Values of a parameter in OpenSCAD's words.
pub type Values<'a> = &'a [(&'a str, &'a str)];

/// Scripts of a small design, and what they were made from.
pub struct Bench {
    pub design: Design,
    pub motion: Motion,
    pub solids: Solids,
    pub folder: PathBuf,
    /// Bodies by the values that they were rendered with: the plain ones are needed again and again.
    seen: RefCell<HashMap<String, Mesh>>,
}

impl Bench {
    /// A bench of its own for each test, which is known by `name`.
    pub fn new(class: Class, name: &str) -> Bench {
        Bench::with(class, name, |_| {})
    }

    /// The same of a design that is changed first.
    pub fn with(class: Class, name: &str, change: impl FnOnce(&mut Design)) -> Bench {
        let (mut design, motion) = synthetic::uniform(class);
        change(&mut design);
        for pair in &mut design.sub_gear_pairs {
            pair.teeth.truncate(TEETH);
        }
        let solids = Solids::build(&design, &motion).expect("builds");
        design.recipe = solids.recipe.clone();
        let source = Source {
            design: &design,
            motion: &motion,
            solids: Some(&solids),
        };
        let files = format::render(&source, format::Format::OpenScad, None).expect("renders");
        let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("parameters-{name}"));
        std::fs::create_dir_all(&out).expect("writable");
        for file in &files {
            std::fs::write(out.join(&file.path), &file.bytes).expect("writable");
        }
        Bench {
            design,
            motion,
            solids,
            folder: out,
            seen: RefCell::default(),
        }
    }

    pub fn run(&self, body: &str, values: Values) -> Run {
        let run = Run::new(&self.folder.join(format!("{body}.scad")));
        // The finest teeth, which are those of the embedded kernel.
        let run = match self.has(body, "quality") {
            true => run.set("quality", "\"fine\""),
            false => run,
        };
        values
            .iter()
            .fold(run, |run, (name, value)| run.set(name, value))
    }

    /// The one closed body that a script makes of these values.
    pub fn mesh(&self, body: &str, values: Values) -> Mesh {
        let label: Vec<String> = values.iter().map(|(n, v)| format!("{n}-{v}")).collect();
        let label = label.join("-").replace(['"', '.'], "_");
        let key = format!("{body} {label}");
        if let Some(mesh) = self.seen.borrow().get(&key) {
            return mesh.clone();
        }
        let mesh = self.run(body, values).stl(&label).one_closed_body();
        self.seen.borrow_mut().insert(key, mesh.clone());
        mesh
    }

    pub fn volume(&self, body: &str, values: Values) -> f64 {
        self.mesh(body, values).volume()
    }

    /// What OpenSCAD says against these values.
    pub fn refusal(&self, body: &str, values: Values) -> String {
        self.run(body, values).stl("refused").refusal()
    }

    pub fn has(&self, body: &str, parameter: &str) -> bool {
        let script = self.folder.join(format!("{body}.scad"));
        let text = std::fs::read_to_string(script).expect("a script");
        text.lines()
            .any(|line| line.starts_with(&format!("{parameter} = ")))
    }

    /// The embedded kernel's bodies of a changed design.
    pub fn rebuilt(&self, change: impl FnOnce(&mut Design)) -> Solids {
        let mut design = self.design.clone();
        change(&mut design);
        Solids::build(&design, &self.motion).expect("builds")
    }

    /// OpenSCAD and the embedded kernel change every body that has the parameter alike; the others
    /// do not change in the kernel, and have no such parameter in their scripts.
    pub fn agrees(&self, name: &str, value: f64, changed: &Solids) {
        let mut seen = false;
        for (old, new) in self.solids.bodies.iter().zip(&changed.bodies) {
            if !self.has(&old.name, name) {
                assert_eq!(old.mesh, new.mesh, "{name} also changes the {}", old.name);
                continue;
            }
            let mesh = self.mesh(&old.name, &[(name, &value.to_string())]);
            let plain = self.mesh(&old.name, &[]);
            let change = new.mesh.volume() - old.mesh.volume();
            let found = mesh.volume() - plain.volume();
            assert!(
                (found - change).abs() < 0.02 * change.abs() + 0.05,
                "{name} = {value}: the {} changes by {found:.3} mm³ instead of {change:.3}",
                old.name
            );
            let moved = box_change(&old.mesh, &new.mesh);
            let found = box_change(&plain, &mesh);
            for (found, moved) in found.iter().zip(moved) {
                assert!(
                    (found - moved).abs() < 2e-3,
                    "{name} = {value}: a face of the {}'s box moves by {found:.4}, not {moved:.4}",
                    old.name
                );
            }
            // Holes that only move leave volume and box as they are.
            seen |= old.mesh != new.mesh && plain != mesh;
        }
        let of_pieces = self.agrees_in_pieces(name, value, changed);
        assert!(seen || of_pieces, "{name} = {value} changes nothing");
    }

    /// The same for pieces whose bodies do not show the parameter; whether there are any.
    pub fn agrees_in_pieces(&self, name: &str, value: f64, changed: &Solids) -> bool {
        let mut seen = false;
        for (old, new) in self.solids.pieces.iter().zip(&changed.pieces) {
            let body = |solids: &Solids| {
                let found = solids.bodies.iter().find(|b| b.name == old.body);
                found.expect("a body").mesh.clone()
            };
            let change = new.mesh.volume() - old.mesh.volume();
            if change.abs() < 0.02 || body(&self.solids) != body(changed) {
                continue;
            }
            let (piece, value) = (format!("\"{}\"", old.name), value.to_string());
            let whole = ("piece", piece.as_str());
            let found =
                self.volume(&old.body, &[whole, (name, &value)]) - self.volume(&old.body, &[whole]);
            assert!(
                (found - change).abs() < 0.02 * change.abs() + 0.05,
                "{name} = {value}: {} changes by {found:.3} mm³ instead of {change:.3}",
                old.name
            );
            seen = true;
        }
        seen
    }

    /// Every free parameter of the recipe, halfway to the farther end of its range.
    pub fn recipe_parameters_agree(&self, groups: &[&str]) {
        let parameters = &self.design.recipe.parameters;
        for (i, p) in parameters.iter().enumerate() {
            if p.min >= p.max || !groups.contains(&p.group.as_str()) {
                continue;
            }
            let bodies = &self.solids.bodies;
            if !bodies.iter().any(|body| self.has(&body.name, &p.name)) {
                continue;
            }
            let end = match p.max - p.value > p.value - p.min {
                true => p.max,
                false => p.min,
            };
            let value = (5e3 * (p.value + end)).round() / 1e4;
            let changed = self.rebuilt(|d| d.recipe.parameters[i].value = value);
            eprintln!("{} = {value}", p.name);
            self.agrees(&p.name, value, &changed);
        }
    }

    /// The flanks of sub-gear pair `k`, from 0.
    pub fn flank_agrees(&self, k: usize, radius: f64) {
        let changed = self.rebuilt(|d| d.sub_gear_pairs[k].flank_radius = Some(radius));
        self.agrees(&format!("flank_radius_{}", k + 1), radius, &changed);
    }

    pub fn section_agrees(&self, name: &str, value: f64, change: impl FnOnce(&mut Section)) {
        let changed = self.rebuilt(|d| change(&mut d.section));
        self.agrees(name, value, &changed);
    }
}

/// How far the six faces of the bounding box move.
pub fn box_change(old: &Mesh, new: &Mesh) -> [f64; 6] {
    let ((a, b), (c, d)) = (old.bounds(), new.bounds());
    let (low, high) = (c - a, d - b);
    [low.x, low.y, low.z, high.x, high.y, high.z]
}

/// Area of the regular polygon that stands for a circle with 24 or 48 corners.
pub fn disc(radius: f64) -> f64 {
    let n = if radius < 2.5 { 24.0 } else { 48.0 };
    0.5 * n * radius * radius * (TAU / n).sin()
}

pub fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() < tolerance,
        "{what}: {found:.3} instead of {expected:.3}"
    );
}
