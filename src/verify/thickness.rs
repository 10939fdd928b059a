//! Smallest wall of a solid, over a dense deterministic set of surface points: how far it is straight
//! through to a face looking the other way, or the smallest ball inside that touches the surface at
//! two opposite places (medial diameter), which also sees the wall above the ridge of a groove.

use std::collections::HashSet;
use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::tree::Tree;
use crate::solid::Mesh;

/// Cosine of 145°: a wall is between sides closer to parallel than 35°, be it the angle of their
/// normals or of the touching points seen from the ball's centre. The rest are edges and curvature.
const OPPOSITE: f64 = -0.819;

/// Triangles lower than this are seams of the solid kernel, not surface: their normals mean nothing, mm.
const SEAM: f64 = 1e-3;

/// Cosine above which a triangle faces along with the sample: not away from it, rounding included.
const ALONG: f64 = 0.01;

/// Tasks look at this many samples in order; fixed, for results independent of the threads.
const RUN: usize = 2048;

/// Smallest wall found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Thickness, mm.
    pub thickness_mm: f64,
    /// A surface point on one side of it, in the frame of the mesh, mm.
    pub at: [f64; 3],
}

/// What to look for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallSettings {
    /// Walls thicker than this are of no interest, mm.
    pub up_to: f64,
    /// Distance of the samples, mm. A wall above
    /// the ridge of a groove is seen within 0.3 of its thickness beside the ridge: choose less.
    pub spacing: f64,
}

/// Thinnest wall of a closed mesh up to `settings.up_to`; `None` when every wall is thicker.
pub fn thinnest(mesh: &Mesh, settings: &WallSettings) -> Option<Wall> {
    let tree = Tree::new(mesh);
    let facings = facings(&tree);
    let samples = samples(&tree, settings.spacing);
    samples
        .par_chunks(RUN)
        .filter_map(|run| {
            let mut best: Option<Wall> = None;
            for &(p, k) in run {
                let limit = best.map_or(settings.up_to, |w| w.thickness_mm);
                let found = [
                    straight_through(&tree, (p, k), limit),
                    medial_diameter(&tree, &facings, (p, k), limit),
                ];
                for thickness_mm in found.into_iter().flatten() {
                    if best.is_none_or(|b| thickness_mm < b.thickness_mm) {
                        best = Some(Wall {
                            thickness_mm,
                            at: p.into(),
                        });
                    }
                }
            }
            best
        })
        .min_by(|a, b| a.thickness_mm.total_cmp(&b.thickness_mm))
}

/// Points on the surface with the tree index of their triangle: centroids of its parts after
/// halving the longest edge until none is longer than twice `spacing`. Slivers would put them far
/// closer than that: of those in one cell, of an edge of `spacing` / √2, whose surface faces the same
/// way, the first is kept.
fn samples(tree: &Tree, spacing: f64) -> Vec<(Vector3<f64>, usize)> {
    let mut samples = Vec::new();
    let mut seen = HashSet::new();
    let cell = spacing * FRAC_1_SQRT_2;
    for (k, t) in tree
        .triangles
        .iter()
        .enumerate()
        .filter(|(_, t)| t.height() > SEAM)
    {
        let facing = rounded(t.normal * FACINGS);
        let mut work = vec![t.corners];
        while let Some([a, b, c]) = work.pop() {
            let edges = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
            let longest = edges[0].max(edges[1]).max(edges[2]);
            // Rounding may keep a huge triangle from ever getting small: the stack bounds it.
            if longest <= 2.0 * spacing || work.len() > 60 {
                let p = (a + b + c) / 3.0;
                if seen.insert((rounded(p / cell), facing)) {
                    samples.push((p, k));
                }
                continue;
            }
            let [a, b, c] = match edges {
                [ab, ..] if ab == longest => [a, b, c],
                [_, bc, _] if bc == longest => [b, c, a],
                _ => [c, a, b],
            };
            let middle = (a + b) / 2.0;
            work.extend([[a, middle, c], [middle, b, c]]);
        }
    }
    samples
}

