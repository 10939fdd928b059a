//! Is a mesh the boundary of one solid: closed, oriented, two triangles per edge, one fan per
//! vertex, one component, no degenerate or crossing triangles, positive volume.
//!
//! Vertices at the same single-precision position count as one, because an STL file will weld them.

use std::collections::HashMap;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::tree::Tree;
use super::triangle::Triangle;
use crate::solid::Mesh;

/// Triangles lower than this are degenerate, mm: a unit in the last place of a single-precision
/// coordinate at 10 mm.
const RESOLUTION: f64 = 1e-6;

/// Triangles that share no corner and are nearer than this meet, mm. Undecided is a crossing.
const CONTACT: f64 = 1e-9;

/// Crossings are counted up to about this many: what crosses itself that often is no surface.
const MANY_CROSSINGS: usize = 10_000;

/// Pairs of neighbouring triangles that are looked at; a surface of a million has some ten million.
const MANY_PAIRS: usize = 300_000_000;

/// Triangles whose crossings are looked for at a time.
const BATCH: usize = 64;

/// One kind of defect of a mesh, how often it occurs, and where first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshProblem {
    /// Name of the body.
    pub body: String,
    /// What is wrong.
    pub defect: Defect,
    /// Number of places (edges, vertices, triangles, pairs of triangles, extra components).
    pub count: usize,
    /// The first of them, in the frame of the mesh, mm.
    pub at: [f64; 3],
}

/// What can be wrong with a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Defect {
    /// No triangles at all.
    Empty,
    /// A coordinate is NaN or infinite, or a triangle names a vertex that does not exist.
    Unreadable,
    /// More open edges than triangles: they bound nothing.
    Loose,
    /// An edge with one triangle: a hole.
    Open,
    /// Neighbouring triangles that wind in opposite ways.
    Flipped,
    /// An edge with more than two triangles, or two sheets that share only a vertex.
    NonManifold,
    /// A triangle without area.
    Degenerate,
    /// Triangles that cross or lie on each other.
    SelfIntersecting,
    /// So many triangles in the same places that they cannot all be looked at.
    Crowded,
    /// More than one connected surface.
    Disconnected,
    /// Volume not positive: inside out.
    InsideOut,
}

impl std::fmt::Display for MeshProblem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.at;
        let what = match self.defect {
            Defect::Empty => "has no triangles",
            Defect::Unreadable => "has coordinates or indices that are not numbers of the mesh",
            Defect::Loose => "is a heap of loose triangles, no surface (open edges)",
            Defect::Open => "has a hole (edges with one triangle)",
            Defect::Flipped => "has triangles turned the wrong way round",
            Defect::NonManifold => "has edges or vertices shared by several sheets",
            Defect::Degenerate => "has triangles without area",
            Defect::SelfIntersecting => "crosses itself",
            Defect::Crowded => "has too many triangles in the same places to look for crossings",
            Defect::Disconnected => "is in more than one piece",
            Defect::InsideOut => "is inside out (volume not positive)",
        };
        write!(
            f,
            "the {} {what}: {} place(s), first at ({x:.3}, {y:.3}, {z:.3}) mm",
            self.body, self.count
        )
    }
}

impl MeshProblem {
    /// Whether the mesh bounds nothing of which more could be asked.
    pub(super) fn is_no_surface(&self) -> bool {
        match self.defect {
            Defect::Empty | Defect::Unreadable | Defect::Loose | Defect::Crowded => true,
            Defect::SelfIntersecting => self.count >= MANY_CROSSINGS,
            _ => false,
        }
    }
}

/// All defects of a mesh, as far as it is a surface at all; empty when it bounds one solid.
pub fn problems(body: &str, mesh: &Mesh) -> Vec<MeshProblem> {
    let mut found = Findings::default();
    if mesh.triangles.is_empty() {
        found.add(Defect::Empty, Vector3::zeros());
    } else if !readable(mesh) {
        found.add(Defect::Unreadable, Vector3::zeros());
    } else {
        let (welded, _) = weld(mesh);
        edges(mesh, &welded, &mut found);
        if found.loose(mesh.triangles.len()) {
            return found.of(body);
        }
        fans(mesh, &welded, &mut found);
        for &vertex in components(mesh).iter().skip(1) {
            found.add(Defect::Disconnected, mesh.vertex(vertex));
        }
        for t in &mesh.triangles {
            let triangle = Triangle::new(t.map(|i| mesh.vertex(i)));
            if triangle.height() <= RESOLUTION {
                found.add(Defect::Degenerate, triangle.corners[0]);
            }
        }
        crossings(mesh, &welded, &mut found);
        if mesh.volume() <= 0.0 {
            found.add(Defect::InsideOut, mesh.vertex(mesh.triangles[0][0]));
        }
    }
    found.of(body)
}

