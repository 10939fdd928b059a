//! Stiffness and root stress of single teeth under a force at the contact.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::Hub;
use super::elastic_body::{ElasticBody, Forces};
use super::elements::Elasticity;
use super::tooth_grid::{Tooth, ToothGrid};
use crate::design::{Design, Gear};
use crate::load::Material;

/// Places along a tooth at which it is loaded, both ends included.
pub const PLACES: usize = 9;

/// How finely [`Teeth`] are cut: stiffness is within 5 % of that of grids three times as fine, stress within
/// 15 %, mostly above it.
pub const FINENESS: usize = 1;

/// What a force of 1 N along the contact normal does at one place of a tooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Deflection along the normal, mm/N.
    pub compliance: f64,
    /// Largest stress at the root or where the rib ends under the bead, MPa/N: the equivalent stress (von
    /// Mises), or tension across the layers of a print divided by the share of strength that is left there.
    pub stress: f64,
}

/// How one tooth gives.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothStrength {
    /// Responses at evenly spaced places of the contact interval, from its start to its end.
    pub responses: Vec<Response>,
}

impl ToothStrength {
    /// Of a tooth made of `material`, whose elements are cut as [`ToothGrid::new`] does; `None` where it
    /// cannot be cut into elements.
    pub fn of(tooth: &Tooth, material: Material, fineness: usize) -> Option<ToothStrength> {
        let cut = ToothGrid::new(tooth, fineness)?;
        let elasticity = Elasticity::new(material.young_modulus(), material.poisson_ratio());
        let body = ElasticBody::new(&cut.grid, elasticity)?;
        let cases: Vec<Forces> = places().map(|share| forces(tooth, &cut, share)).collect();
        let moved = body.solve(&cases)?;
        // Gears are printed with their axis upright.
        let across = material.strength_across_layers();
        let response = |(forces, moved): (&Forces, &Vec<Vector3<f64>>)| {
            let spots = cut.hottest(|element| body.stresses(element, moved));
            let stresses = spots.map(|spot| equivalent(&spot).max(spot.m33 / across));
            Response {
                compliance: forces.iter().map(|(node, f)| f.dot(&moved[*node])).sum(),
                stress: stresses.fold(0.0, f64::max),
            }
        };
        Some(ToothStrength {
            responses: cases.iter().zip(&moved).map(response).collect(),
        })
    }

    /// Response at a share of the contact interval, linear between the places.
    pub fn at(&self, share: f64) -> Response {
        let last = self.responses.len() - 1;
        let x = share.clamp(0.0, 1.0) * last as f64;
        let i = (x as usize).min(last - 1);
        let (part, [a, b]) = (x - i as f64, [self.responses[i], self.responses[i + 1]]);
        Response {
            compliance: a.compliance + part * (b.compliance - a.compliance),
            stress: a.stress + part * (b.stress - a.stress),
        }
    }
}

/// Shares of the contact interval at which teeth are loaded.
pub fn places() -> impl Iterator<Item = f64> {
    (0..PLACES).map(|i| i as f64 / (PLACES - 1) as f64)
}

/// Nodal forces of 1 N along the contact normal at a share of the contact interval.
pub fn forces(tooth: &Tooth, cut: &ToothGrid, share: f64) -> Forces {
    let normal = tooth.frame(share).n;
    let weights = cut.section_weights(share).into_iter();
    weights
        .map(|(node, weight)| (node, weight * normal))
        .collect()
}

/// Equivalent stress after von Mises.
pub fn equivalent(stress: &Matrix3<f64>) -> f64 {
    let deviator = stress - Matrix3::from_diagonal_element(stress.trace() / 3.0);
    (1.5 * deviator.norm_squared()).sqrt()
}

/// All teeth of a design.
#[derive(Debug, Clone)]
pub struct Teeth {
    /// Per sub-gear pair and tooth: of the driver and of the follower.
    pairs: Vec<Vec<[ToothStrength; 2]>>,
}

impl Teeth {
    /// Teeth of `design` made of the `materials` of driver and follower; `None` where one of them cannot be
    /// cut into elements.
    pub fn of(design: &Design, materials: [Material; 2]) -> Option<Teeth> {
        let gears = [Gear::Driver, Gear::Follower];
        let hubs = gears.map(|gear| Hub::of(design, gear));
        let pairs = design.sub_gear_pairs.par_iter().map(|pair| {
            let section = design.section_of(pair);
            let teeth = pair.teeth.par_iter().map(|tooth| {
                let one = |i: usize| {
                    let tooth = Tooth::new(tooth, gears[i], section, hubs[i])?;
                    ToothStrength::of(&tooth, materials[i], FINENESS)
                };
                Some([one(0)?, one(1)?])
            });
            teeth.collect::<Option<Vec<_>>>()
        });
        Some(Teeth {
            pairs: pairs.collect::<Option<_>>()?,
        })
    }

    /// Least stiffness of a tooth anywhere along its contact interval, N/mm, and which tooth that is.
    pub fn softest(&self) -> Option<(f64, Gear, [usize; 2])> {
        let pairs = self.pairs.iter().enumerate();
        let teeth =
            pairs.flat_map(|(k, pair)| pair.iter().enumerate().map(move |(j, t)| (k, j, t)));
        let gears = [Gear::Driver, Gear::Follower];
        let all = teeth.flat_map(|(k, j, both)| {
            gears.into_iter().zip(both).flat_map(move |(gear, tooth)| {
                let stiffness = tooth.responses.iter().map(|r| 1.0 / r.compliance);
                stiffness.map(move |stiffness| (stiffness, gear, [k, j]))
            })
        });
        all.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The driver's and the follower's tooth of a pair.
    pub fn tooth(&self, pair: usize, tooth: usize) -> &[ToothStrength; 2] {
        &self.pairs[pair][tooth]
    }
}
