//! No two bodies meet: smallest gap at sampled phases, a bound for everything in between, and the
//! shared volume where they do meet.

use std::f64::consts::TAU;

use manifold_rust::manifold::Manifold;
use manifold_rust::types::{Error as Status, MeshGL64};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::collide::{Near, Placed, TOUCH};
use super::mover::{Mechanism, Mover, RigidBody};
use super::tree::Tree;
use crate::solid::Mesh;

/// Phases that one task walks through in order, each search starting at its neighbour's result;
/// fixed, so that the result does not depend on the number of threads.
const RUN: usize = 12;

/// An interval is halved this often before it counts as undecided.
const HALVINGS: u32 = 7;

/// At most this many colliding phases are measured for volume, spread over all of them.
const VOLUMES: usize = 6;

/// Two bodies over the whole turn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairProof {
    /// Names of the two bodies.
    pub bodies: [String; 2],
    /// Smallest gap at the sampled phases, mm; 0 when they meet.
    pub gap_mm: f64,
    /// Where it is smallest.
    pub gap_at: Place,
    /// Gap at every sampled phase, mm.
    pub gaps_mm: Vec<f64>,
    /// Phases at which surfaces meet or one body is inside the other.
    pub colliding_phases: usize,
    /// Largest shared volume found, mm³; 0 when they never meet, `None` when the solid kernel
    /// cannot measure it (then `colliding_phases` says that they meet).
    pub overlap_mm3: Option<f64>,
    /// Where it is largest.
    pub overlap_at: Option<Place>,
    /// Stretches of the turn in which a gap above the demanded one could not be proven between
    /// samples: the phase and place of the first doubt in each. Empty: proven for every φ.
    pub doubts: Vec<Place>,
}

impl PairProof {
    /// Whether the two bodies provably stay apart.
    pub fn holds(&self) -> bool {
        self.colliding_phases == 0 && self.doubts.is_empty()
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

/// How densely to look and what to demand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OverlapSettings {
    /// Sampled phases per turn.
    pub phases: usize,
    /// Gap to prove between the samples, mm.
    pub floor: f64,
}

/// A body with its search tree.
pub(super) struct Part<'a> {
    pub body: &'a RigidBody,
    pub tree: Tree,
}