/// Whether all coordinates are finite and all indices exist: what every other test needs.
pub(super) fn readable(mesh: &Mesh) -> bool {
    mesh.vertices.iter().flatten().all(|x| x.is_finite())
        && mesh
            .triangles
            .iter()
            .flatten()
            .all(|&i| (i as usize) < mesh.vertices.len())
}

/// One vertex of each connected surface, in order of first appearance.
pub(super) fn components(mesh: &Mesh) -> Vec<u32> {
    let (welded, count) = weld(mesh);
    let mut groups = Groups::new(count);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| welded[i as usize]);
        groups.join(a, b);
        groups.join(a, c);
    }
    let mut seen = std::collections::HashSet::new();
    mesh.triangles
        .iter()
        .map(|t| t[0])
        .filter(|&v| seen.insert(groups.root(welded[v as usize])))
        .collect()
}

/// Defects by kind: number and first place.
#[derive(Default)]
struct Findings(Vec<(Defect, usize, Vector3<f64>)>);

impl Findings {
    fn add(&mut self, defect: Defect, at: Vector3<f64>) {
        match self.0.iter_mut().find(|(d, ..)| *d == defect) {
            Some((_, count, _)) => *count += 1,
            None => self.0.push((defect, 1, at)),
        }
    }

    /// Turns holes in a mesh of so many triangles that is nothing but holes into a defect of its own.
    fn loose(&mut self, triangles: usize) -> bool {
        let open = |f: &&mut (Defect, usize, _)| f.0 == Defect::Open && f.1 > triangles;
        let Some(holes) = self.0.iter_mut().find(open) else {
            return false;
        };
        holes.0 = Defect::Loose;
        true
    }

    fn of(self, body: &str) -> Vec<MeshProblem> {
        let problem = |(defect, count, at): (Defect, usize, Vector3<f64>)| MeshProblem {
            body: body.into(),
            defect,
            count,
            at: at.into(),
        };
        self.0.into_iter().map(problem).collect()
    }
}

/// Disjoint sets.
struct Groups(Vec<u32>);

impl Groups {
    fn new(count: usize) -> Groups {
        Groups((0..count as u32).collect())
    }

    fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.root(i), self.root(j));
        self.0[i.max(j) as usize] = i.min(j);
    }
}

/// Index of the welded vertex of every vertex, and how many there are.
fn weld(mesh: &Mesh) -> (Vec<u32>, usize) {
    let mut index = HashMap::new();
    let welded = mesh
        .vertices
        .iter()
        .map(|v| {
            // + 0.0 makes −0 and 0 one key.
            let key = v.map(|x| (x as f32 + 0.0).to_bits());
            let next = index.len() as u32;
            *index.entry(key).or_insert(next)
        })
        .collect();
    (welded, index.len())
}

/// Every edge must be used once in each direction.
fn edges(mesh: &Mesh, welded: &[u32], found: &mut Findings) {
    let mut uses: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(3 * mesh.triangles.len());
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let (wa, wb) = (welded[a as usize], welded[b as usize]);
            // An edge that welding shrinks to a point is reported as a degenerate triangle.
            if wa != wb {
                uses.push((wa.min(wb), wa.max(wb), wa < wb, a));
            }
        }
    }
    uses.sort_unstable();
    for edge in uses.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let forward = edge.iter().filter(|e| e.2).count();
        let at = mesh.vertex(edge[0].3);
        match (edge.len(), forward) {
            (2, 1) => {}
            (1, _) => found.add(Defect::Open, at),
            (2, _) => found.add(Defect::Flipped, at),
            _ => found.add(Defect::NonManifold, at),
        }
    }
}

