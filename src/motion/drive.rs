//! How the driver turns: about the line x = −L, y = 0, parallel to z, at a constant rate.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{MotionState, Pose};

/// The driver's law. While the phase φ of the motion grows by a period, 2π, the driver turns by one
/// m-th of a turn: it has m times as many teeth as the follower, so that everything that happens in
/// a period happens at m places around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    center_distance: f64,
    copies: usize,
}

impl Drive {
    /// About the axis at `center_distance` (mm) from O, with `copies` (m ≥ 1) times the follower's teeth.
    pub fn new(center_distance: f64, copies: usize) -> Drive {
        Drive {
            center_distance,
            copies: copies.max(1),
        }
    }

    /// L, mm.
    pub fn center_distance(self) -> f64 {
        self.center_distance
    }

    /// m: how often the teeth of one period stand around the driver.
    pub fn copies(self) -> usize {
        self.copies
    }

    /// ω₁: driver angle per phase.
    pub fn rate(self) -> f64 {
        1.0 / self.copies as f64
    }

    /// Phase by which the driver has made one turn, rad.
    pub fn period(self) -> f64 {
        TAU * self.copies as f64
    }

    /// A point of the driver's axis, mm.
    pub fn axis_point(self) -> Vector3<f64> {
        Vector3::new(-self.center_distance, 0.0, 0.0)
    }

    /// Distance of the pitch point from the follower's axis when that turns against the driver at `turning`
    /// per phase, mm.
    pub fn follower_pitch_radius(self, turning: f64) -> f64 {
        self.center_distance * self.rate() / (self.rate() + turning)
    }

    /// That radius in those of a follower as large as its driver.
    pub fn follower_share(self, turning: f64) -> f64 {
        2.0 * self.rate() / (self.rate() + turning)
    }

    /// State of the driver at phase `phi` (rad), derivatives per radian of it.
    pub fn state(self, phi: f64) -> MotionState {
        let axis_point = self.axis_point();
        let rotation =
            Rotation3::from_axis_angle(&Vector3::z_axis(), phi * self.rate()).into_inner();
        let omega = Vector3::z() * self.rate();
        MotionState {
            pose: Pose {
                rotation,
                translation: axis_point - rotation * axis_point,
            },
            omega,
            v_origin: -omega.cross(&axis_point),
            omega_rate: Vector3::zeros(),
            v_origin_rate: Vector3::zeros(),
        }
    }

    /// Where copy `copy` of what is on the driver stands, in the driver's frame: it meets the follower as
    /// many periods later.
    pub fn copy(self, copy: usize) -> Pose {
        let axis_point = self.axis_point();
        let rotation = match copy % self.copies {
            0 => Matrix3::identity(),
            copy => {
                let angle = -TAU * copy as f64 * self.rate();
                Rotation3::from_axis_angle(&Vector3::z_axis(), angle).into_inner()
            }
        };
        Pose {
            rotation,
            translation: axis_point - rotation * axis_point,
        }
    }

    /// Which copy of a tooth whose contact is around phase `middle` is nearest to its mate at `phi`.
    pub fn nearest(self, phi: f64, middle: f64) -> usize {
        let periods = ((phi - middle) / TAU).round() as i64;
        periods.rem_euclid(self.copies as i64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_copy_stands_a_period_later_where_its_tooth_stood() {
        let drive = Drive::new(30.0, 3);
        let tooth = Vector3::new(-11.0, 2.0, 7.0);
        for (phi, periods) in [(0.4, 1), (2.0, 2), (5.0, 4)] {
            let later = drive.state(phi + TAU * f64::from(periods)).pose;
            let copy = drive.copy(periods as usize).apply(tooth);
            let before = drive.state(phi).pose.apply(tooth);
            assert_relative_eq!(later.apply(copy), before, epsilon = 1e-12);
            assert_eq!(
                drive.nearest(phi + TAU * f64::from(periods), phi + 1.0),
                periods as usize % 3
            );
        }
        let state = drive.state(1.0);
        let after = drive.state(1.0 + 1e-6).pose.apply(tooth);
        let speed = (after - state.pose.apply(tooth)) / 1e-6;
        assert_relative_eq!(
            speed,
            state.velocity(state.pose.apply(tooth)),
            epsilon = 1e-5
        );
        assert_relative_eq!(state.velocity(drive.axis_point()).norm(), 0.0);
    }
}
