//! Indexed triangle mesh, the currency between kernel, proof and files.

use nalgebra::Vector3;

use crate::motion::Pose;

/// Indexed triangle mesh; triangles wind counter-clockwise seen from outside; mm.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub vertices: Vec<[f64; 3]>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Position of vertex `i`.
    pub fn vertex(&self, i: u32) -> Vector3<f64> {
        Vector3::from(self.vertices[i as usize])
    }

    /// The mesh moved by a rigid pose.
    pub fn moved(&self, pose: &Pose) -> Mesh {
        Mesh {
            vertices: self
                .vertices
                .iter()
                .map(|&v| pose.apply(Vector3::from(v)).into())
                .collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Signed volume by the divergence theorem, mm³; positive for outward winding.
    pub fn volume(&self) -> f64 {
        self.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| self.vertex(i));
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum()
    }

    /// Corners of the bounding box (min, max); zeros for an empty mesh.
    pub fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let mut points = self.vertices.iter().map(|&v| Vector3::from(v));
        let Some(first) = points.next() else {
            return (Vector3::zeros(), Vector3::zeros());
        };
        points.fold((first, first), |(lo, hi), p| (lo.inf(&p), hi.sup(&p)))
    }
}
