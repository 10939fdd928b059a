//! How each rigid body of a mechanism moves with the driver angle, and how one moves seen from another.

use nalgebra::Vector3;

use super::collide::{Affine, Drift};
use crate::motion::{Drive, Motion, MotionState, Pose};
use crate::solid::assembly::{Carrier, SolidBody};

/// The motions of all bodies of one mechanism.
#[derive(Debug, Clone, Copy)]
pub struct Mechanism<'a> {
    /// Motion of the follower.
    pub motion: &'a Motion,
    /// How the driver turns.
    pub drive: Drive,
}

impl Mechanism<'_> {
    /// Pose of a body at driver angle `phi` (rad), body frame to Σ.
    pub fn pose(&self, carrier: Carrier, phi: f64) -> Pose {
        carrier.pose(self.motion, self.drive, phi)
    }

    /// A body whose mesh is in assembled position at φ = 0 (as the files have it), in its own frame.
    pub fn assembled(&self, body: SolidBody) -> SolidBody {
        let start = self.pose(body.carrier, 0.0);
        let back = Pose {
            rotation: start.rotation.transpose(),
            translation: -(start.rotation.transpose() * start.translation),
        };
        SolidBody {
            mesh: body.mesh.moved(&back),
            ..body
        }
    }

    /// Pose, twist and twist rate of a body.
    fn state(&self, carrier: Carrier, phi: f64) -> MotionState {
        let follower = self.motion.state(phi);
        let still = MotionState {
            pose: self.pose(carrier, phi),
            omega: Vector3::zeros(),
            v_origin: Vector3::zeros(),
            omega_rate: Vector3::zeros(),
            v_origin_rate: Vector3::zeros(),
        };
        match carrier {
            Carrier::Support => still,
            Carrier::Driver => self.drive.state(phi),
            Carrier::Follower => follower,
            Carrier::Slider => {
                // The joint centre is the origin of the follower frame.
                let centre = follower.pose.translation;
                let along_z = |v: Vector3<f64>| Vector3::new(0.0, 0.0, v.z);
                MotionState {
                    v_origin: along_z(follower.velocity(centre)),
                    v_origin_rate: along_z(acceleration(&follower).at(centre)),
                    ..still
                }
            }
        }
    }

    /// `second` seen from `first` at `phi`: pose and first- and second-order motion; `remainder` as
    /// [`Mechanism::remainder`] gives it.
    pub(super) fn seen(
        &self,
        pair: (Carrier, Carrier),
        phi: f64,
        remainder: (f64, f64),
    ) -> (Pose, Drift) {
        let frame = self.pose(pair.0, phi);
        let pose = frame.inverse_mul(&self.pose(pair.1, phi));
        let (velocity, acceleration) = self.fields(pair, phi, &frame);
        (
            pose,
            Drift {
                velocity,
                acceleration,
                remainder,
            },
        )
    }

    /// Bound (r, s) of the third derivative r + s·|x| of the motion of `second` seen from `first`,
    /// mm and 1 per rad³, over 1440 steps of each period: a body point feels the acceleration field
    /// change with time, and because it moves through the field. Half as much again for what lies
    /// between the steps.
    pub(super) fn remainder(&self, pair: (Carrier, Carrier)) -> (f64, f64) {
        let steps = 1440 * self.drive.copies();
        let cycle = self.motion.cycle();
        let step = cycle.length() * self.drive.copies() as f64 / steps as f64;
        let fields = |i: usize| {
            let phi = cycle.start() + i as f64 * step;
            self.fields(pair, phi, &self.pose(pair.0, phi))
        };
        let mut before = fields(0).1;
        let mut bound = (0.0_f64, 0.0_f64);
        for i in 1..=steps {
            let (velocity, now) = fields(i);
            let rate = Affine {
                constant: (now.constant - before.constant) / step,
                matrix: (now.matrix - before.matrix) / step,
            };
            let steepness = now.matrix.norm();
            bound.0 = bound
                .0
                .max(rate.constant.norm() + steepness * velocity.constant.norm());
            bound.1 = bound
                .1
                .max(rate.matrix.norm() + steepness * velocity.matrix.norm());
            before = now;
        }
        (1.5 * bound.0, 1.5 * bound.1)
    }

    /// Velocity and acceleration of `second`'s points in `first`'s moving frame, as fields over
    /// that frame's present coordinates.
    fn fields(&self, pair: (Carrier, Carrier), phi: f64, frame: &Pose) -> (Affine, Affine) {
        let (a, b) = (self.state(pair.0, phi), self.state(pair.1, phi));
        let velocity = Affine {
            constant: b.v_origin - a.v_origin,
            matrix: (b.omega - a.omega).cross_matrix(),
        };
        let (of_a, of_b) = (acceleration(&a), acceleration(&b));
        // Relative acceleration in a turning frame: a_b − a_a − 2 ω_a × v_rel.
        let coriolis = 2.0 * a.omega.cross_matrix();
        let acceleration = Affine {
            constant: of_b.constant - of_a.constant - coriolis * velocity.constant,
            matrix: of_b.matrix - of_a.matrix - coriolis * velocity.matrix,
        };
        (into(velocity, frame), into(acceleration, frame))
    }
}

/// Acceleration of the body point at x (Σ): d(v_origin)/dφ + ω̇ × x + ω × (v_origin + ω × x).
fn acceleration(state: &MotionState) -> Affine {
    let turn = state.omega.cross_matrix();
    Affine {
        constant: state.v_origin_rate + state.omega.cross(&state.v_origin),
        matrix: state.omega_rate.cross_matrix() + turn * turn,
    }
}

/// A field over Σ as a field over the coordinates of `frame`.
fn into(field: Affine, frame: &Pose) -> Affine {
    let back = frame.rotation.transpose();
    Affine {
        constant: back * (field.constant + field.matrix * frame.translation),
        matrix: back * field.matrix * frame.rotation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Class, MotionSource};

    #[test]
    fn drift_is_the_taylor_expansion_of_the_relative_pose() {
        let motion = Motion::new(Class::R3, &MotionSource::Uniform {}).unwrap();
        let mechanism = Mechanism {
            motion: &motion,
            drive: Drive::new(25.0, 1),
        };
        let pair = (Carrier::Driver, Carrier::Follower);
        let remainder = mechanism.remainder(pair);
        for (phi, h) in [(0.3, 1e-2), (2.0, 5e-2), (5.5, -3e-2)] {
            let (pose, drift) = mechanism.seen(pair, phi, remainder);
            let (later, _) = mechanism.seen(pair, phi + h, remainder);
            for y in [
                Vector3::new(-12.0, 1.0, 5.0),
                Vector3::new(3.0, -20.0, -9.0),
            ] {
                let x = pose.apply(y);
                let predicted =
                    x + drift.velocity.at(x) * h + drift.acceleration.at(x) * (h * h / 2.0);
                let error = (later.apply(y) - predicted).norm();
                let bound = (remainder.0 + remainder.1 * x.norm()) * f64::abs(h).powi(3) / 6.0;
                assert!(error <= bound, "error {error} beyond bound {bound}");
                assert!(
                    error > bound / 100.0,
                    "bound {bound} is of the wrong order for {error}"
                );
            }
        }
    }
}
