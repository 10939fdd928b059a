//! No two bodies meet: smallest gap, with a bound for every φ of the turn, and the shared volume
//! where they do meet.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::collide::{Near, Placed, TOUCH};
use super::kept::{Images, Kept};
use super::mechanism::Mechanism;
use super::tree::Tree;
use crate::motion::Pose;
use crate::solid::Mesh;
use crate::solid::assembly::{Carrier, SolidBody};
use crate::solid::kernel::Solid;

/// Steps that one task walks through in order, each search starting at its neighbour's result;
/// fixed, so that the result does not depend on the number of threads.
const RUN: usize = 30;

/// Share of a gap that the search for the smallest one leaves undecided: nearly concentric
/// surfaces (ball in socket) are equally far apart everywhere, and need not all be compared.
const SLACK: f64 = 0.05;

/// A stride may be as long as the gap provably stays above this share of the smallest one seen:
/// long enough to pass joints quickly, whose gap never changes, short enough not to miss a dip.
const DIP: f64 = 0.7;

/// A step is halved this often before it counts as undecided.
const HALVINGS: u32 = 7;

/// At most this many colliding phases are measured for volume, spread over all of them.
const VOLUMES: usize = 6;

/// Two bodies over the whole turn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairProof {
    /// Names of the two bodies.
    pub bodies: [String; 2],
    /// Smallest gap found, mm; 0 when they meet. Strides longer than one step of the turn are only
    /// taken where the gap provably stays above 0.7 of it.
    pub gap_mm: f64,
    /// Where it is smallest.
    pub gap_at: Place,
    /// Steps of the turn in which surfaces meet (all of them when one body is inside the other).
    pub colliding_steps: usize,
    /// Largest shared volume found, mm³; 0 when they never meet, `None` when the solid kernel
    /// cannot measure it (then `colliding_steps` says that they meet).
    pub overlap_mm3: Option<f64>,
    /// Where it is largest.
    pub overlap_at: Option<Place>,
    /// Steps of the turn in which a gap above the demanded one could not be proven: the phase and
    /// place of the first doubt in each. Empty: proven for every φ.
    pub doubts: Vec<Place>,
}

impl PairProof {
    /// Whether the two bodies provably stay apart.
    pub fn holds(&self) -> bool {
        self.colliding_steps == 0 && self.doubts.is_empty()
    }
}

/// A phase and a point of Σ.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Driver angle, rad.
    pub phi: f64,
    /// Point in Σ, mm.
    pub at: [f64; 3],
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.at;
        write!(
            f,
            "φ = {:.2}°, ({x:.2}, {y:.2}, {z:.2}) mm",
            self.phi.to_degrees()
        )
    }
}

/// How finely to cut the turn and what to demand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OverlapSettings {
    /// Steps of the turn.
    pub steps: usize,
    /// Gap to prove, mm.
    pub floor: f64,
}

/// A body with its search tree.
pub(super) struct Part<'a> {
    pub body: &'a SolidBody,
    pub tree: Tree,
}

