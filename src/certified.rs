//! A lower bound of Q for every φ, between the sampled ones as well.
//!
//! Q is 1-Lipschitz in the wrenches: if every n̄_k stays within r of a value, Q stays within r of Q of
//! those values (each d·n̄_k changes by r at most, whatever d). Between two stations a wrench is the
//! polynomial of degree five through the six stations around them, which lies in the hull of its
//! Bernstein coefficients. So Q ≥ Q(middles) − max_k max_b |coefficient − middle| over the whole
//! stretch, exact for the curve through the stations; that curve is off the true one by less than 1e-8
//! of its size at the usual 200 stations a tooth.

use nalgebra::{Matrix6, Matrix6x4, RowVector4, Vector3};

use crate::closure::{Wrench, measure, wrench};
use crate::design::{Design, Station, ToothPair};
use crate::load::contacts::{WINDOW, active_tooth, weights, window};
use crate::motion::Motion;

/// Lower bounds of min Q and min Q* over all φ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certified {
    /// Of min Q, in its unit.
    pub q: f64,
    /// Of min Q*.
    pub q_star: f64,
    /// Middle of the stretch where that of Q is least, rad.
    pub phi: f64,
}

/// Stations of different pairs closer than this belong together, rad.
const SAME: f64 = 1e-9;

/// The bounds of `design`; `None` where some φ has no contact, a tooth has too few stations, or the
/// pairs do not share their stations.
pub fn of(design: &Design, motion: &Motion) -> Option<Certified> {
    let lead = design.sub_gear_pairs.first()?;
    let to_bernstein: Vec<Matrix6<f64>> = (0..WINDOW - 1).map(bernstein).collect::<Option<_>>()?;
    let half_distance = 0.5 * design.settings.gear.center_distance_mm;
    let mut least: Option<Certified> = None;
    for (j, tooth) in lead.teeth.iter().enumerate() {
        for ends in tooth.stations.windows(2) {
            let middle = 0.5 * (ends[0].phi + ends[1].phi);
            let here = |phi: f64| active_tooth(lead, phi).is_some_and(|(active, _)| active == j);
            if ![ends[0].phi, middle, ends[1].phi].into_iter().any(here) {
                continue;
            }
            let stretches = design.sub_gear_pairs.iter().map(|pair| {
                let stretch = Stretch::of(pair.teeth.get(j)?, ends[0].phi)?;
                Some((stretch, &to_bernstein[stretch.offset]))
            });
            let stretches: Vec<_> = stretches.collect::<Option<_>>()?;
            let bound = |length: f64| -> f64 {
                let (mut middles, mut radius) = (Vec::new(), 0.0f64);
                for (stretch, to_bernstein) in &stretches {
                    let (middle, size) = stretch.ball(to_bernstein, (motion, length));
                    middles.push(middle);
                    radius = radius.max(size);
                }
                measure(&middles, design.class.dof()) - radius
            };
            let (q, q_star) = (bound(1.0), bound(half_distance));
            let before = least.unwrap_or(Certified {
                q: f64::INFINITY,
                q_star: f64::INFINITY,
                phi: middle,
            });
            least = Some(Certified {
                q: q.min(before.q),
                q_star: q_star.min(before.q_star),
                phi: if q < before.q { middle } else { before.phi },
            });
        }
    }
    covered(design).then_some(least).flatten()
}

/// Whether every φ has a contact of every pair: the contact intervals of its teeth leave no gap.
fn covered(design: &Design) -> bool {
    design.sub_gear_pairs.iter().all(|pair| {
        let ends = pair.teeth.iter().map(|t| t.phi_end);
        ends.clone().count() > 0
            && ends
                .into_iter()
                .all(|end| active_tooth(pair, end).is_some())
    })
}

/// The stations around one stretch between two of them.
#[derive(Clone, Copy)]
struct Stretch<'a> {
    window: &'a [Station],
    /// Place of the stretch within the window.
    offset: usize,
}

impl<'a> Stretch<'a> {
    /// The stretch of `tooth` that begins at `phi`.
    fn of(tooth: &'a ToothPair, phi: f64) -> Option<Stretch<'a>> {
        let stations = &tooth.stations;
        let start = stations.iter().position(|s| (s.phi - phi).abs() < SAME)?;
        if stations.len() < WINDOW {
            return None;
        }
        let first = window(start, stations.len());
        Some(Stretch {
            window: &stations[first..first + WINDOW],
            offset: start - first,
        })
    }

    /// A ball that holds the wrench all along the stretch: its centre and radius.
    fn ball(&self, to_bernstein: &Matrix6<f64>, (motion, length): (&Motion, f64)) -> (Wrench, f64) {
        let rows: Vec<RowVector4<f64>> = self
            .window
            .iter()
            .map(|s| {
                let centre = motion.joint_centre(s.phi);
                let (p, n) = (Vector3::from(s.p), Vector3::from(s.n));
                RowVector4::from(wrench(motion.class(), p, n, centre, length))
            })
            .collect();
        let hull: Matrix6x4<f64> = to_bernstein * Matrix6x4::from_rows(&rows);
        let middle = 0.5 * (hull.row(0) + hull.row(WINDOW - 1));
        let radius = hull.row_iter().map(|b| (b - middle).norm());
        (
            [middle[0], middle[1], middle[2], middle[3]],
            radius.fold(0.0, f64::max),
        )
    }
}

/// From values at the nodes 0..6 to Bernstein coefficients on `[offset, offset + 1]` of the polynomial
/// through them: its values at six points there, then those of the Bernstein polynomials undone.
fn bernstein(offset: usize) -> Option<Matrix6<f64>> {
    let at = |row: usize| row as f64 / (WINDOW - 1) as f64;
    let lagrange = Matrix6::from_fn(|row, i| weights(offset as f64 + at(row))[0][i]);
    let choose = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
    let basis = Matrix6::from_fn(|row, i| {
        let u = at(row);
        choose[i] * u.powi(i as i32) * (1.0 - u).powi((WINDOW - 1 - i) as i32)
    });
    Some(basis.try_inverse()? * lagrange)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A polynomial of degree five stays within the hull of its Bernstein coefficients, and meets the
        /// first and the last.
        #[test]
        fn coefficients_enclose_the_polynomial(
            values in prop::array::uniform6(-1.0f64..1.0),
            offset in 0usize..5,
        ) {
            let rows: Vec<RowVector4<f64>> =
                values.iter().map(|&v| RowVector4::new(v, 0.0, 0.0, 0.0)).collect();
            let hull = bernstein(offset).expect("regular") * Matrix6x4::from_rows(&rows);
            let column: Vec<f64> = hull.column(0).iter().copied().collect();
            prop_assert!((column[0] - values[offset]).abs() < 1e-9);
            prop_assert!((column[5] - values[offset + 1]).abs() < 1e-9);
            let (lo, hi) = column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &x| {
                (lo.min(x), hi.max(x))
            });
            for step in 0..=50 {
                let x = offset as f64 + f64::from(step) / 50.0;
                let value: f64 = (0..6).map(|i| {
                    let factor = |m: usize| (x - m as f64) / (i as f64 - m as f64);
                    values[i] * (0..6).filter(|&m| m != i).map(factor).product::<f64>()
                }).sum();
                prop_assert!(value >= lo - 1e-9 && value <= hi + 1e-9);
            }
        }
    }
}
