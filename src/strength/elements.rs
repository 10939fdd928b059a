//! Hexahedra with 20 nodes for small elastic deformations.
//!
//! Quadratic serendipity shape functions, integrated at 2 × 2 × 2 points: bends without locking
//! (Zienkiewicz & Taylor, "The Finite Element Method", vol. 1, ch. 8; CalculiX calls it C3D20R).

use std::sync::LazyLock;

use nalgebra::{Matrix3, Vector3};

/// Nodes of an element.
pub const NODES: usize = 20;

/// Integration points of an element.
pub const POINTS: usize = 8;

/// Places of the nodes on the reference cube [−1, 1]³: the eight corners, then the middles of the edges.
pub const PLACES: [[i8; 3]; NODES] = [
    [-1, -1, -1],
    [1, -1, -1],
    [1, 1, -1],
    [-1, 1, -1],
    [-1, -1, 1],
    [1, -1, 1],
    [1, 1, 1],
    [-1, 1, 1],
    [0, -1, -1],
    [1, 0, -1],
    [0, 1, -1],
    [-1, 0, -1],
    [0, -1, 1],
    [1, 0, 1],
    [0, 1, 1],
    [-1, 0, 1],
    [-1, -1, 0],
    [1, -1, 0],
    [1, 1, 0],
    [-1, 1, 0],
];

/// Isotropic linear elasticity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elasticity {
    /// Lamé's first constant λ, MPa.
    pub lambda: f64,
    /// Shear modulus μ, MPa.
    pub mu: f64,
}

impl Elasticity {
    /// Of Young's modulus (MPa) and Poisson's ratio.
    pub fn new(young_modulus: f64, poisson_ratio: f64) -> Elasticity {
        let mu = young_modulus / (2.0 * (1.0 + poisson_ratio));
        Elasticity {
            lambda: 2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio),
            mu,
        }
    }
}

/// Values of the shape functions at `x` on the reference cube.
pub fn shape(x: [f64; 3]) -> [f64; NODES] {
    PLACES.map(|place| {
        let at = place.map(f64::from);
        let factor = |i: usize| match place[i] {
            0 => 1.0 - x[i] * x[i],
            _ => 1.0 + at[i] * x[i],
        };
        let product = factor(0) * factor(1) * factor(2);
        match place.contains(&0) {
            true => 0.25 * product,
            false => 0.125 * product * (at[0] * x[0] + at[1] * x[1] + at[2] * x[2] - 2.0),
        }
    })
}

/// Their derivatives at `x` along the axes of the reference cube.
pub fn slopes(x: [f64; 3]) -> [Vector3<f64>; NODES] {
    PLACES.map(|place| {
        let at = place.map(f64::from);
        let factor = |i: usize| match place[i] {
            0 => [1.0 - x[i] * x[i], -2.0 * x[i]],
            _ => [1.0 + at[i] * x[i], at[i]],
        };
        let f = [factor(0), factor(1), factor(2)];
        let sum = at[0] * x[0] + at[1] * x[1] + at[2] * x[2] - 2.0;
        Vector3::from_fn(|i, _| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let others = f[j][0] * f[k][0];
            match place.contains(&0) {
                true => 0.25 * f[i][1] * others,
                false => 0.125 * others * (f[i][1] * sum + f[i][0] * at[i]),
            }
        })
    })
}

/// Integration points on the reference cube, the first coordinate fastest; each has the weight 1.
pub fn points() -> [[f64; 3]; POINTS] {
    let at = 1.0 / 3.0_f64.sqrt();
    std::array::from_fn(|i| [i & 1, i >> 1 & 1, i >> 2].map(|side| at * (2.0 * side as f64 - 1.0)))
}

static SLOPES: LazyLock<[[Vector3<f64>; NODES]; POINTS]> = LazyLock::new(|| points().map(slopes));

/// Derivatives of the shape functions along x, y, z at the integration points, 1/mm, with the volume that each
/// point stands for, mm³; `None` where the element is turned inside out.
pub fn gradients(
    corners: &[Vector3<f64>; NODES],
) -> Option<[([Vector3<f64>; NODES], f64); POINTS]> {
    let mut all = [([Vector3::zeros(); NODES], 0.0); POINTS];
    for (point, slopes) in all.iter_mut().zip(SLOPES.iter()) {
        // Rows of the Jacobian: x, y, z along each reference axis.
        let jacobian: Matrix3<f64> = slopes
            .iter()
            .zip(corners)
            .map(|(slope, x)| slope * x.transpose())
            .sum();
        let volume = jacobian.determinant();
        if !(volume > 0.0) {
            return None;
        }
        let inverse = jacobian.try_inverse()?;
        *point = (slopes.map(|slope| inverse * slope), volume);
    }
    Some(all)
}

/// Stiffness between nodes a and b, N/mm, of the element with such [`gradients`]: handed to `add` for a ≤ b.
pub fn stiffness(
    gradients: &[([Vector3<f64>; NODES], f64); POINTS],
    material: Elasticity,
    mut add: impl FnMut(usize, usize, Matrix3<f64>),
) {
    for a in 0..NODES {
        for b in a..NODES {
            let mut sum = Matrix3::zeros();
            for (slopes, volume) in gradients {
                sum += (*volume * slopes[a]) * slopes[b].transpose();
            }
            let shear = material.mu * sum.trace();
            let pair = material.lambda * sum + material.mu * sum.transpose();
            add(a, b, pair + Matrix3::from_diagonal_element(shear));
        }
    }
}

/// Stress, MPa, where the shape functions have the derivatives `slopes` and the nodes move by `moved`, mm.
pub fn stress(
    slopes: &[Vector3<f64>; NODES],
    moved: &[Vector3<f64>; NODES],
    material: Elasticity,
) -> Matrix3<f64> {
    let change: Matrix3<f64> = moved
        .iter()
        .zip(slopes)
        .map(|(u, slope)| u * slope.transpose())
        .sum();
    material.mu * (change + change.transpose())
        + Matrix3::from_diagonal_element(material.lambda * change.trace())
}

/// Stress at `x` on the reference cube, trilinear through those at the integration points.
pub fn between_points(stresses: &[Matrix3<f64>; POINTS], x: [f64; 3]) -> Matrix3<f64> {
    let ends = points();
    let weight = |point: &[f64; 3]| -> f64 {
        point
            .iter()
            .zip(x)
            .map(|(p, x)| 0.5 * (1.0 + x / p))
            .product()
    };
    stresses
        .iter()
        .zip(&ends)
        .map(|(stress, point)| weight(point) * stress)
        .sum()
}