impl<'a> Part<'a> {
    pub fn new(body: &'a SolidBody) -> Part<'a> {
        Part {
            body,
            tree: Tree::new(&body.mesh),
        }
    }
}

/// Proves a pair of bodies apart, or says where they are not.
pub(super) fn apart(
    (first, second): (&Part, &Part),
    mechanism: &Mechanism,
    settings: &OverlapSettings,
) -> PairProof {
    let carriers = (first.body.carrier, second.body.carrier);
    let kept = Kept::by(carriers, mechanism);
    // The driver is seen all the way round: its teeth repeat themselves, its shaft does not.
    let turns = match [carriers.0, carriers.1].contains(&Carrier::Driver) {
        true => mechanism.drive.copies(),
        false => 1,
    };
    let steps = turns * settings.steps;
    let walk = Walk {
        trees: (&first.tree, &second.tree),
        carriers,
        mechanism,
        remainder: mechanism.remainder(carriers),
        start: mechanism.motion.cycle().start(),
        step: mechanism.motion.cycle().length() / settings.steps as f64,
        floor: settings.floor.max(TOUCH),
        images: kept.map(|kept| [first, second].map(|part| kept.images(&part.tree))),
    };
    let starts: Vec<usize> = (0..steps).step_by(RUN).collect();
    let stretches: Vec<Stretch> = starts
        .par_iter()
        .map(|&start| walk.stretch(start, (start + RUN).min(steps)))
        .collect();
    let mut smallest: Option<(f64, Near)> = None;
    let (mut colliding, mut doubts) = (Vec::new(), Vec::new());
    for stretch in stretches {
        colliding.extend(stretch.colliding);
        doubts.extend(stretch.doubts);
        if let Some((phi, near)) = stretch.smallest
            && smallest.is_none_or(|(_, s)| near.closest.distance < s.closest.distance)
        {
            smallest = Some((phi, near));
        }
    }
    let nested = nested((first, second), mechanism);
    if let (true, true, Some(&at)) = (
        nested,
        colliding.is_empty(),
        second.body.mesh.vertices.first(),
    ) {
        let at = mechanism.pose(carriers.1, 0.0).apply(Vector3::from(at));
        colliding.push(Place {
            phi: 0.0,
            at: at.into(),
        });
    }
    let mut overlap = (Some(0.0), None);
    let stride = colliding.len().div_ceil(VOLUMES).max(1);
    for &place in colliding.iter().step_by(stride) {
        let pose = |c| mechanism.pose(c, place.phi);
        let moved = second
            .body
            .mesh
            .moved(&pose(carriers.0).inverse_mul(&pose(carriers.1)));
        let volume = shared_volume(&first.body.mesh, &moved);
        // A volume that cannot be measured stays the worst.
        if overlap.1.is_none() || overlap.0.is_some() && volume.is_none_or(|v| Some(v) > overlap.0)
        {
            overlap = (volume, Some(place));
        }
    }
    let (gap_mm, gap_at) = match smallest {
        Some((phi, near)) if !nested => walk.sharpen(phi, near),
        _ => (0.0, colliding.first().copied().unwrap_or_default()),
    };
    PairProof {
        bodies: [first.body.name.clone(), second.body.name.clone()],
        gap_mm,
        gap_at,
        colliding_steps: if nested { steps } else { colliding.len() },
        overlap_mm3: overlap.0,
        overlap_at: overlap.1,
        doubts,
    }
}

/// Two bodies on their way through the turn.
struct Walk<'a> {
    trees: (&'a Tree, &'a Tree),
    carriers: (Carrier, Carrier),
    mechanism: &'a Mechanism<'a>,
    remainder: (f64, f64),
    start: f64,
    step: f64,
    floor: f64,
    /// Of both bodies, on what their motion keeps.
    images: Option<[Images; 2]>,
}

/// What was found on a stretch of the turn.
#[derive(Default)]
struct Stretch {
    smallest: Option<(f64, Near)>,
    colliding: Vec<Place>,
    doubts: Vec<Place>,
}

