//! The four classes of follower-support joint and the motion space each leaves free.

use nalgebra::{DVector, Vector3};
use serde::{Deserialize, Serialize};

/// Class of the mechanism: degrees of freedom (N_R rotations, N_T translations) of the joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Class {
    /// Revolute about z, N = 1.
    #[serde(rename = "1R")]
    R1,
    /// Cylindrical about z, N = 2.
    #[serde(rename = "1R1T")]
    R1T1,
    /// Spherical at O, N = 3.
    #[serde(rename = "3R")]
    R3,
    /// Spherical, centre sliding along z, N = 4.
    #[serde(rename = "3R1T")]
    R3T1,
}

impl Class {
    /// All classes, in order of N.
    pub const ALL: [Class; 4] = [Class::R1, Class::R1T1, Class::R3, Class::R3T1];

    /// Number of degrees of freedom N; K ≥ N+1 contacts are necessary (Eq. 2).
    pub fn dof(self) -> usize {
        match self {
            Class::R1 => 1,
            Class::R1T1 => 2,
            Class::R3 => 3,
            Class::R3T1 => 4,
        }
    }

    /// Whether the joint turns about every axis (ball) or about z only (pin).
    pub fn is_spherical(self) -> bool {
        matches!(self, Class::R3 | Class::R3T1)
    }

    /// Whether the joint slides along z.
    pub fn slides(self) -> bool {
        matches!(self, Class::R1T1 | Class::R3T1)
    }

    /// Projection n̄ of the generalised normal onto span(U) ≅ R^N (order: linear, angular);
    /// `p` is the contact point, `n` the unit contact normal into the follower, `centre` the
    /// present joint centre, all in Σ (mm).
    pub fn project(self, p: Vector3<f64>, n: Vector3<f64>, centre: Vector3<f64>) -> DVector<f64> {
        let m = (p - centre).cross(&n);
        match self {
            Class::R1 => DVector::from_vec(vec![m.z]),
            Class::R1T1 => DVector::from_vec(vec![n.z, m.z]),
            Class::R3 => DVector::from_vec(vec![m.x, m.y, m.z]),
            Class::R3T1 => DVector::from_vec(vec![n.z, m.x, m.y, m.z]),
        }
    }
}

impl std::fmt::Display for Class {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Class::R1 => "1R",
            Class::R1T1 => "1R1T",
            Class::R3 => "3R",
            Class::R3T1 => "3R1T",
        })
    }
}
