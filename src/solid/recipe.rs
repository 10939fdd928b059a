//! Parametric description of everything that is not a tooth: named parameters, and per body a list
//! of primitive solids to add or cut whose dimensions are arithmetic expressions in the parameters.
//! The embedded kernel, the OpenSCAD templates and the FreeCAD macro all build from this one list.

use serde::{Deserialize, Serialize};

/// Named parameters and the bodies built from them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Parameters in display order.
    pub parameters: Vec<Parameter>,
    /// Rigid bodies in assembled position: `driver` in the driver frame, `follower` in the follower
    /// frame, `support` in Σ, `slider` in Σ at zero lift.
    pub bodies: Vec<Body>,
}

/// A named dimension.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Identifier, snake_case, valid in OpenSCAD and as a FreeCAD alias.
    pub name: String,
    /// Value, mm unless the description says otherwise.
    pub value: f64,
    /// Smallest sensible value.
    pub min: f64,
    /// Largest value that stays clear of the other bodies.
    pub max: f64,
    /// Customizer group (Hub, Teeth, Fit, Support, Joint).
    pub group: String,
    /// One line for the user.
    pub description: String,
}

/// One rigid body of the mechanism.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// `driver`, `follower`, `support`, `slider`.
    pub name: String,
    /// Whether the sub-gear pairs' teeth of the driver or follower belong to it.
    pub teeth: Option<crate::design::Gear>,
    /// Solids in order: each is added to or cut from what precedes it. Teeth come last, uncut.
    pub features: Vec<Feature>,
    /// Pieces to print; empty means the body is printed whole.
    pub pieces: Vec<Piece>,
}

/// A printed piece of a body that has to be split for assembly: the body's features restricted to
/// those listed, in order, with the piece's own cuts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// File name stem.
    pub name: String,
    /// Solids of the piece, in assembled position.
    pub features: Vec<Feature>,
    /// Direction (body frame) that points up on the print bed.
    pub up: [f64; 3],
}

/// Add or cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Operation {
    /// Union with what is there.
    Add,
    /// Difference from what is there.
    Cut,
    /// Intersection with what is there.
    Keep,
}

/// One primitive solid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Feature {
    /// Name shown in CAD trees.
    pub name: String,
    /// Add or cut.
    pub operation: Operation,
    /// Geometry.
    pub shape: Shape,
}

/// Expression over parameters: numbers, names, + − * / and parentheses. Evaluates to mm.
pub type Expr = String;

/// Primitive solids; all dimensions are expressions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Cylinder or cone from `base` along unit-direction `axis` (constant), radius `r0` at the base, `r1` at the end.
    Cone {
        /// Centre of the base.
        base: [Expr; 3],
        /// Constant direction.
        axis: [f64; 3],
        /// Length along the axis.
        length: Expr,
        /// Radius at the base.
        r0: Expr,
        /// Radius at the far end.
        r1: Expr,
    },
    /// Axis-parallel box.
    Block {
        /// Smallest corner.
        min: [Expr; 3],
        /// Largest corner.
        max: [Expr; 3],
    },
    /// Ball.
    Ball {
        /// Centre.
        center: [Expr; 3],
        /// Radius.
        radius: Expr,
    },
    /// Regular prism (nuts, hex bores) along `axis`, `sides` corners, across-flats `width`.
    Prism {
        /// Centre of the base.
        base: [Expr; 3],
        /// Constant direction.
        axis: [f64; 3],
        /// Length along the axis.
        length: Expr,
        /// Across flats.
        width: Expr,
        /// Number of sides.
        sides: u32,
    },
}

impl Feature {
    /// A feature that adds `shape`.
    pub fn add(name: &str, shape: Shape) -> Feature {
        Feature {
            name: name.into(),
            operation: Operation::Add,
            shape,
        }
    }

    /// A feature that cuts `shape` away.
    pub fn cut(name: &str, shape: Shape) -> Feature {
        Feature {
            name: name.into(),
            operation: Operation::Cut,
            shape,
        }
    }
}

impl Shape {
    /// Cylinder along z from height `bottom` to height `top`.
    pub fn upright(x: &str, y: &str, (bottom, top): (&str, &str), radius: &str) -> Shape {
        Shape::Cone {
            base: [x.into(), y.into(), bottom.into()],
            axis: [0.0, 0.0, 1.0],
            length: format!("{top} - ({bottom})"),
            r0: radius.into(),
            r1: radius.into(),
        }
    }

    /// Cylinder of `length` from `base` along +x.
    pub fn along_x(base: [&str; 3], length: &str, radius: &str) -> Shape {
        Shape::Cone {
            base: base.map(String::from),
            axis: [1.0, 0.0, 0.0],
            length: length.into(),
            r0: radius.into(),
            r1: radius.into(),
        }
    }

    /// Axis-parallel box from its ranges in x, y and z.
    pub fn block(x: (&str, &str), y: (&str, &str), z: (&str, &str)) -> Shape {
        Shape::Block {
            min: [x.0.into(), y.0.into(), z.0.into()],
            max: [x.1.into(), y.1.into(), z.1.into()],
        }
    }
}
