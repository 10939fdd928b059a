//! Form closure from the geometry: displaced a little in any direction of its motion space, the
//! follower must hit the driver. And its play: how far it goes until it does.

use nalgebra::{DVector, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::collide::Placed;
use super::mechanism::Mechanism;
use super::overlap::Part;
use super::play::{Facing, Screw};
use crate::motion::{Class, Pose};
use crate::solid::assembly::Carrier;

/// A displacement on whose way the driver never stops the follower.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Escape {
    /// Driver angle, rad.
    pub phi: f64,
    /// Unit direction in span(U), order linear (mm), angular (rad).
    pub direction: Vec<f64>,
    /// Length of the displacement tried; `None` when Q is not positive and none would do.
    pub size: Option<f64>,
}

/// Deterministic unit vectors of span(U): both senses of every axis, then a fixed random sequence.
/// At least `count` of them; a single degree of freedom has two directions only.
pub fn directions(class: Class, count: usize) -> Vec<DVector<f64>> {
    let n = class.dof();
    let mut all: Vec<DVector<f64>> = (0..n)
        .flat_map(|i| [1.0, -1.0].map(|s| DVector::from_fn(n, |k, _| if k == i { s } else { 0.0 })))
        .collect();
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    while n > 1 && all.len() < count {
        let v = DVector::from_fn(n, |_, _| random.random_range(-1.0..1.0));
        let norm: f64 = v.norm();
        // Uniform on the sphere: keep what falls into the ball, away from its centre.
        if norm > 0.1 && norm <= 1.0 {
            all.push(v / norm);
        }
    }
    all
}

/// Shift (mm) and turn (rad) of `u` in span(U) of `class`.
pub(super) fn parts(class: Class, u: &DVector<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let (linear, angular) = match class {
        Class::R1 => (0.0, Vector3::z() * u[0]),
        Class::R1T1 => (u[0], Vector3::z() * u[1]),
        Class::R3 => (0.0, Vector3::new(u[0], u[1], u[2])),
        Class::R3T1 => (u[0], Vector3::new(u[1], u[2], u[3])),
    };
    (Vector3::z() * linear, angular)
}

/// The rigid displacement of Σ by `u` in span(U) of `class`, turning about the joint centre.
pub fn displacement(class: Class, u: &DVector<f64>, centre: Vector3<f64>) -> Pose {
    let (linear, angular) = parts(class, u);
    let rotation = Rotation3::new(angular).into_inner();
    Pose {
        rotation,
        translation: centre - rotation * centre + linear,
    }
}

/// Longest step on the way to a displacement, mm at the centre distance from the joint.
const WAY: f64 = 0.5;

/// Driver and follower, and the displacements between them.
pub(super) struct Held<'a> {
    pub driver: &'a Part<'a>,
    pub follower: &'a Part<'a>,
    pub mechanism: Mechanism<'a>,
}

impl Held<'_> {
    /// Tries every direction at every (phase, size of the displacement).
    pub fn escapes(
        &self,
        tries: &[(f64, Option<f64>)],
        directions: &[DVector<f64>],
    ) -> Vec<Escape> {
        tries
            .par_iter()
            .flat_map_iter(|&(phi, size)| {
                directions
                    .iter()
                    .filter(|&u| size.is_none_or(|s| !self.stopped(phi, u, s)))
                    .map(|u| Escape {
                        phi,
                        direction: u.iter().copied().collect(),
                        size,
                    })
                    .collect::<Vec<_>>()
            })
            .collect()
    }

    /// Whether the follower hits the driver somewhere on its way to the displacement `u`·`size`. The
    /// steps are too short for one tooth to pass through another unseen.
    fn stopped(&self, phi: f64, u: &DVector<f64>, size: f64) -> bool {
        let (linear, angular) = parts(self.mechanism.motion.class(), u);
        let way = size * (linear.norm() + angular.norm() * self.mechanism.drive.center_distance());
        let steps = (way / WAY).ceil().clamp(1.0, 1000.0) as u32;
        (1..=steps).rev().any(|i| {
            let at = u * (size * f64::from(i) / f64::from(steps));
            self.hit(phi, &at)
        })
    }

    /// How far the follower moves from its pose along each direction before it touches the driver,
    /// in units of `u` (rad, or mm and rad mixed); `None` when it is free up to `limit`.
    pub fn play(&self, phi: f64, directions: &[DVector<f64>], limit: f64) -> Vec<Option<f64>> {
        let mechanism = &self.mechanism;
        let driver = mechanism.pose(Carrier::Driver, phi);
        let centre = driver.inverse_apply(mechanism.motion.joint_centre(phi));
        let back = driver.rotation.transpose();
        let facing = Facing {
            first: &self.driver.tree,
            second: &self.follower.tree,
            pose: driver.inverse_mul(&mechanism.pose(Carrier::Follower, phi)),
            lever: mechanism.drive.center_distance(),
        };
        let screw = |u: &DVector<f64>| {
            let (linear, angular) = parts(mechanism.motion.class(), u);
            Screw {
                centre,
                linear: back * linear,
                angular: back * angular,
            }
        };
        let screws: Vec<Screw> = directions.iter().map(screw).collect();
        facing.ways(&screws, limit)
    }

    /// Whether they meet at the displacement `u`.
    fn hit(&self, phi: f64, u: &DVector<f64>) -> bool {
        let motion = self.mechanism.motion;
        let moved = displacement(motion.class(), u, motion.joint_centre(phi));
        let follower = self.mechanism.pose(Carrier::Follower, phi);
        let follower = Pose {
            rotation: moved.rotation * follower.rotation,
            translation: moved.apply(follower.translation),
        };
        let pose = self
            .mechanism
            .pose(Carrier::Driver, phi)
            .inverse_mul(&follower);
        Placed::new(&self.driver.tree, &self.follower.tree, pose).touch()
    }
}
