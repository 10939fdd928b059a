//! Two rigid meshes against each other: smallest distance at a pose, and a bound over a stretch of
//! the motion. Distances are minima over triangle pairs, found by branch and bound over both trees.

use nalgebra::{Matrix3, Vector3};

use super::kept::{self, Images};
use super::tree::{Node, Tree};
use super::triangle::{Closest, Triangle};
use crate::motion::Pose;

/// Surfaces closer than this touch, mm: far above the rounding of poses and distances (1e-12),
/// far below anything a machine can make. Undecided is a collision.
pub const TOUCH: f64 = 1e-7;

/// A place where two bodies are close: distance and the nearest points, in the frame of the first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub closest: Closest,
    /// Tree indices of the two triangles: the start of the next search.
    pub pair: (usize, usize),
}

/// Centre and half of the extent of a box.
pub(super) type Extent = (Vector3<f64>, Vector3<f64>);

/// `second` placed in the frame of `first`.
pub(super) struct Placed<'a> {
    first: &'a Tree,
    second: &'a Tree,
    pose: Pose,
    /// |rotation|, for the extents of turned boxes.
    turned: Matrix3<f64>,
    /// Images of both on what their motion keeps.
    images: Option<(&'a Images, &'a Images)>,
}

/// First-and-second-order motion of `second` in the frame of `first` around one phase: the point at
/// `x` moves by v(x)·δ + ½a(x)·δ² with an error of at most (r + s·|x|)·|δ|³/6.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drift {
    pub velocity: Affine,
    pub acceleration: Affine,
    pub remainder: (f64, f64),
}

/// The field c + M·x.
#[derive(Debug, Clone, Copy)]
pub(super) struct Affine {
    pub constant: Vector3<f64>,
    pub matrix: Matrix3<f64>,
}

impl Affine {
    pub fn at(&self, x: Vector3<f64>) -> Vector3<f64> {
        self.constant + self.matrix * x
    }
}

impl Drift {
    /// Most that points of a box can approach along `n` within ±`half` (rad) of the phase.
    fn of_box(
        &self,
        n: Vector3<f64>,
        (centre, extent): (Vector3<f64>, Vector3<f64>),
        half: f64,
    ) -> f64 {
        let along = |field: &Affine| {
            let spread = (field.matrix.transpose() * n).abs().dot(&extent);
            (n.dot(&field.at(centre)), spread)
        };
        let (v, dv) = along(&self.velocity);
        let (a, da) = along(&self.acceleration);
        (v.abs() + dv) * half
            + 0.5 * (da - a).max(0.0) * half * half
            + self.rest(centre.norm() + extent.norm(), half)
    }

    /// The same for the hull of a few points.
    fn of_points(&self, n: Vector3<f64>, points: &[Vector3<f64>; 3], half: f64) -> f64 {
        points
            .iter()
            .map(|&x| {
                let (v, a) = (n.dot(&self.velocity.at(x)), n.dot(&self.acceleration.at(x)));
                v.abs() * half + 0.5 * (-a).max(0.0) * half * half + self.rest(x.norm(), half)
            })
            .fold(0.0, f64::max)
    }

    fn rest(&self, radius: f64, half: f64) -> f64 {
        (self.remainder.0 + self.remainder.1 * radius) * half.powi(3) / 6.0
    }
}

