//! From recipe features to solids: each primitive as a mesh, then added, cut or kept in order.

use nalgebra::Vector3;

use super::Mesh;
use super::expression::Values;
use super::kernel::{self, Solid};
use super::recipe::{Feature, Operation, Shape};
use crate::motion::Pose;
use crate::{Error, Result};

/// Corners of the polygon that stands for a circle of this radius (mm); the same rule is in the
/// OpenSCAD templates, so that both volumes agree.
pub fn circle_segments(radius: f64) -> u32 {
    if radius < 2.5 {
        24
    } else if radius < 6.0 {
        48
    } else {
        72
    }
}

/// Corners of a ball's equator; half as many rings, centred between its poles.
pub const BALL_SEGMENTS: u32 = 48;

/// The solid that `features` describe, in order.
///
/// # Errors
/// [`Error::Internal`] when an expression or a dimension is not usable.
pub fn build(features: &[Feature], values: &Values) -> Result<Solid> {
    let mut solid = Solid::empty();
    for feature in features {
        let tool = Solid::new(&mesh(feature, values)?, &feature.name)?;
        solid = match feature.operation {
            Operation::Add => solid.union(&tool),
            Operation::Cut => solid.difference(&tool),
            Operation::Keep => solid.intersection(&tool),
        };
    }
    Ok(solid)
}

/// The mesh of one primitive, in the body's frame.
///
/// # Errors
/// [`Error::Internal`] when an expression fails or a dimension is not positive.
pub fn mesh(feature: &Feature, values: &Values) -> Result<Mesh> {
    let positive = |what: &str, value: f64| {
        if value > 0.0 {
            Ok(value)
        } else {
            Err(Error::Internal(format!(
                "feature `{}`: {what} is {value:.4} mm, must be positive",
                feature.name
            )))
        }
    };
    let along = |mesh: Mesh, axis: &[f64; 3], base: Vector3<f64>| {
        mesh.moved(&Pose {
            rotation: kernel::towards(Vector3::from(*axis)),
            translation: base,
        })
    };
    match &feature.shape {
        Shape::Cone {
            base,
            axis,
            length,
            r0,
            r1,
        } => {
            let length = positive("length", values.eval(length)?)?;
            let r0 = positive("radius", values.eval(r0)?)?;
            let r1 = positive("radius", values.eval(r1)?)?;
            let profile = [(r0, 0.0), (r1, length)];
            let mesh = kernel::lathe(&profile, circle_segments(r0.max(r1)));
            Ok(along(mesh, axis, values.point(base)?))
        }
        Shape::Block { min, max } => {
            let (lo, hi) = (values.point(min)?, values.point(max)?);
            let size = hi - lo;
            for (what, extent) in ["x extent", "y extent", "z extent"].iter().zip(size.iter()) {
                positive(what, *extent)?;
            }
            Ok(block(lo, hi))
        }
        Shape::Ball { center, radius } => {
            let radius = positive("radius", values.eval(radius)?)?;
            let rings = BALL_SEGMENTS / 2;
            let profile: Vec<(f64, f64)> = (0..rings)
                .map(|i| {
                    let polar = (f64::from(i) + 0.5) * std::f64::consts::PI / f64::from(rings);
                    (radius * polar.sin(), -radius * polar.cos())
                })
                .collect();
            let mesh = kernel::lathe(&profile, BALL_SEGMENTS);
            Ok(along(mesh, &[0.0, 0.0, 1.0], values.point(center)?))
        }
        Shape::Prism {
            base,
            axis,
            length,
            width,
            sides,
        } => {
            let length = positive("length", values.eval(length)?)?;
            let width = positive("width", values.eval(width)?)?;
            let radius = 0.5 * width / (std::f64::consts::PI / f64::from(*sides)).cos();
            let mesh = kernel::lathe(&[(radius, 0.0), (radius, length)], *sides);
            Ok(along(mesh, axis, values.point(base)?))
        }
    }
}

fn block(lo: Vector3<f64>, hi: Vector3<f64>) -> Mesh {
    let corner = |x: f64, y: f64, z: f64| [x, y, z];
    Mesh {
        vertices: vec![
            corner(lo.x, lo.y, lo.z),
            corner(hi.x, lo.y, lo.z),
            corner(hi.x, hi.y, lo.z),
            corner(lo.x, hi.y, lo.z),
            corner(lo.x, lo.y, hi.z),
            corner(hi.x, lo.y, hi.z),
            corner(hi.x, hi.y, hi.z),
            corner(lo.x, hi.y, hi.z),
        ],
        triangles: vec![
            [0, 2, 1],
            [0, 3, 2],
            [4, 5, 6],
            [4, 6, 7],
            [0, 1, 5],
            [0, 5, 4],
            [1, 2, 6],
            [1, 6, 5],
            [2, 3, 7],
            [2, 7, 6],
            [3, 0, 4],
            [3, 4, 7],
        ],
    }
}
