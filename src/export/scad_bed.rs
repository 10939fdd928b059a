//! Which face of a piece lies on the print bed, as an expression that follows the parameters.

use nalgebra::Vector3;

use super::scad_csg::readable;
use super::scad_teeth::number;
use crate::Result;
use crate::solid::expression::Values;
use crate::solid::primitive;
use crate::solid::recipe::{Feature, Shape};

/// Two expressions name the same face if they differ by less, mm.
const SAME_FACE: f64 = 1e-6;

/// Coordinate along `up` of the lowest point of the solid that `features` build: the expression
/// of the face that is there, or the number where no single face is.
///
/// # Errors
/// As [`primitive::build`].
pub fn bottom(features: &[Feature], up: [f64; 3], values: &Values) -> Result<String> {
    let mesh = primitive::build(features, values)?.mesh();
    let up = Vector3::from(up);
    let heights = mesh.vertices.iter().map(|&v| Vector3::from(v).dot(&up));
    let lowest = heights.fold(f64::INFINITY, f64::min);
    for feature in features {
        for face in faces(&feature.shape, up) {
            if (values.eval(&face)? - lowest).abs() < SAME_FACE {
                return Ok(readable(&face));
            }
        }
    }
    Ok(number(lowest, 6))
}

/// Coordinates along `up` of a primitive's flat faces, where `up` is one of the axes.
fn faces(shape: &Shape, up: Vector3<f64>) -> Vec<String> {
    let Some(i) = (0..3).find(|&i| up[i].abs() == 1.0) else {
        return Vec::new();
    };
    let signed = |e: &str| match up[i] > 0.0 {
        true => e.to_string(),
        false => format!("-({e})"),
    };
    match shape {
        Shape::Block { min, max } => vec![signed(&min[i]), signed(&max[i])],
        Shape::Cone {
            base, axis, length, ..
        }
        | Shape::Prism {
            base, axis, length, ..
        } if axis[i].abs() == 1.0 => {
            let sign = if axis[i] > 0.0 { "+" } else { "-" };
            let end = format!("{} {sign} ({length})", base[i]);
            vec![signed(&base[i]), signed(&end)]
        }
        _ => Vec::new(),
    }
}
