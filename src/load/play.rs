//! How far the follower can move inside the flank gap.

use nalgebra::{DMatrix, DVector, Vector3};

use super::contacts::Configuration;
use crate::closure::next_subset;

/// Free motion of the follower with the driver held, first order in the gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Play {
    /// Largest turn, rad.
    pub turn: f64,
    /// Largest shift of the joint along its sliding axis, mm; 0 where it cannot slide.
    pub slide: f64,
    /// Largest displacement of the point asked for, mm.
    pub point: f64,
    /// Displacement of that point where the load leaves it, against the pose without gap, mm.
    pub sag: f64,
}

/// Play at `at` with flank gap `gap` (mm), seen at `point` (Σ), and resting under the projected
/// `load`. The free poses ξ with n̄_k·ξ ≥ −gap form a polytope; every figure is largest at one of
/// its corners. `None` when it is not bounded (no form closure).
pub fn play(
    at: &Configuration,
    gap: f64,
    point: Vector3<f64>,
    load: &DVector<f64>,
) -> Option<Play> {
    let columns = columns(at);
    if !super::forces::closed(&columns) {
        return None;
    }
    within(at, &columns, &vec![gap; columns.len()], (point, load))
}

/// [`play`] with a gap (mm, not negative) for each contact, of a follower that is known to be form closed.
pub fn within(
    at: &Configuration,
    columns: &[DVector<f64>],
    gaps: &[f64],
    (point, load): (Vector3<f64>, &DVector<f64>),
) -> Option<Play> {
    let dof = at.class.dof();
    let mut play = Play {
        turn: 0.0,
        slide: 0.0,
        point: 0.0,
        sag: 0.0,
    };
    let mut lowest = f64::NEG_INFINITY;
    let mut subset: Vec<usize> = (0..dof).collect();
    let mut more = true;
    while more {
        let here = subset.clone();
        more = next_subset(&mut subset, columns.len());
        let rows: Vec<_> = here.iter().map(|&i| columns[i].transpose()).collect();
        let Some(corner) = DMatrix::from_rows(&rows)
            .lu()
            .solve(&DVector::from_iterator(dof, here.iter().map(|&i| -gaps[i])))
        else {
            continue;
        };
        let leaves = |(c, gap): (&DVector<f64>, &f64)| c.dot(&corner) < -gap * (1.0 + 1e-9) - 1e-12;
        if columns.iter().zip(gaps).any(leaves) {
            continue;
        }
        let (shift, turn) = motion(at, &corner);
        let moved = (shift + turn.cross(&(point - at.centre))).norm();
        play.turn = play.turn.max(turn.norm());
        play.slide = play.slide.max(shift.norm());
        play.point = play.point.max(moved);
        if load.dot(&corner) > lowest {
            (lowest, play.sag) = (load.dot(&corner), moved);
        }
    }
    lowest.is_finite().then_some(play)
}

/// Projected normals n̄_k at `at`.
pub fn columns(at: &Configuration) -> Vec<DVector<f64>> {
    at.contacts
        .iter()
        .map(|c| at.class.project(c.p, c.n, at.centre))
        .collect()
}

/// Shift of the joint centre and turn about it that coordinates of span(U) stand for.
pub fn motion(at: &Configuration, xi: &DVector<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let slides = usize::from(at.class.slides());
    let shift = Vector3::z() * if slides == 1 { xi[0] } else { 0.0 };
    let turn = if at.class.is_spherical() {
        Vector3::new(xi[slides], xi[slides + 1], xi[slides + 2])
    } else {
        Vector3::z() * xi[slides]
    };
    (shift, turn)
}
