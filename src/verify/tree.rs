//! Bounding-box tree over the triangles of one mesh, in the mesh's own frame; built once, queried
//! at every phase under a rigid pose.

use nalgebra::Vector3;

use super::triangle::{Closest, Triangle};
use crate::solid::Mesh;

/// Triangles per leaf: below this a box test costs as much as it saves.
const LEAF: usize = 3;

/// Box of a subtree; a leaf holds `count` triangles from `first`, an inner node's children are
/// itself + 1 and `first`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub centre: Vector3<f64>,
    pub half: Vector3<f64>,
    pub first: u32,
    pub count: u32,
}

impl Node {
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }

    /// Squared distance from `p` to the box.
    fn distance_squared(&self, p: Vector3<f64>) -> f64 {
        ((p - self.centre).abs() - self.half)
            .sup(&Vector3::zeros())
            .norm_squared()
    }
}

/// Triangles of a mesh in tree order.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    pub triangles: Vec<Triangle>,
    /// Index in the mesh of each triangle of the tree.
    pub source: Vec<u32>,
}

impl Tree {
    /// Splits at the median of the widest axis of the centroids; ties by index, so the tree depends on the mesh only.
    pub fn new(mesh: &Mesh) -> Tree {
        let soup: Vec<Triangle> = mesh
            .triangles
            .iter()
            .map(|t| Triangle::new(t.map(|i| mesh.vertex(i))))
            .collect();
        let centroids: Vec<Vector3<f64>> = soup.iter().map(Triangle::centroid).collect();
        let mut order: Vec<u32> = (0..soup.len() as u32).collect();
        let mut nodes = Vec::with_capacity(soup.len());
        if !order.is_empty() {
            let count = order.len();
            split(&soup, &centroids, &mut nodes, (&mut order, 0, count));
        }
        let triangles = order.iter().map(|&i| soup[i as usize]).collect();
        Tree {
            nodes,
            triangles,
            source: order,
        }
    }

    pub fn leaf(&self, node: &Node) -> std::ops::Range<usize> {
        node.first as usize..(node.first + node.count) as usize
    }

    /// What the triangles under every node have together, by tree index of a triangle.
    pub fn under<T: Copy>(
        &self,
        of: impl Fn(usize) -> T,
        both: impl Fn(T, T) -> T,
    ) -> Vec<Option<T>> {
        let mut all = vec![None; self.nodes.len()];
        // Children stand behind their parent.
        for (i, node) in self.nodes.iter().enumerate().rev() {
            all[i] = match node.is_leaf() {
                true => self.leaf(node).map(&of).reduce(&both),
                false => all[i + 1]
                    .zip(all[node.first as usize])
                    .map(|(a, b)| both(a, b)),
            };
        }
        all
    }

    /// Nearest point of the surface to `p` closer than `within`, with the triangle's tree index.
    pub fn nearest(&self, p: Vector3<f64>, within: f64) -> Option<(Closest, usize)> {
        self.nearest_of(p, within, |_| false)
    }

    /// The same, of the surface outside the nodes that `skip` names.
    pub fn nearest_of(
        &self,
        p: Vector3<f64>,
        within: f64,
        skip: impl Fn(usize) -> bool,
    ) -> Option<(Closest, usize)> {
        let mut best = within * within;
        let mut found = None;
        let reach = |i: usize| (i, self.nodes[i].distance_squared(p));
        let mut stack: Vec<(usize, f64)> = Vec::with_capacity(64);
        stack.extend(self.nodes.first().map(|_| reach(0)));
        while let Some((i, box_squared)) = stack.pop() {
            // Written so that a NaN is looked into.
            if box_squared >= best || skip(i) {
                continue;
            }
            let node = &self.nodes[i];
            if node.is_leaf() {
                for k in self.leaf(node) {
                    let triangle = &self.triangles[k];
                    let above = triangle.normal.dot(&(p - triangle.corners[0]));
                    if above * above >= best {
                        continue;
                    }
                    let q = triangle.nearest(p);
                    let d2 = (q - p).norm_squared();
                    if d2 < best {
                        best = d2;
                        found = Some((q, k));
                    }
                }
            } else {
                let (a, b) = (reach(i + 1), reach(node.first as usize));
                let (near, far) = if a.1 < b.1 { (a, b) } else { (b, a) };
                stack.extend([far, near].into_iter().filter(|c| c.1 < best));
            }
        }
        found.map(|(q, k)| {
            (
                Closest {
                    distance: best.sqrt(),
                    p,
                    q,
                },
                k,
            )
        })
    }

