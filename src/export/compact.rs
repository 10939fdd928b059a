//! Meshes small enough to live inside a web page: simplified, on a 16-bit grid, base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{Error as Status, MeshGLP};
use serde::Serialize;

use crate::solid::Mesh;

/// Largest distance a surface may move by simplifying, mm: less than a printer or a screen shows.
const TOLERANCE: f64 = 0.01;

/// A mesh for the viewer. Vertex i is at `origin` + `step` · (its three 16-bit numbers).
#[derive(Debug, Clone, Serialize)]
pub struct CompactMesh {
    /// Smallest corner, mm.
    pub origin: [f64; 3],
    /// Grid spacing along each axis, mm.
    pub step: [f64; 3],
    /// Little-endian u16 triples, base64.
    pub positions: String,
    /// Little-endian u32 triples, base64.
    pub triangles: String,
}

impl CompactMesh {
    /// Compacts `mesh`.
    pub fn new(mesh: &Mesh) -> CompactMesh {
        let simple = simplified(mesh);
        let (low, high) = simple.bounds();
        let step = ((high - low) / f64::from(u16::MAX)).map(|s| s.max(f64::MIN_POSITIVE));
        let mut positions = Vec::with_capacity(simple.vertices.len() * 6);
        for v in &simple.vertices {
            for axis in 0..3 {
                let grid = ((v[axis] - low[axis]) / step[axis]).round() as u16;
                positions.extend(grid.to_le_bytes());
            }
        }
        let triangles: Vec<u8> = simple
            .triangles
            .iter()
            .flatten()
            .flat_map(|i| i.to_le_bytes())
            .collect();
        CompactMesh {
            origin: low.into(),
            step: step.into(),
            positions: STANDARD.encode(positions),
            triangles: STANDARD.encode(triangles),
        }
    }
}

/// `mesh` with nearly flat and needless triangles merged; itself where the kernel refuses it.
pub fn simplified(mesh: &Mesh) -> Mesh {
    let solid = Manifold::from_mesh_glp(&MeshGLP::<f64, u32> {
        num_prop: 3,
        vert_properties: mesh.vertices.iter().flatten().copied().collect(),
        tri_verts: mesh.triangles.iter().flatten().copied().collect(),
        ..Default::default()
    })
    .simplify(TOLERANCE);
    if solid.status() != Status::NoError || solid.is_empty() {
        return mesh.clone();
    }
    let out: MeshGLP<f64, u32> = solid.get_mesh_glp(-1);
    let stride = (out.num_prop as usize).max(3);
    Mesh {
        vertices: out
            .vert_properties
            .chunks_exact(stride)
            .map(|p| [p[0], p[1], p[2]])
            .collect(),
        triangles: out
            .tri_verts
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
    }
}
