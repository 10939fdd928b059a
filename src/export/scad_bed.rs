//! Which face of a piece lies on the print bed and how much room it takes there, as expressions that
//! follow the parameters.

use nalgebra::{Rotation3, Vector3};

use super::scad_csg::readable;
use super::scad_teeth::number;
use crate::Result;
use crate::solid::expression::Values;
use crate::solid::primitive;
use crate::solid::recipe::{Feature, Operation, Shape};

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

/// Corners `[[x, y], [x, y]]` of the rectangle on the bed that holds what `features` add, with the
/// direction `up` upwards as the library's `upright()` turns it.
///
/// # Errors
/// As [`primitive::build`].
pub fn corners(features: &[Feature], up: [f64; 3], values: &Values) -> Result<String> {
    let [x, y] = across(Vector3::from(up));
    let least = |way: Vector3<f64>| Ok(negative(&most(features, -way, values)?));
    Ok(format!(
        "[[{}, {}], [{}, {}]]",
        least(x)?,
        least(y)?,
        most(features, x, values)?,
        most(features, y, values)?
    ))
}

/// The directions in the piece's frame that become x and y of the bed.
pub fn across(up: Vector3<f64>) -> [Vector3<f64>; 2] {
    let turn = -f64::atan2(up.y, up.x);
    let tip = -(up.z / up.norm()).clamp(-1.0, 1.0).acos();
    let turned = Rotation3::from_axis_angle(&Vector3::y_axis(), tip)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), turn);
    let row = |i: usize| {
        let row = turned.matrix().row(i).transpose();
        // Of an axis, what the sines leave beside zero is not meant.
        row.map(|c| {
            if (c - c.round()).abs() < 1e-12 {
                c.round()
            } else {
                c
            }
        })
    };
    [row(0), row(1)]
}

/// How far what `features` add reaches along `way`: an expression where `way` is along an axis, else
/// the number with the values as they are.
fn most(features: &[Feature], way: Vector3<f64>, values: &Values) -> Result<String> {
    let added = features.iter().filter(|f| f.operation == Operation::Add);
    let ends: Option<Vec<String>> = added.map(|f| end(&f.shape, way)).collect();
    match ends {
        Some(mut ends) if !ends.is_empty() => {
            ends.sort();
            ends.dedup();
            Ok(match &ends[..] {
                [end] => end.clone(),
                _ => format!("max({})", ends.join(", ")),
            })
        }
        _ => {
            let mesh = primitive::build(features, values)?.mesh();
            let reach = mesh.vertices.iter().map(|&v| Vector3::from(v).dot(&way));
            Ok(number(reach.fold(f64::NEG_INFINITY, f64::max), 4))
        }
    }
}

/// The farthest coordinate of a primitive along `way`, if that is one of the axes in either direction.
fn end(shape: &Shape, way: Vector3<f64>) -> Option<String> {
    let i = (0..3).find(|&i| way[i].abs() == 1.0)?;
    let up = way[i] > 0.0;
    let signed = |e: &str| {
        if up {
            readable(e)
        } else {
            negative(&readable(e))
        }
    };
    let around = |at: &str, radius: &str| format!("{} + {}", signed(at), grouped(radius));
    match shape {
        Shape::Block { min, max } => Some(signed(if up { &max[i] } else { &min[i] })),
        Shape::Ball { center, radius } => Some(around(&center[i], radius)),
        Shape::Cone {
            base, axis, length, ..
        } if axis[i].abs() == 1.0 => Some(along(&base[i], axis[i], length, up)),
        Shape::Cone {
            base, axis, r0, r1, ..
        } if axis[i] == 0.0 => {
            let radius = if r0 == r1 {
                r0.clone()
            } else {
                format!("max({r0}, {r1})")
            };
            Some(around(&base[i], &radius))
        }
        Shape::Prism {
            base, axis, length, ..
        } if axis[i].abs() == 1.0 => Some(along(&base[i], axis[i], length, up)),
        Shape::Prism {
            base, axis, width, ..
        } if axis[i] == 0.0 => Some(around(&base[i], width)),
        _ => None,
    }
}

/// The end towards `up` of a solid along an axis.
fn along(base: &str, axis: f64, length: &str, up: bool) -> String {
    let towards = (axis > 0.0) == up;
    let base = if up {
        readable(base)
    } else {
        negative(&readable(base))
    };
    match towards {
        true => format!("{base} + {}", grouped(length)),
        false => base,
    }
}

fn grouped(expression: &str) -> String {
    let text = readable(expression);
    match text.contains(' ') {
        true => format!("({text})"),
        false => text,
    }
}

fn negative(expression: &str) -> String {
    match (expression, expression.strip_prefix('-')) {
        ("0", _) => "0".into(),
        (_, Some(rest)) if !rest.contains(' ') => rest.into(),
        (text, _) if text.contains(' ') && !text.starts_with("max(") => format!("-({text})"),
        (text, _) => format!("-{text}"),
    }
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