/// Components of a unit normal are told apart in steps of the inverse: surfaces that face the same
/// way within about 30°.
const FACINGS: f64 = 3.0;

fn rounded(v: Vector3<f64>) -> [i32; 3] {
    v.map(|x| x.round() as i32).into()
}

/// Distance below `limit` from `p` along the inward normal to a face that looks the other way.
fn straight_through(tree: &Tree, (p, k): (Vector3<f64>, usize), limit: f64) -> Option<f64> {
    let outward = tree.triangles[k].normal;
    let (t, hit) = tree.first_hit((p, p - outward * limit), k)?;
    let other = &tree.triangles[hit];
    (other.normal.dot(&outward) < OPPOSITE && other.height() > SEAM).then_some(t * limit)
}

/// Normals of the triangles under every node: least and largest of each component.
type Facings = Vec<[Vector3<f64>; 2]>;

/// Seams may face anywhere.
fn facings(tree: &Tree) -> Facings {
    let anywhere = [Vector3::repeat(-1.0), Vector3::repeat(1.0)];
    let both = |a: [Vector3<f64>; 2], b: [Vector3<f64>; 2]| [a[0].inf(&b[0]), a[1].sup(&b[1])];
    let of_triangle = |k: usize| match &tree.triangles[k] {
        t if t.height() > SEAM => [t.normal; 2],
        _ => anywhere,
    };
    let facings = tree.under(of_triangle, both).into_iter();
    facings.map(|f| f.unwrap_or(anywhere)).collect()
}

/// Diameter below `limit` of the largest ball inside the surface that touches it at `p`, when its
/// other touching point is opposite; `None` otherwise. The ball shrinks onto the nearest obstacle
/// until it is empty.
///
/// Where a ball touches from inside, the way from its centre lies between the normals of the triangles
/// there. So an opposite touching point is on one that faces away from p, and is also what a ball
/// shrinks onto that only sees those: most samples are done with quickly that way.
fn medial_diameter(
    tree: &Tree,
    facings: &Facings,
    (p, k): (Vector3<f64>, usize),
    limit: f64,
) -> Option<f64> {
    let outward = tree.triangles[k].normal;
    let faces_along = |node: usize| {
        let [low, high] = facings[node];
        let least = outward.zip_map(&low, |n, x| n * x);
        least.inf(&outward.zip_map(&high, |n, x| n * x)).sum() > ALONG
    };
    ball(tree, (p, outward), limit, faces_along)?;
    ball(tree, (p, outward), limit, |_| false)
}

/// The ball of [`medial_diameter`] in the surface outside the nodes that `skip` names.
fn ball(
    tree: &Tree,
    (p, outward): (Vector3<f64>, Vector3<f64>),
    limit: f64,
    skip: impl Fn(usize) -> bool + Copy,
) -> Option<f64> {
    let inward = -outward;
    let mut radius = limit / 2.0;
    let mut touch = None;
    // Each step shrinks the ball at least to the nearest obstacle; 40 are far more than the five
    // or so it takes, and running out of them keeps the larger, still valid upper bound.
    for _ in 0..40 {
        let centre = p + inward * radius;
        let Some((near, _)) = tree.nearest_of(centre, radius * (1.0 - 1e-9), skip) else {
            break;
        };
        let q = near.q - p;
        let depth = inward.dot(&q);
        if depth <= 1e-12 {
            break;
        }
        let next = q.norm_squared() / (2.0 * depth);
        if next >= radius * (1.0 - 1e-9) {
            break;
        }
        radius = next;
        touch = Some(near.q);
    }
    let centre = p + inward * radius;
    let q = touch?;
    let opposite = (p - centre).dot(&(q - centre)) < OPPOSITE * radius * radius;
    opposite.then_some(2.0 * radius)
}
