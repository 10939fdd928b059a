//! Thin wrapper over the solid kernel (`manifold-rust`): meshes in, booleans, meshes out, and one
//! place that says what a sound solid is.

use manifold_rust::cross_section::CrossSection;
use manifold_rust::linalg::{Vec2, Vec3};
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{BooleanEngine, Error as Status, MeshGLP, OpType, Rect};
use nalgebra::{Matrix3, Vector3};

use super::{Mesh, slivers};
use crate::{Error, Result};

/// Triangles and edges smaller than this are seams of the booleans and are taken out of finished
/// bodies, mm: ten units in the last place of an STL file's coordinates, which would otherwise fold them.
const SEAM: f64 = 2e-5;

/// A closed, oriented solid in the kernel.
#[derive(Clone)]
pub struct Solid(Manifold);

/// Loose pieces and voids up to this are crumbs of the booleans, where surfaces nearly coincide, mm³.
const CRUMB: f64 = 1e-3;

impl Solid {
    /// The empty solid.
    pub fn empty() -> Solid {
        Solid(Manifold::empty())
    }

    /// A solid from a closed mesh with outward winding; `name` is for the error.
    ///
    /// # Errors
    /// [`Error::Internal`] when the mesh is open, not a manifold, not finite, or empty.
    pub fn new(mesh: &Mesh, name: &str) -> Result<Solid> {
        let manifold = Manifold::from_mesh_glp(&MeshGLP::<f64, u32> {
            num_prop: 3,
            vert_properties: mesh.vertices.iter().flatten().copied().collect(),
            tri_verts: mesh.triangles.iter().flatten().copied().collect(),
            ..Default::default()
        });
        Solid(manifold).sound(name)
    }

    /// Everything that is in `self` or in `other`.
    pub fn union(&self, other: &Solid) -> Solid {
        self.boolean(other, OpType::Add)
    }

    /// What is in `self` but not in `other`.
    pub fn difference(&self, other: &Solid) -> Solid {
        self.boolean(other, OpType::Subtract)
    }

    /// What is in both.
    pub fn intersection(&self, other: &Solid) -> Solid {
        self.boolean(other, OpType::Intersect)
    }

    fn boolean(&self, other: &Solid, operation: OpType) -> Solid {
        let engine = BooleanEngine::Exact;
        Solid(self.0.boolean_with_engine(&other.0, operation, engine))
    }

    /// Union of meshes that may intersect themselves a little (twisted ribs): looks first, and
    /// resolves them if they do. Slower than [`Solid::union`].
    pub fn union_resolved(&self, other: &Solid) -> Solid {
        let engine = BooleanEngine::Auto;
        Solid(self.0.boolean_with_engine(&other.0, OpType::Add, engine))
    }

    /// Union of many solids by halves, which keeps the operands small.
    pub fn union_of(solids: &[Solid]) -> Solid {
        match solids {
            [] => Solid::empty(),
            [one] => one.clone(),
            many => {
                let (left, right) = many.split_at(many.len() / 2);
                Solid::union_of(left).union(&Solid::union_of(right))
            }
        }
    }

    /// The solid without edges and steps below `tolerance`, mm.
    pub fn smoothed(&self, tolerance: f64) -> Solid {
        Solid(self.0.simplify(tolerance))
    }

    /// A solid that stands on z = 0 with its lowest `amount` (mm) drawn in by as much, against a printer
    /// that presses its first layers wide.
    pub fn foot_drawn_in(&self, amount: f64) -> Solid {
        let down = Vec3::new(0.0, 0.0, -1.0);
        let outline = self.0.trim_by_plane(down, -amount).project();
        let bounds = outline.bounds();
        let margin = Vec2::new(1.0, 1.0);
        let all =
            CrossSection::from_rect(&Rect::from_points(bounds.min - margin, bounds.max + margin));
        let around = all.difference(&outline.offset(-amount)).to_polygons();
        let straight = Vec2::new(1.0, 1.0);
        let layers = Manifold::extrude(&around, 1.0 + amount, 0, 0.0, straight).translate(down);
        self.difference(&Solid(layers))
    }

