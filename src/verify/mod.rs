//! Proof on the meshes, independent of the optimiser: nothing meets over the whole turn, the
//! follower cannot escape, walls hold, every mesh bounds one solid.

mod apart;
mod check;
mod claim;
mod collide;
mod conjugation;
mod escape;
mod fabrication;
mod failure;
mod hold;
mod insertion;
mod joints;
mod kept;
mod mechanism;
pub mod mesh;
mod overlap;
mod play;
mod settle;
pub mod thickness;
mod touching;
mod tree;
mod triangle;

pub use check::{Check, CheckInput, Effort, check, examine};
pub use claim::{Claim, Spot};
pub use escape::{Escape, directions, displacement};
pub use fabrication::{OVERHANG_DEG, Overhang, Printer};
pub use failure::{Failure, Recognised};
pub use hold::{PAYLOAD, Play};
pub use mechanism::Mechanism;
pub use mesh::{Defect, MeshProblem};
pub use overlap::{PairProof, Place};
pub use thickness::{Wall, WallSettings};
pub use touching::Touching;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use crate::design::ClosureSample;
use crate::solid::assembly::{Carrier, SolidBody};
use crate::{Error, Result};
use escape::Held;
use overlap::{OverlapSettings, Part};

/// How densely to look and what to demand.
#[derive(Debug, Clone, PartialEq)]
pub struct ProofSettings {
    /// Least number of parts the turn is cut into to look for gaps. Default 360.
    pub phases: usize,
    /// Phases at which escapes are tried. Default 72.
    pub escape_phases: usize,
    /// Directions of span(U) tried at each. Default 32.
    pub directions: usize,
    /// Flank-to-flank gap of the design, mm: the displacement tried is 1.5 of it over Q. Default 0.1.
    pub clearance_mm: f64,
    /// Every part is grown by this before it must stay clear of the others, mm. Default 0.
    pub grown_by_mm: f64,
    /// Smallest wall demanded, mm. Default 0.8.
    pub minimum_wall_mm: f64,
}

impl Default for ProofSettings {
    fn default() -> Self {
        ProofSettings {
            phases: 360,
            escape_phases: 72,
            directions: 32,
            clearance_mm: 0.1,
            grown_by_mm: 0.0,
            minimum_wall_mm: 0.8,
        }
    }
}

/// What the meshes prove, or where they fail to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proof {
    /// Every two bodies that move against each other.
    pub pairs: Vec<PairProof>,
    /// Displacements that no driver tooth stops.
    pub escapes: Vec<Escape>,
    /// Number of displacements tried.
    pub displacements: usize,
    /// Thinnest wall of each body; `None` when it is thicker than all that was looked for.
    pub walls: Vec<(String, Option<Wall>)>,
    /// Wall demanded, mm.
    pub minimum_wall_mm: f64,
    /// Every part was grown by this, mm.
    pub grown_by_mm: f64,
    /// Least number of steps of the turn.
    pub steps: usize,
    /// Defects of the meshes.
    pub mesh_problems: Vec<MeshProblem>,
}

impl Proof {
    /// Whether everything holds.
    pub fn holds(&self) -> bool {
        self.problems().is_empty()
    }

    /// Largest shared volume of two bodies, mm³; infinite when bodies meet and it cannot be measured.
    pub fn overlap_max_mm3(&self) -> f64 {
        self.pairs
            .iter()
            .map(|p| p.overlap_mm3.unwrap_or(f64::INFINITY))
            .fold(0.0, f64::max)
    }

    /// Thinnest wall of all bodies, mm, as far as walls were looked for.
    pub fn wall_min_mm(&self) -> Option<f64> {
        self.walls
            .iter()
            .filter_map(|(_, w)| w.map(|w| w.thickness_mm))
            .min_by(f64::total_cmp)
    }

    /// Everything that fails, one plain sentence each; empty when the mechanism is proven.
    pub fn problems(&self) -> Vec<String> {
        let mut all: Vec<String> = self.mesh_problems.iter().map(ToString::to_string).collect();
        for pair in &self.pairs {
            let [a, b] = &pair.bodies;
            if let Some(place) = &pair.overlap_at {
                let volume = pair
                    .overlap_mm3
                    .map_or("an unmeasurable volume".into(), |v| format!("{v:.4} mm³"));
                all.push(format!(
                    "{a} and {b} overlap by up to {volume} in {} steps of the turn, worst at {place}",
                    pair.colliding_steps
                ));
            } else if let Some(place) = pair.doubts.first() {
                let gap = match self.grown_by_mm {
                    0.0 => String::new(),
                    grown => format!(" by {:.3} mm", 2.0 * grown),
                };
                all.push(format!(
                    "{a} and {b} are not proven apart{gap}, first doubt at {place}"
                ));
            }
        }
        if let Some(e) = self.escapes.first() {
            all.push(format!(
                "the follower escapes in {} of {} displacements, first at φ = {:.1}°",
                self.escapes.len(),
                self.displacements,
                e.phi.to_degrees()
            ));
        }
        for (body, wall) in &self.walls {
            if let Some(wall) = wall.filter(|w| w.thickness_mm < self.minimum_wall_mm) {
                let [x, y, z] = wall.at;
                all.push(format!(
                    "the {body} has a wall of {:.3} mm at ({x:.2}, {y:.2}, {z:.2}) mm; {:.3} mm wanted",
                    wall.thickness_mm, self.minimum_wall_mm
                ));
            }
        }
        all
    }
}