    /// First triangle that the segment crosses, other than `but`: how far along (0 to 1), tree index.
    pub fn first_hit(
        &self,
        segment: (Vector3<f64>, Vector3<f64>),
        but: usize,
    ) -> Option<(f64, usize)> {
        let (from, to) = segment;
        let along = to - from;
        let mut first: Option<(f64, usize)> = None;
        let mut stack = vec![0usize];
        while let Some(i) = stack.pop() {
            let Some(node) = self.nodes.get(i) else {
                continue;
            };
            let reach = first.map_or(1.0, |f| f.0) / 2.0;
            // Box of the segment up to the first hit so far.
            let middle = from + along * reach;
            let apart = (middle - node.centre).abs() - (along * reach).abs() - node.half;
            if apart.max() > 0.0 {
                continue;
            }
            if node.is_leaf() {
                for k in self.leaf(node).filter(|&k| k != but) {
                    if let Some(x) = self.triangles[k].pierced(from, to) {
                        let t = along.dot(&(x - from)) / along.norm_squared();
                        if first.is_none_or(|f| t < f.0) {
                            first = Some((t, k));
                        }
                    }
                }
            } else {
                stack.extend([i + 1, node.first as usize]);
            }
        }
        first
    }

    /// Tree indices of the triangles whose leaf box meets the box of `t`.
    pub fn near_boxes(&self, t: &Triangle) -> Vec<usize> {
        let [a, b, c] = t.corners;
        let (lo, hi) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let (centre, half) = ((lo + hi) / 2.0, (hi - lo) / 2.0);
        let mut near = Vec::new();
        let mut stack = vec![0usize];
        while let Some(i) = stack.pop() {
            let Some(node) = self.nodes.get(i) else {
                continue;
            };
            let apart = (node.centre - centre).abs() - node.half - half;
            if apart.max() > 0.0 {
                continue;
            }
            if node.is_leaf() {
                near.extend(self.leaf(node));
            } else {
                stack.extend([i + 1, node.first as usize]);
            }
        }
        near
    }

    /// How often the closed surface winds around `p`: 1 inside, 0 outside (solid angle / 4π).
    pub fn winding(&self, p: Vector3<f64>) -> f64 {
        let solid_angle = |t: &Triangle| {
            let [a, b, c] = t.corners.map(|v| v - p);
            let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
            let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            2.0 * a.dot(&b.cross(&c)).atan2(denominator)
        };
        self.triangles.iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }
}

/// Builds the subtree over `order[from..to]`; returns its node index.
fn split(
    soup: &[Triangle],
    centroids: &[Vector3<f64>],
    nodes: &mut Vec<Node>,
    (order, from, to): (&mut [u32], usize, usize),
) -> usize {
    let unbounded = (
        Vector3::repeat(f64::INFINITY),
        Vector3::repeat(f64::NEG_INFINITY),
    );
    let (lo, hi) = order[from..to]
        .iter()
        .flat_map(|&i| soup[i as usize].corners)
        .fold(unbounded, |(lo, hi), v| (lo.inf(&v), hi.sup(&v)));
    let index = nodes.len();
    nodes.push(Node {
        centre: (lo + hi) / 2.0,
        half: (hi - lo) / 2.0,
        first: from as u32,
        count: (to - from) as u32,
    });
    if to - from > LEAF {
        let (lo, hi) = order[from..to]
            .iter()
            .map(|&i| centroids[i as usize])
            .fold(unbounded, |(lo, hi), v| (lo.inf(&v), hi.sup(&v)));
        let axis = (hi - lo).imax();
        let middle = (to - from) / 2;
        order[from..to].select_nth_unstable_by(middle, |&i, &j| {
            centroids[i as usize][axis]
                .total_cmp(&centroids[j as usize][axis])
                .then(i.cmp(&j))
        });
        split(soup, centroids, nodes, (order, from, from + middle));
        let right = split(soup, centroids, nodes, (order, from + middle, to));
        nodes[index].first = right as u32;
        nodes[index].count = 0;
    }
    index
}