impl<'a> Placed<'a> {
    /// `pose` takes points of `second` into the frame of `first`.
    pub fn new(first: &'a Tree, second: &'a Tree, pose: Pose) -> Placed<'a> {
        Placed {
            first,
            second,
            pose,
            turned: pose.rotation.abs(),
            images: None,
        }
    }

    /// The same, knowing the `images` of both on what their motion against each other keeps.
    pub fn keeping(self, images: Option<(&'a Images, &'a Images)>) -> Placed<'a> {
        Placed { images, ..self }
    }

    /// Distance that two nodes keep, at every phase.
    fn kept(&self, i: usize, j: usize) -> f64 {
        self.images
            .map_or(0.0, |(a, b)| kept::apart(&a.nodes[i], &b.nodes[j]))
    }

    /// A place of the two surfaces closer than `within` that no other place undercuts by more than
    /// the share `slack` of its distance; stops at the first that touches. `hint` is a pair that
    /// was near at a neighbouring pose.
    pub fn nearest(&self, within: f64, slack: f64, hint: Option<(usize, usize)>) -> Option<Near> {
        let mut search = Search {
            within,
            keep: 1.0 - slack,
            best: None,
        };
        if let Some(pair) = hint {
            self.offer(pair, &self.second_triangle(pair.1), &mut search);
        }
        if let (Some(a), Some(b)) = (self.first.nodes.first(), self.second.nodes.first()) {
            self.descend(0, 0, self.gap(a, b).max(self.kept(0, 0)), &mut search);
        }
        search.best
    }

    /// What the surfaces are apart at least, by their boxes.
    pub fn least(&self) -> f64 {
        match (self.first.nodes.first(), self.second.nodes.first()) {
            (Some(a), Some(b)) => self.gap(a, b),
            _ => f64::INFINITY,
        }
    }

    /// Whether the surfaces touch.
    pub fn touch(&self) -> bool {
        self.nearest(TOUCH, 0.0, None).is_some()
    }

    /// All pairs between which there is no more than `reach` says: how far points of the second body in
    /// a box (its centre, half its extent) come nearer against a direction, and how far in any.
    pub fn within(&self, reach: impl Fn(Vector3<f64>, Extent) -> [f64; 2]) -> Vec<Near> {
        let mut near = Vec::new();
        let mut stack = vec![(0usize, 0usize)];
        while let Some((i, j)) = stack.pop() {
            let (Some(a), Some(b)) = (self.first.nodes.get(i), self.second.nodes.get(j)) else {
                continue;
            };
            let extent = (self.pose.apply(b.centre), self.turned * b.half);
            let (in_first, in_second) = self.gaps(a, b);
            let apart = [in_first, self.pose.rotation * in_second]
                .iter()
                .any(|gap| {
                    let distance = gap.norm();
                    distance > 0.0 && distance > reach(gap / distance, extent)[0]
                });
            if apart {
                continue;
            }
            if a.is_leaf() && b.is_leaf() {
                let [_, within] = reach(Vector3::zeros(), extent);
                for l in self.second.leaf(b) {
                    let other = self.second_triangle(l);
                    near.extend(self.first.leaf(a).filter_map(|k| {
                        let closest = self.first.triangles[k].closest(&other, within)?;
                        Some(Near {
                            closest,
                            pair: (k, l),
                        })
                    }));
                }
                continue;
            }
            stack.extend(self.children((i, j), (a, b)));
        }
        near
    }

    /// What stands under two nodes, of which one at least is no leaf: the larger is opened.
    fn children(&self, (i, j): (usize, usize), (a, b): (&Node, &Node)) -> [(usize, usize); 2] {
        let larger = a.half.norm_squared() > b.half.norm_squared();
        match b.is_leaf() || !a.is_leaf() && larger {
            true => [(i + 1, j), (a.first as usize, j)],
            false => [(i, j + 1), (i, b.first as usize)],
        }
    }

    /// Pairs that may come closer than `floor` within ±`half` of this phase, at most about `enough` of
    /// them; none means proven clear.
    pub fn doubtful(
        &self,
        (drift, half, floor): (&Drift, f64, f64),
        enough: usize,
    ) -> Vec<(usize, usize)> {
        let mut doubtful = Vec::new();
        let mut stack = vec![(0usize, 0usize)];
        while let Some((i, j)) = stack.pop() {
            if doubtful.len() >= enough {
                break;
            }
            let (Some(a), Some(b)) = (self.first.nodes.get(i), self.second.nodes.get(j)) else {
                continue;
            };
            if self.kept(i, j) > floor {
                continue;
            }
            let centre = self.pose.apply(b.centre);
            let extent = self.turned * b.half;
            // Along the whole gap, or along its largest component alone: faces that slide over each
            // other part along their normal only.
            let (in_first, in_second) = self.gaps(a, b);
            let apart = [
                in_first,
                main_part(in_first),
                self.pose.rotation * in_second,
            ]
            .iter()
            .any(|gap| {
                let distance = gap.norm();
                distance > floor
                    && distance - drift.of_box(gap / distance, (centre, extent), half) > floor
            });
            if apart {
                continue;
            }
            if !(a.is_leaf() && b.is_leaf()) {
                stack.extend(self.children((i, j), (a, b)));
                continue;
            }
            for l in self.second.leaf(b) {
                let other = self.second_triangle(l);
                let pairs = self.first.leaf(a).map(|k| (k, l));
                doubtful
                    .extend(pairs.filter(|&pair| !self.clear(pair, &other, (drift, half, floor))));
            }
        }
        doubtful
    }

    /// Those of `pairs` that stay doubtful at this phase and half width.
    pub fn still_doubtful(
        &self,
        pairs: &[(usize, usize)],
        (drift, half, floor): (&Drift, f64, f64),
    ) -> Vec<(usize, usize)> {
        pairs
            .iter()
            .copied()
            .filter(|&(k, l)| !self.clear((k, l), &self.second_triangle(l), (drift, half, floor)))
            .collect()
    }

    /// Distance of one pair of triangles.
    pub fn pair(&self, (k, l): (usize, usize)) -> Option<Closest> {
        self.first.triangles[k].closest(&self.second_triangle(l), f64::INFINITY)
    }

    fn clear(
        &self,
        (k, l): (usize, usize),
        other: &Triangle,
        (drift, half, floor): (&Drift, f64, f64),
    ) -> bool {
        let keeps =
            |(a, b): (&Images, &Images)| kept::apart(&a.triangles[k], &b.triangles[l]) > floor;
        if self.images.is_some_and(keeps) {
            return true;
        }
        let this = &self.first.triangles[k];
        // Separation along either triangle's plane is the cheap proof, along the line of closest
        // points the sharp one. Comparisons are written so that NaN is not clear.
        let beyond = |n: Vector3<f64>, distance: f64| {
            distance > floor && distance - drift.of_points(n, &other.corners, half) > floor
        };
        let (n, distance) = this.side_of(other);
        if beyond(n, distance) {
            return true;
        }
        let (n, distance) = other.side_of(this);
        if beyond(-n, distance) {
            return true;
        }
        this.closest(other, f64::INFINITY)
            .is_some_and(|c| c.distance > floor && beyond((c.q - c.p) / c.distance, c.distance))
    }

    fn second_triangle(&self, l: usize) -> Triangle {
        self.second.triangles[l].moved(&self.pose)
    }

    /// Lower bound of the distance of two boxes.
    fn gap(&self, a: &Node, b: &Node) -> f64 {
        let (in_first, in_second) = self.gaps(a, b);
        in_first.norm_squared().max(in_second.norm_squared()).sqrt()
    }

    /// Vectors from box `a` to box `b` along which they are apart at least by its length (zero:
    /// maybe not apart), by the axes of the first body and of the second, each in its frame.
    fn gaps(&self, a: &Node, b: &Node) -> (Vector3<f64>, Vector3<f64>) {
        let offset = self.pose.apply(b.centre) - a.centre;
        let apart = |offset: Vector3<f64>, reach: Vector3<f64>| {
            offset.zip_map(&reach, |o, r| (o.abs() - r).max(0.0) * o.signum())
        };
        let back = self.pose.rotation.transpose() * offset;
        (
            apart(offset, a.half + self.turned * b.half),
            apart(back, b.half + self.turned.transpose() * a.half),
        )
    }

    fn offer(&self, pair: (usize, usize), other: &Triangle, search: &mut Search) {
        if let Some(closest) = self.first.triangles[pair.0].closest(other, search.within) {
            search.within = closest.distance * search.keep;
            search.best = Some(Near { closest, pair });
        }
    }

    fn descend(&self, i: usize, j: usize, distance: f64, search: &mut Search) {
        if distance >= search.within || search.done() {
            return;
        }
        let (a, b) = (&self.first.nodes[i], &self.second.nodes[j]);
        if a.is_leaf() && b.is_leaf() {
            for l in self.second.leaf(b) {
                let other = self.second_triangle(l);
                for k in self.first.leaf(a) {
                    self.offer((k, l), &other, search);
                }
            }
            return;
        }
        let children = self.children((i, j), (a, b));
        let distances = children.map(|(i, j)| {
            let gap = self.gap(&self.first.nodes[i], &self.second.nodes[j]);
            gap.max(self.kept(i, j))
        });
        let order = if distances[1] < distances[0] {
            [1, 0]
        } else {
            [0, 1]
        };
        for c in order {
            self.descend(children[c].0, children[c].1, distances[c], search);
        }
    }
}

/// The largest component of a vector, alone.
fn main_part(v: Vector3<f64>) -> Vector3<f64> {
    let axis = v.iamax();
    let mut part = Vector3::zeros();
    part[axis] = v[axis];
    part
}

/// State of one branch-and-bound search.
struct Search {
    within: f64,
    keep: f64,
    best: Option<Near>,
}

impl Search {
    fn done(&self) -> bool {
        self.best.is_some_and(|b| b.closest.distance <= TOUCH)
    }
}