impl Walk<'_> {
    fn placed(&self, pose: Pose) -> Placed<'_> {
        let images = self.images.as_ref().map(|[a, b]| (a, b));
        Placed::new(self.trees.0, self.trees.1, pose).keeping(images)
    }

    /// Walks from step `from` to step `to` in strides as long as the gap can be bounded over them:
    /// above the demanded one, and not much below the smallest seen.
    fn stretch(&self, from: usize, to: usize) -> Stretch {
        let mut found = Stretch::default();
        let (mut at, mut stride, mut hint) = (from, 1, None);
        while at < to {
            stride = stride.min(to - at);
            let half = 0.5 * stride as f64 * self.step;
            let phi = self.start + at as f64 * self.step + half;
            let (pose, drift) = self.mechanism.seen(self.carriers, phi, self.remainder);
            let placed = self.placed(pose);
            let Some(near) = placed.nearest(f64::INFINITY, SLACK, hint) else {
                // Only a body without surface gets here; nothing is proven about it.
                found.doubts.push(Place {
                    phi,
                    ..Place::default()
                });
                break;
            };
            hint = Some(near.pair);
            let distance = near.closest.distance;
            if found
                .smallest
                .is_none_or(|(_, s)| distance < s.closest.distance)
            {
                found.smallest = Some((phi, near));
            }
            let least = found.smallest.map_or(distance, |(_, s)| s.closest.distance);
            let meets = distance <= TOUCH;
            if !meets {
                // A longer stride is given up at the first doubt; a single step needs all of them.
                let enough = if stride > 1 { 1 } else { usize::MAX };
                let pairs = placed.doubtful((&drift, half, self.floor.max(DIP * least)), enough);
                if pairs.is_empty() {
                    at += stride;
                    stride *= 2;
                    continue;
                }
                if stride == 1 {
                    found.doubts.extend(self.between(phi, half, pairs));
                    at += 1;
                    continue;
                }
            }
            if stride > 1 {
                stride /= 2;
                continue;
            }
            let place = self.place(phi, near.closest.p);
            found.colliding.push(place);
            found.doubts.push(place);
            at += 1;
        }
        found
    }

    /// Proves the gap over phi ± half for the triangle pairs in doubt, in ever shorter pieces;
    /// `None` is proven, otherwise where it is in doubt.
    fn between(&self, phi: f64, half: f64, pairs: Vec<(usize, usize)>) -> Option<Place> {
        let shortest = half / f64::from(1 << HALVINGS);
        let (pose, drift) = self.mechanism.seen(self.carriers, phi, self.remainder);
        let left = self
            .placed(pose)
            .still_doubtful(&pairs, (&drift, half, self.floor));
        let mut work = vec![(phi, half, left)];
        while let Some((phi, half, pairs)) = work.pop() {
            let Some(&doubt) = pairs.first() else {
                continue;
            };
            if half < 1.5 * shortest {
                let (pose, _) = self.mechanism.seen(self.carriers, phi, self.remainder);
                let placed = self.placed(pose);
                let at = placed.pair(doubt).map_or(Vector3::zeros(), |c| c.p);
                return Some(self.place(phi, at));
            }
            let half = half / 2.0;
            for phi in [phi + half, phi - half] {
                let (pose, drift) = self.mechanism.seen(self.carriers, phi, self.remainder);
                let placed = self.placed(pose);
                work.push((
                    phi,
                    half,
                    placed.still_doubtful(&pairs, (&drift, half, self.floor)),
                ));
            }
        }
        None
    }

    /// The exact smallest gap at the phase of `near`.
    fn sharpen(&self, phi: f64, near: Near) -> (f64, Place) {
        let (pose, _) = self.mechanism.seen(self.carriers, phi, self.remainder);
        let closest = self
            .placed(pose)
            .nearest(near.closest.distance, 0.0, Some(near.pair))
            .map_or(near.closest, |n| n.closest);
        let gap = if closest.distance <= TOUCH {
            0.0
        } else {
            closest.distance
        };
        (gap, self.place(phi, closest.p))
    }

    fn place(&self, phi: f64, in_first: Vector3<f64>) -> Place {
        let at = self.mechanism.pose(self.carriers.0, phi).apply(in_first);
        Place { phi, at: at.into() }
    }
}

/// Whether one body is inside the other at φ = 0 without surface contact. (It could only get there
/// later by crossing a surface, which the walk sees.)
fn nested((first, second): (&Part, &Part), mechanism: &Mechanism) -> bool {
    let inside = |inner: &Part, outer: &Part| {
        let pose = mechanism
            .pose(outer.body.carrier, 0.0)
            .inverse_mul(&mechanism.pose(inner.body.carrier, 0.0));
        super::mesh::components(&inner.body.mesh)
            .iter()
            .any(|&vertex| {
                let point = pose.apply(inner.body.mesh.vertex(vertex));
                outer.tree.winding(point).abs() > 0.5
            })
    };
    inside(first, second) || inside(second, first)
}

/// Volume shared by two closed meshes in the same frame, mm³; `None` when the kernel refuses one.
fn shared_volume(a: &Mesh, b: &Mesh) -> Option<f64> {
    let [a, b] = [Solid::new(a, "first").ok()?, Solid::new(b, "second").ok()?];
    Some(a.intersection(&b).volume()).filter(|v| v.is_finite())
}