impl<'a> Part<'a> {
    pub fn new(body: &'a RigidBody) -> Part<'a> {
        Part { body, tree: Tree::new(&body.mesh) }
    }
}

/// Proves a pair of bodies apart, or says where they are not.
pub(super) fn apart(
    (first, second): (&Part, &Part),
    mechanism: &Mechanism,
    settings: &OverlapSettings,
) -> PairProof {
    let movers = (first.body.mover, second.body.mover);
    let remainder = mechanism.remainder(movers);
    let step = TAU / settings.phases as f64;
    let runs: Vec<Vec<usize>> = (0..settings.phases)
        .collect::<Vec<_>>()
        .chunks(RUN)
        .map(<[usize]>::to_vec)
        .collect();
    let sampled: Vec<(f64, Near)> = runs
        .par_iter()
        .flat_map_iter(|run| {
            let mut hint = None;
            run.iter()
                .filter_map(|&i| {
                    let phi = i as f64 * step;
                    let (pose, _) = mechanism.seen(movers, phi, remainder);
                    let near = Placed::new(&first.tree, &second.tree, pose)
                        .nearest(f64::INFINITY, TOUCH, hint)?;
                    hint = Some(near.pair);
                    Some((phi, near))
                })
                .collect::<Vec<_>>()
        })
        .collect();
    let doubts: Vec<Place> = (0..settings.phases)
        .into_par_iter()
        .filter_map(|i| {
            between((first, second), mechanism, &Stretch {
                movers,
                remainder,
                floor: settings.floor.max(TOUCH),
                phi: (i as f64 + 0.5) * step,
                half: step / 2.0,
            })
        })
        .collect();
    let place = |phi: f64, x: Vector3<f64>| Place {
        phi,
        at: mechanism.placed(movers.0, phi).apply(x).into(),
    };
    let nested = nested(first, second);
    let mut colliding: Vec<(f64, Vector3<f64>)> = sampled
        .iter()
        .filter(|(_, n)| n.closest.distance <= TOUCH)
        .map(|(phi, n)| (*phi, n.closest.p))
        .collect();
    if let (true, Some(at)) = (nested && colliding.is_empty(), second.body.mesh.vertices.first()) {
        colliding.push((0.0, Vector3::from(*at)));
    }
    let mut overlap = (Some(0.0), None);
    let stride = colliding.len().div_ceil(VOLUMES).max(1);
    for &(phi, at) in colliding.iter().step_by(stride) {
        let pose = mechanism.placed(movers.0, phi).inverse_mul(&mechanism.placed(movers.1, phi));
        let volume = shared_volume(&first.body.mesh, &second.body.mesh.moved(&pose));
        if overlap.1.is_none() || volume > overlap.0 {
            overlap = (volume, Some(place(phi, at)));
        }
    }
    let smallest = sampled
        .iter()
        .min_by(|a, b| a.1.closest.distance.total_cmp(&b.1.closest.distance));
    let (gap, gap_at) = match smallest {
        Some((phi, n)) if !nested => (n.closest.distance, place(*phi, n.closest.p)),
        _ => (0.0, Place::default()),
    };
    PairProof {
        bodies: [first.body.name.clone(), second.body.name.clone()],
        gap_mm: gap,
        gap_at,
        gaps_mm: sampled.iter().map(|(_, n)| n.closest.distance).collect(),
        colliding_phases: if nested { settings.phases } else { colliding.len() },
        overlap_mm3: overlap.0,
        overlap_at: overlap.1,
        doubts,
    }
}

/// A stretch phi ± half of the motion of one pair.
struct Stretch {
    movers: (Mover, Mover),
    remainder: (f64, f64),
    floor: f64,
    phi: f64,
    half: f64,
}

/// Proves the gap above `floor` over the stretch; `None` is proven, otherwise where it is in doubt.
/// Triangle pairs in doubt are looked at again in ever shorter pieces of the stretch.
fn between(parts: (&Part, &Part), mechanism: &Mechanism, stretch: &Stretch) -> Option<Place> {
    let (pose, drift) = mechanism.seen(stretch.movers, stretch.phi, stretch.remainder);
    let placed = Placed::new(&parts.0.tree, &parts.1.tree, pose);
    let pairs = placed.doubtful(&drift, stretch.half, stretch.floor);
    let mut work = vec![(stretch.phi, stretch.half, pairs)];
    while let Some((phi, half, pairs)) = work.pop() {
        let Some(&first_pair) = pairs.first() else { continue };
        let (pose, _) = mechanism.seen(stretch.movers, phi, stretch.remainder);
        let placed = Placed::new(&parts.0.tree, &parts.1.tree, pose);
        if half < stretch.half / f64::from(1 << HALVINGS) {
            let at = placed.pair(first_pair).map_or(Vector3::zeros(), |c| c.p);
            let at = mechanism.placed(stretch.movers.0, phi).apply(at);
            return Some(Place { phi, at: at.into() });
        }
        for sub_phi in [phi + half / 2.0, phi - half / 2.0] {
            let (pose, drift) = mechanism.seen(stretch.movers, sub_phi, stretch.remainder);
            let placed = Placed::new(&parts.0.tree, &parts.1.tree, pose);
            let left = placed.still_doubtful(&pairs, (&drift, half / 2.0, stretch.floor));
            work.push((sub_phi, half / 2.0, left));
        }
    }
    None
}

/// Whether one body starts inside the other without surface contact. (It could only get there
/// later by crossing a surface, which the samples and the bound between them see.)
fn nested(first: &Part, second: &Part) -> bool {
    let inside = |inner: &Part, outer: &Part| {
        super::mesh::components(&inner.body.mesh)
            .iter()
            .any(|&vertex| outer.tree.winding(inner.body.mesh.vertex(vertex)).abs() > 0.5)
    };
    inside(first, second) || inside(second, first)
}

/// Volume shared by two closed meshes in the same frame, mm³; `None` when the kernel refuses a mesh.
fn shared_volume(a: &Mesh, b: &Mesh) -> Option<f64> {
    let solid = |mesh: &Mesh| {
        let solid = Manifold::from_mesh_gl64(&MeshGL64 {
            num_prop: 3,
            vert_properties: mesh.vertices.iter().flatten().copied().collect(),
            tri_verts: mesh.triangles.iter().flatten().map(|&i| u64::from(i)).collect(),
            ..Default::default()
        });
        (solid.status() == Status::NoError).then_some(solid)
    };
    let shared = solid(a)?.intersection(&solid(b)?);
    (shared.status() == Status::NoError)
        .then(|| shared.volume())
        .filter(|v| v.is_finite())
}