    /// Volume, mm³.
    pub fn volume(&self) -> f64 {
        self.0.volume()
    }

    /// Number of connected surfaces (a solid with a void inside has two).
    pub fn components(&self) -> usize {
        self.0.decompose().len()
    }

    /// The solid as an indexed mesh, outward winding.
    pub fn mesh(&self) -> Mesh {
        let out: MeshGLP<f64, u32> = self.0.get_mesh_glp(-1);
        let stride = out.num_prop as usize;
        Mesh {
            vertices: out
                .vert_properties
                .chunks_exact(stride.max(3))
                .map(|p| [p[0], p[1], p[2]])
                .collect(),
            triangles: out
                .tri_verts
                .chunks_exact(3)
                .map(|t| [t[0], t[1], t[2]])
                .collect(),
        }
    }

    /// The mesh of a solid that has to be one closed body.
    ///
    /// # Errors
    /// [`Error::Internal`] when a boolean failed, or the solid is empty or in several pieces.
    pub fn one_body(self, name: &str) -> Result<Mesh> {
        let solid = self.sound(name)?.smoothed(SEAM).sound(name)?;
        let mut pieces: Vec<Mesh> = solid
            .0
            .decompose()
            .into_iter()
            .map(|piece| Solid(piece).mesh())
            .collect();
        pieces.sort_by(|a, b| b.volume().abs().total_cmp(&a.volume().abs()));
        let mut pieces = pieces.into_iter();
        let Some(mut mesh) = pieces.next() else {
            return Err(Error::Internal(format!("{name}: the solid is empty")));
        };
        if let Some(loose) = pieces.find(|piece| piece.volume().abs() > CRUMB) {
            let (lo, hi) = loose.bounds();
            return Err(Error::Internal(format!(
                "{name}: a piece of {:.3} mm³ from ({:.1}, {:.1}, {:.1}) to ({:.1}, {:.1}, {:.1}) mm is loose",
                loose.volume(),
                lo.x,
                lo.y,
                lo.z,
                hi.x,
                hi.y,
                hi.z
            )));
        }
        if mesh.volume() <= 0.0 {
            return Err(Error::Internal(format!("{name}: the solid is inside out")));
        }
        slivers::remove(&mut mesh);
        Ok(mesh)
    }

    fn sound(self, name: &str) -> Result<Solid> {
        match self.0.status() {
            Status::NoError if !self.0.is_empty() => Ok(self),
            Status::NoError => Err(Error::Internal(format!("{name}: the solid is empty"))),
            status => Err(Error::Internal(format!("{name}: {}", status.to_str()))),
        }
    }
}

/// Closed mesh of revolution about z through regular polygons of `sides` corners, one per
/// (radius, height) pair, heights increasing; a corner of each polygon lies over +x.
pub fn lathe(profile: &[(f64, f64)], sides: u32) -> Mesh {
    let rings = profile.len() as u32;
    let mut mesh = Mesh::default();
    for &(radius, z) in profile {
        for i in 0..sides {
            let angle = f64::from(i) * std::f64::consts::TAU / f64::from(sides);
            mesh.vertices
                .push([radius * angle.cos(), radius * angle.sin(), z]);
        }
    }
    for ring in 0..rings - 1 {
        for i in 0..sides {
            let (a, b) = (ring * sides + i, ring * sides + (i + 1) % sides);
            mesh.triangles.push([a, b, b + sides]);
            mesh.triangles.push([a, b + sides, a + sides]);
        }
    }
    let top = (rings - 1) * sides;
    for i in 1..sides - 1 {
        mesh.triangles.push([0, i + 1, i]);
        mesh.triangles.push([top, top + i, top + i + 1]);
    }
    mesh
}

/// Rotation that takes z to `axis`: about y by its polar angle, then about z by its azimuth (what
/// OpenSCAD's `rotate([0, polar, azimuth])` does).
pub fn towards(axis: Vector3<f64>) -> Matrix3<f64> {
    let axis = axis.normalize();
    let (polar, azimuth) = (axis.z.clamp(-1.0, 1.0).acos(), axis.y.atan2(axis.x));
    let about_y = nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), polar);
    let about_z = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth);
    (about_z * about_y).into_inner()
}
