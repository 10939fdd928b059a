//! The rib ("spoke") that carries a tooth: a ruled wall from the bead straight towards the hub axis.

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
pub const INSET: usize = 3;

/// Those of a tooth's frames that its rib spans: all but [`INSET`] at both ends, where there are enough.
pub fn span<T>(frames: &[T]) -> &[T] {
    match frames.len() > 4 * INSET {
        true => &frames[INSET..frames.len() - INSET],
        false => frames,
    }
}

/// The two ends of the rib's middle line at one station, and the unit vector across it: from the
/// bead's centre horizontally to `inner_radius` from the hub axis through `axis`; the wall is
/// `section.rib` thick along T × radial ([`rib`]), hence everywhere within the bead's shadow.
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

/// The closed mesh of one rib, outward winding, from the beads to `inner_radius` from the hub axis
/// through `axis`, which lies inside the hub.
///
/// # Errors
/// [`Error::Infeasible`] when the wall folds: the tooth runs towards the axis, or twists sharply.
pub fn rib(
    frames: &[Frame],
    section: &Section,
    (axis, inner_radius): (Vector3<f64>, f64),
    place: &str,
) -> Result<Mesh> {
    let frames = span(frames);
    let half = 0.5 * section.rib;
    let nearest = frames
        .iter()
        .map(|f| (line(f, section, axis, 0.0)[0] - axis).xy().norm())
        .fold(f64::INFINITY, f64::min);
    let foot = inner_radius.min(SHORTEST_RIB * nearest);
    let rings: Vec<Vec<Vector3<f64>>> = frames
        .iter()
        .map(|frame| {
            let [outer, inner, across] = line(frame, section, axis, foot);
            let side = half * across;
            let tucked = TUCKED * side;
            vec![outer - tucked, outer + tucked, inner + side, inner - side]
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
