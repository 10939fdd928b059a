//! The rib ("spoke") that carries a tooth: a ruled wall from the bead straight towards the hub axis, which
//! may thicken on its way.

use nalgebra::Vector3;

use super::Mesh;
use super::sweep::{self, Frame};
use crate::design::Section;
use crate::sub_gear::SHORTEST_RIB;
use crate::{Error, Result};

/// Thickness at the bead's middle as a share of the rib's: corners that lay on the surface of a bead as
/// thick as the rib would show through it as crumbs.
const TUCKED: f64 = 0.97;

/// Frames left out at both ends of a tooth: rib and bead end in planes of different slant, and where
/// they met they would leave thin corners.
pub const INSET: usize = 1;

/// Those of a tooth's frames that its rib spans: all but [`INSET`] at both ends, where there are enough.
pub fn span<T>(frames: &[T]) -> &[T] {
    match frames.len() > 4 * INSET {
        true => &frames[INSET..frames.len() - INSET],
        false => frames,
    }
}

/// The two ends of the rib's middle line at one station, and the unit vector across it: from the
/// bead's centre horizontally to `inner_radius` from the hub axis through `axis`; the wall is
/// `section.rib` thick along T × radial ([`Wall::mesh`]), hence everywhere within the bead's shadow.
pub fn line(
    frame: &Frame,
    section: &Section,
    axis: Vector3<f64>,
    inner_radius: f64,
) -> [Vector3<f64>; 3] {
    let outer = frame.place([0.5 * (section.clearance + section.thickness), 0.0]);
    let mut radial = outer - axis;
    radial.z = 0.0;
    let distance = radial.norm();
    let radial = radial / distance;
    let inner = outer - (distance - inner_radius) * radial;
    let across = frame.t.cross(&radial);
    [outer, inner, across / across.norm()]
}

/// A rib, but for where its tooth runs.
#[derive(Debug, Clone, Copy)]
pub struct Wall {
    /// Of the tooth.
    pub section: Section,
    /// A point of the hub's axis.
    pub axis: Vector3<f64>,
    /// How far from the axis ribs end, inside the hub, mm.
    pub foot: f64,
    /// By how much it is thicker there than at the bead, mm: on the side that T × radial points to, and on
    /// the other.
    pub flare: [f64; 2],
}

impl Wall {
    /// How far from the axis the rib of the tooth along `frames` ends, mm.
    pub fn reaches_to(&self, frames: &[Frame]) -> f64 {
        let nearest = frames
            .iter()
            .map(|f| {
                (line(f, &self.section, self.axis, 0.0)[0] - self.axis)
                    .xy()
                    .norm()
            })
            .fold(f64::INFINITY, f64::min);
        self.foot.min(SHORTEST_RIB * nearest)
    }

    /// Thickness to either side of the middle, mm, at a `share` of the way from the bead to the foot.
    pub fn halves(&self, share: f64) -> [f64; 2] {
        self.flare
            .map(|flare| 0.5 * self.section.rib + share * flare)
    }

    /// The closed mesh of the rib of the tooth along `frames`, outward winding, from the bead to its foot.
    ///
    /// # Errors
    /// [`Error::Infeasible`] when the wall folds: the tooth runs towards the axis, or twists sharply.
    pub fn mesh(&self, frames: &[Frame], place: &str) -> Result<Mesh> {
        let frames = span(frames);
        let foot = self.reaches_to(frames);
        let tucked = TUCKED * self.halves(0.0)[0];
        let [left, right] = self.halves(1.0);
        let rings: Vec<Vec<Vector3<f64>>> = frames
            .iter()
            .map(|frame| {
                let [outer, inner, across] = line(frame, &self.section, self.axis, foot);
                vec![
                    outer - tucked * across,
                    outer + tucked * across,
                    inner + left * across,
                    inner - right * across,
                ]
            })
            .collect();
        if rings
            .iter()
            .flatten()
            .any(|v| !v.iter().all(|c| c.is_finite()))
        {
            return Err(Error::Infeasible {
                reason: "tooth runs straight towards the hub axis: no rib can carry it".into(),
                place: place.into(),
                hint: "smaller motion, or another seed (search.seed)".into(),
            });
        }
        sweep::skin(frames, &rings, place)
    }
}
