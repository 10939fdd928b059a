//! All solids of a mechanism: rigid bodies in assembled position, and the pieces to print.

use rayon::prelude::*;

use super::expression::Values;
use super::kernel::{self, Solid};
use super::recipe::{Body, Recipe};
use super::rib::Wall;
use super::{Mesh, layout, primitive, sweep};
use crate::design::{Design, Gear};
use crate::motion::{Drive, Motion, Pose};
use crate::{Error, Result};

/// How a body moves with φ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carrier {
    /// Turns about the driver axis.
    Driver,
    /// Follows M²(φ).
    Follower,
    /// Does not move.
    Support,
    /// Moves with the joint centre.
    Slider,
}

impl Carrier {
    /// Pose in Σ, at `phi`, of a body whose mesh is given in its own frame (driver and support in
    /// Σ at φ = 0, follower in the follower frame, slider in Σ at zero lift).
    pub fn pose(self, motion: &Motion, drive: Drive, phi: f64) -> Pose {
        match self {
            Carrier::Driver => drive.state(phi).pose,
            Carrier::Follower => motion.state(phi).pose,
            Carrier::Support => still(nalgebra::Vector3::zeros()),
            Carrier::Slider => still(motion.joint_centre(phi)),
        }
    }
}

fn still(translation: nalgebra::Vector3<f64>) -> Pose {
    Pose {
        rotation: nalgebra::Matrix3::identity(),
        translation,
    }
}

/// One rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidBody {
    /// `driver`, `follower`, `support`, `slider`.
    pub name: String,
    /// How it moves.
    pub carrier: Carrier,
    /// Its surface in its own frame ([`Carrier::pose`]), one closed component, outward winding, mm.
    pub mesh: Mesh,
}

/// One piece to print.
#[derive(Debug, Clone, PartialEq)]
pub struct PrintPiece {
    /// File name stem.
    pub name: String,
    /// Body it belongs to.
    pub body: String,
    /// Its surface, lying on z = 0, centred in x and y, mm.
    pub mesh: Mesh,
    /// How many are needed.
    pub count: u32,
}

/// Everything that is made from a design.
#[derive(Debug, Clone, PartialEq)]
pub struct Solids {
    /// The recipe that the bodies were built from.
    pub recipe: Recipe,
    /// Rigid bodies.
    pub bodies: Vec<SolidBody>,
    /// Pieces to print.
    pub pieces: Vec<PrintPiece>,
}

impl Solids {
    /// Builds every body and piece of a design, from its recipe if it has one.
    ///
    /// # Errors
    /// [`Error::Infeasible`] for teeth that fold or motions without room for the joint,
    /// [`Error::Internal`] when a body does not come out as one closed solid.
    pub fn build(design: &Design, motion: &Motion) -> Result<Solids> {
        let recipe = match design.recipe.bodies.is_empty() {
            true => layout::recipe(design, motion)?,
            false => design.recipe.clone(),
        };
        let built: Result<Vec<(SolidBody, Vec<PrintPiece>)>> = recipe
            .bodies
            .par_iter()
            .map(|body| build_body(design, &recipe, body))
            .collect();
        let (bodies, pieces): (Vec<_>, Vec<_>) = built?.into_iter().unzip();
        Ok(Solids {
            recipe,
            bodies,
            pieces: pieces.into_iter().flatten().collect(),
        })
    }

    /// The mesh of a body in Σ at phase `phi`.
    pub fn placed(&self, body: &SolidBody, design: &Design, motion: &Motion, phi: f64) -> Mesh {
        let drive = design.settings.gear.drive();
        body.mesh.moved(&body.carrier.pose(motion, drive, phi))
    }
}

fn build_body(
    design: &Design,
    recipe: &Recipe,
    body: &Body,
) -> Result<(SolidBody, Vec<PrintPiece>)> {
    let values = Values::new(&recipe.parameters);
    let mut solid = primitive::build(&body.features, &values)?;
    if let Some(gear) = body.teeth {
        solid = solid.union(&teeth(design, gear)?);
    }
    let mesh = solid.one_body(&body.name)?;
    let mut pieces = Vec::new();
    for piece in &body.pieces {
        let solid = primitive::build(&piece.features, &values)?;
        let mesh = solid.one_body(&piece.name)?;
        pieces.push(print_piece(&piece.name, body, mesh, piece.up));
    }
    if pieces.is_empty() {
        pieces.push(print_piece(&body.name, body, mesh.clone(), [0.0, 0.0, 1.0]));
    }
    let foot = design.settings.fit.elephant_foot_mm;
    for piece in pieces.iter_mut().filter(|_| foot > 0.0) {
        let solid = Solid::new(&piece.mesh, &piece.name)?;
        piece.mesh = solid.foot_drawn_in(foot).one_body(&piece.name)?;
    }
    let carrier = match body.name.as_str() {
        "driver" => Carrier::Driver,
        "follower" => Carrier::Follower,
        "support" => Carrier::Support,
        "slider" => Carrier::Slider,
        other => return Err(Error::Internal(format!("unknown body `{other}`"))),
    };
    let body = SolidBody {
        name: body.name.clone(),
        carrier,
        mesh,
    };
    Ok((body, pieces))
}

/// All teeth of a gear with their ribs, in its frame.
///
/// # Errors
/// [`Error::Infeasible`] when a tooth or rib folds, [`Error::Internal`] when the kernel fails.
pub fn teeth(design: &Design, gear: Gear) -> Result<Solid> {
    let axis = sweep::axis_point(gear, design.settings.gear.center_distance_mm);
    let foot = layout::rib_foot(design, gear);
    let mut solids = Vec::new();
    for tooth in sweep::standing(design, gear, sweep::MAX_STATIONS) {
        let (number, k) = (tooth.number + 1, tooth.pair + 1);
        let place = format!("{gear:?} tooth {number} of sub-gear pair {k}").to_lowercase();
        let section = design.section_of(&design.sub_gear_pairs[tooth.pair]);
        let bead = sweep::tooth(&tooth.frames, &section, &place)?;
        let wall = Wall {
            section,
            axis,
            foot,
            flare: tooth.flare,
        };
        let wall = wall.mesh(&tooth.frames, &place)?;
        solids.push(Solid::new(&bead, &place)?.union_resolved(&Solid::new(&wall, &place)?));
    }
    Ok(Solid::union_of(&solids))
}

/// Turns a mesh so that `up` points up, and sets it on z = 0 around the origin.
fn print_piece(name: &str, body: &Body, mesh: Mesh, up: [f64; 3]) -> PrintPiece {
    let rotation = kernel::towards(nalgebra::Vector3::from(up)).transpose();
    let mut pose = Pose {
        rotation,
        translation: nalgebra::Vector3::zeros(),
    };
    let (lo, hi) = mesh.moved(&pose).bounds();
    pose.translation = nalgebra::Vector3::new(-0.5 * (lo.x + hi.x), -0.5 * (lo.y + hi.y), -lo.z);
    PrintPiece {
        name: name.into(),
        body: body.name.clone(),
        mesh: mesh.moved(&pose),
        count: 1,
    }
}