/// The triangles around every vertex must form one fan.
fn fans(mesh: &Mesh, welded: &[u32], found: &mut Findings) {
    // Corners are joined across edges: all corners at one vertex must end in one group.
    let mut corners = Groups::new(3 * mesh.triangles.len());
    let mut across: HashMap<(u32, u32), (u32, u32)> = HashMap::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let w = triangle.map(|i| welded[i as usize]);
        for k in 0..3 {
            let (i, j) = (k, (k + 1) % 3);
            let (ci, cj) = ((3 * t + i) as u32, (3 * t + j) as u32);
            let key = (w[i].min(w[j]), w[i].max(w[j]));
            let ends = if w[i] < w[j] { (ci, cj) } else { (cj, ci) };
            let first = *across.entry(key).or_insert(ends);
            corners.join(first.0, ends.0);
            corners.join(first.1, ends.1);
        }
    }
    let mut group_of: HashMap<u32, u32> = HashMap::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for (k, &v) in triangle.iter().enumerate() {
            let group = corners.root((3 * t + k) as u32);
            if *group_of.entry(welded[v as usize]).or_insert(group) != group {
                found.add(Defect::NonManifold, mesh.vertex(v));
            }
        }
    }
}

/// Places where two triangles cross, lie on each other, or fold back; batch by batch, until there are
/// [`MANY_CROSSINGS`].
fn crossings(mesh: &Mesh, welded: &[u32], found: &mut Findings) {
    let tree = Tree::new(mesh);
    let corner_ids = |k: usize| mesh.triangles[tree.source[k] as usize].map(|i| welded[i as usize]);
    let of = |k: usize| {
        let this = &tree.triangles[k];
        let ids = corner_ids(k);
        let near = tree.near_boxes(this);
        let count = near.len();
        let met = near.into_iter().filter(|&l| l > k);
        let met = met.filter_map(|l| cross(this, &tree.triangles[l], (ids, corner_ids(l))));
        (count, met.take(MANY_CROSSINGS).collect::<Vec<_>>())
    };
    let (mut pairs, mut crossings) = (0, 0);
    for first in (0..tree.triangles.len()).step_by(BATCH) {
        let last = (first + BATCH).min(tree.triangles.len());
        let batch: Vec<(usize, Vec<Vector3<f64>>)> =
            (first..last).into_par_iter().map(of).collect();
        for (near, places) in batch {
            pairs += near;
            crossings += places.len();
            for at in places {
                found.add(Defect::SelfIntersecting, at);
            }
        }
        if pairs > MANY_PAIRS {
            found.add(Defect::Crowded, tree.triangles[first].corners[0]);
        }
        if pairs > MANY_PAIRS || crossings >= MANY_CROSSINGS {
            break;
        }
    }
}

/// Where two triangles of one surface meet beyond the corners they share; `ids` are their corners.
fn cross(a: &Triangle, b: &Triangle, ids: ([u32; 3], [u32; 3])) -> Option<Vector3<f64>> {
    let own = |of: &[u32; 3], other: &[u32; 3]| (0..3).find(|&i| !other.contains(&of[i]));
    let meet = |x: &Triangle, y: &Triangle| x.closest(y, CONTACT).map(|c| c.p);
    let opposite = |t: &Triangle, i: usize| {
        let (u, v) = (t.corners[(i + 1) % 3], t.corners[(i + 2) % 3]);
        Triangle::new([u, v, v])
    };
    let shared: Vec<usize> = (0..3).filter(|&i| ids.1.contains(&ids.0[i])).collect();
    match shared[..] {
        [] => meet(a, b),
        // Whatever they share beyond the corner ends on the edge opposite to it, of one or the other.
        [i] => {
            let j = ids.1.iter().position(|v| *v == ids.0[i])?;
            meet(&opposite(a, i), b).or_else(|| meet(a, &opposite(b, j)))
        }
        // Neighbours meet beyond their edge only by folding back onto each other.
        _ => {
            let apex = a.corners[own(&ids.0, &ids.1)?];
            let folded = a.normal.dot(&b.normal) < 0.0 && (b.nearest(apex) - apex).norm() < CONTACT;
            folded.then_some(apex)
        }
    }
}
