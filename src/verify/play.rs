//! How far the follower can be moved along a screw before it touches the driver: a bound of the first
//! contact for every two triangles that are near, the exact one for those that come first.

use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;

use super::collide::{Extent, Near, Placed};
use super::tree::Tree;
use super::triangle::{Closest, Triangle};
use crate::motion::Pose;

/// Closer than this is touching, mm: what a step on the way to a contact has to leave.
const NEAR: f64 = 1e-5;

/// Steps after which a contact that is still approached counts as reached.
const STEPS: usize = 100;

/// The way of points at the lever that is looked at in one go, mm.
const STRETCH: f64 = 0.3;

/// A motion by s along a fixed screw: turning about `angular` through a centre, and along `linear`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Screw {
    pub centre: Vector3<f64>,
    /// mm per unit of s.
    pub linear: Vector3<f64>,
    /// rad per unit of s.
    pub angular: Vector3<f64>,
}

impl Screw {
    /// `pose` after the motion by `s`.
    fn moved(&self, s: f64, pose: &Pose) -> Pose {
        let turn = Rotation3::new(self.angular * s).into_inner();
        Pose {
            rotation: turn * pose.rotation,
            translation: self.centre + turn * (pose.translation - self.centre) + self.linear * s,
        }
    }

    /// How far points of a box come nearer against `n` between two s, at most, and how far in any
    /// direction.
    fn reach(&self, (from, to): (f64, f64), n: Vector3<f64>, (middle, half): Extent) -> [f64; 2] {
        let step = to - from;
        let arm = middle - self.centre - self.linear * from;
        let lever = arm.norm() + half.norm();
        // n·(ω × x) = x·(n × ω)
        let across = n.cross(&self.angular);
        let speed = half.dot(&across.abs()) - n.dot(&self.linear) - arm.dot(&across);
        let angular = self.angular.norm();
        let bend = 0.5 * (angular * step).powi(2) * lever;
        let fastest = self.linear.norm() + angular * lever;
        [(speed * step).max(0.0) + bend, fastest * step]
    }

    /// A step by which the second triangle, which is at s where `closest` was found, cannot reach the
    /// first. No point gets nearer along the line between the closest points than by its speed and
    /// half of its largest acceleration.
    fn free(&self, s: f64, closest: &Closest, second: &Triangle) -> f64 {
        let d = closest.distance;
        if d <= NEAR {
            return 0.0;
        }
        let n = (closest.q - closest.p) / d;
        let centre = self.centre + self.linear * s;
        let (mut speed, mut lever) = (f64::NEG_INFINITY, 0.0f64);
        for x in second.corners {
            let arm = x - centre;
            speed = speed.max(-n.dot(&(self.angular.cross(&arm) + self.linear)));
            lever = lever.max(arm.norm());
        }
        let half = 0.5 * self.angular.norm_squared() * lever;
        2.0 * d / (speed + (speed * speed + 4.0 * half * d).sqrt())
    }
}

/// Two meshes, the second placed in the frame of the first.
pub(super) struct Facing<'a> {
    pub first: &'a Tree,
    pub second: &'a Tree,
    pub pose: Pose,
    /// Lever at which a turn by 1 rad is as far as a shift, mm.
    pub lever: f64,
}