/// Told what is being proven and how much of it is done, 0 to 1; `Break` stops.
pub type Progress<'a> = dyn FnMut(&'static str, f64) -> ControlFlow<()> + 'a;

/// Proves a mechanism from its meshes. `bodies` are in their own frames ([`Mechanism::assembled`] brings
/// them there from files); `closure` is Q
/// over the period, ascending in φ.
///
/// # Errors
/// [`Error::Interrupted`] when `progress` breaks; [`Error::Internal`] when a driver or follower is
/// missing or `closure` is empty.
pub fn prove(
    bodies: &[SolidBody],
    mechanism: &Mechanism,
    (settings, closure): (&ProofSettings, &[ClosureSample]),
    progress: &mut Progress,
) -> Result<Proof> {
    let mut step = |what: &'static str, done: f64| match progress(what, done) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    };
    let mut mesh_problems = Vec::new();
    let mut walls = Vec::new();
    for (i, body) in bodies.iter().enumerate() {
        step("proof: walls", 0.3 * i as f64 / bodies.len() as f64)?;
        let problems = mesh::problems(&body.name, &body.mesh);
        let unusable = problems.iter().any(MeshProblem::is_no_surface);
        mesh_problems.extend(problems);
        if unusable {
            return Ok(Proof {
                pairs: Vec::new(),
                escapes: Vec::new(),
                displacements: 0,
                walls,
                minimum_wall_mm: settings.minimum_wall_mm,
                grown_by_mm: settings.grown_by_mm,
                steps: settings.phases,
                mesh_problems,
            });
        }
        let wall = thickness::thinnest(
            &body.mesh,
            &WallSettings {
                up_to: 1.25 * settings.minimum_wall_mm,
                spacing: 0.3 * settings.minimum_wall_mm,
            },
        );
        walls.push((body.name.clone(), wall));
    }
    let parts: Vec<Part> = bodies.iter().map(Part::new).collect();
    let moving: Vec<(usize, usize)> = (0..parts.len())
        .flat_map(|i| (i + 1..parts.len()).map(move |j| (i, j)))
        .filter(|&(i, j)| parts[i].body.carrier != parts[j].body.carrier)
        .collect();
    let overlap = OverlapSettings {
        steps: settings.phases,
        floor: 2.0 * settings.grown_by_mm,
    };
    let mut pairs = Vec::new();
    for (done, &(i, j)) in moving.iter().enumerate() {
        step(
            "proof: overlap",
            0.3 + 0.5 * done as f64 / moving.len() as f64,
        )?;
        pairs.push(overlap::apart((&parts[i], &parts[j]), mechanism, &overlap));
    }
    step("proof: escapes", 0.8)?;
    let find = |carrier: Carrier| {
        parts
            .iter()
            .find(|p| p.body.carrier == carrier)
            .ok_or_else(|| Error::Internal(format!("no {carrier:?} among the bodies to prove")))
    };
    let held = Held {
        driver: find(Carrier::Driver)?,
        follower: find(Carrier::Follower)?,
        mechanism: *mechanism,
    };
    let directions = directions(mechanism.motion.class(), settings.directions);
    let cycle = mechanism.motion.cycle();
    let tries = cycle
        .phases(settings.escape_phases)
        .map(|phi| {
            let q = q_at(closure, phi)
                .ok_or_else(|| Error::Internal("no Q to size the displacements by".into()))?;
            Ok((phi, (q > 0.0).then(|| 1.5 * settings.clearance_mm / q)))
        })
        .collect::<Result<Vec<_>>>()?;
    let escapes = held.escapes(&tries, &directions);
    step("proof: escapes", 1.0)?;
    Ok(Proof {
        pairs,
        escapes,
        displacements: tries.len() * directions.len(),
        walls,
        minimum_wall_mm: settings.minimum_wall_mm,
        grown_by_mm: settings.grown_by_mm,
        steps: settings.phases,
        mesh_problems,
    })
}

/// Q at the sample nearest to `phi`.
fn q_at(closure: &[ClosureSample], phi: f64) -> Option<f64> {
    let distance = |s: &ClosureSample| {
        let d = (s.phi - phi).rem_euclid(TAU);
        d.min(TAU - d)
    };
    closure
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .map(|s| s.q)
}