impl Facing<'_> {
    /// How far the second can move along each of `screws` before it touches the first; `None` when it is
    /// free up to `limit`. All begin among the same near triangles.
    pub fn ways(&self, screws: &[Screw], limit: f64) -> Vec<Option<f64>> {
        let lever = |x: Vector3<f64>, half: Vector3<f64>| {
            let centre = screws.first().map_or(x, |s| s.centre);
            ((x - centre).norm() + half.norm()) / self.lever
        };
        let near = Placed::new(self.first, self.second, self.pose)
            .within(|_, (x, half)| [STRETCH * lever(x, half).max(1.0); 2]);
        let way = |screw: &Screw| self.way(screw, &near, limit);
        screws.par_iter().map(way).collect()
    }

    fn way(&self, screw: &Screw, near: &[Near], limit: f64) -> Option<f64> {
        let size = screw.linear.norm() + screw.angular.norm() * self.lever;
        let (mut from, mut to) = (0.0, (STRETCH / size).min(limit));
        let mut met = self.earliest(screw, near, (from, to));
        while met.is_none() && to < limit {
            (from, to) = (to, (to + STRETCH / size).min(limit));
            let pose = screw.moved(from, &self.pose);
            let near = Placed::new(self.first, self.second, pose)
                .within(|n, extent| screw.reach((from, to), n, extent));
            met = self.earliest(screw, &near, (from, to));
        }
        met
    }

    /// First contact of the pairs `near`, found at `from`, before `to`.
    fn earliest(&self, screw: &Screw, near: &[Near], (from, to): (f64, f64)) -> Option<f64> {
        let pose = screw.moved(from, &self.pose);
        let bound = |near: &Near| {
            let second = self.second.triangles[near.pair.1].moved(&pose);
            from + screw.free(from, &near.closest, &second)
        };
        let bounds = near.iter().map(|n| (bound(n), n.pair));
        // Written so that a NaN is looked at.
        let mut order: Vec<_> = bounds.filter(|(s, _)| !(*s > to)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut first = None;
        for (s, pair) in order {
            let before = first.unwrap_or(to);
            if s >= before {
                break;
            }
            first = self.meet(screw, pair, (s.max(from), before)).or(first);
        }
        first
    }

    /// Where two triangles meet, from a place where they have not yet; `None` when that is not before `to`.
    fn meet(&self, screw: &Screw, (k, l): (usize, usize), (from, to): (f64, f64)) -> Option<f64> {
        let mut s = from;
        for _ in 0..STEPS {
            let second = self.second.triangles[l].moved(&screw.moved(s, &self.pose));
            let closest = self.first.triangles[k].closest(&second, f64::INFINITY)?;
            if closest.distance <= NEAR {
                return Some(s);
            }
            s += screw.free(s, &closest, &second);
            if s > to {
                return None;
            }
        }
        Some(s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::kernel;
    use nalgebra::Matrix3;

    /// A post and a slat beside it that turns about the origin, or slides.
    fn way(screw: Screw, limit: f64) -> Option<f64> {
        let post = kernel::lathe(&[(1.0, -3.0), (1.0, 3.0)], 4);
        let slat = kernel::lathe(&[(0.2, -5.0), (0.2, 5.0)], 4);
        let pose = Pose {
            rotation: Matrix3::identity(),
            translation: Vector3::new(10.0, 0.0, 0.0),
        };
        let (first, second) = (Tree::new(&post), Tree::new(&slat));
        let facing = Facing {
            first: &first,
            second: &second,
            pose,
            lever: 10.0,
        };
        facing.ways(&[screw], limit)[0]
    }

    #[test]
    fn ways_are_as_far_as_they_look() {
        let slide = |x: f64| Screw {
            centre: Vector3::zeros(),
            linear: Vector3::new(x, 0.0, 0.0),
            angular: Vector3::zeros(),
        };
        // Corner to corner on the x axis.
        let found = way(slide(-1.0), 20.0).expect("meets");
        assert!((found - 8.8).abs() < 1e-4, "{found}");
        let found = way(slide(-2.0), 20.0).expect("meets");
        assert!((found - 4.4).abs() < 1e-4, "{found}");
        assert_eq!(way(slide(-1.0), 8.7), None);
        assert_eq!(way(slide(1.0), 50.0), None);
        // Half a turn would bring the slat into the post. Of two squares that touch, a corner of one is on
        // the edge of the other, and none is inside.
        let turn = Screw {
            centre: Vector3::new(5.0, 0.0, 0.0),
            linear: Vector3::zeros(),
            angular: Vector3::z(),
        };
        let found = way(turn, 6.0).expect("meets");
        let start = Pose {
            rotation: Matrix3::identity(),
            translation: Vector3::new(10.0, 0.0, 0.0),
        };
        let slat = turn.moved(found, &start);
        let corners = |r: f64| {
            [1.0, -1.0]
                .into_iter()
                .flat_map(move |s| [Vector3::x(), Vector3::y()].map(|e| e * r * s))
        };
        let outside = |x: Vector3<f64>, r: f64| x.x.abs() + x.y.abs() - r;
        let of_slat = corners(0.2).map(|c| outside(slat.apply(c), 1.0));
        let of_post = corners(1.0).map(|c| outside(slat.inverse_apply(c), 0.2));
        let least = of_slat.chain(of_post).fold(f64::INFINITY, f64::min);
        assert!(least.abs() < 1e-4, "{least} at {found}");
    }
}
