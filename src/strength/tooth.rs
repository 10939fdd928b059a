//! Stiffness and root stress of single teeth under a force at the contact.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::Hub;
use super::elastic_body::{ElasticBody, Forces};
use super::elements::{self, Elasticity};
use super::tooth_grid::{Place, Tooth, ToothGrid};
use crate::design::{Design, Gear};
use crate::load::Material;

/// Places along a tooth at which it is loaded, both ends included.
pub const PLACES: usize = 9;

/// Most of two grids' elements along each direction of one: what [`Teeth`] are cut into.
const FINENESS: usize = 1;

/// What a force of 1 N along the contact normal does at one place of a tooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Deflection along the normal, mm/N.
    pub compliance: f64,
    /// Largest equivalent stress (von Mises) at the root or where the rib ends under the bead, MPa/N.
    pub stress: f64,
    /// Largest tension there along the gear's axis, across the layers of a print, MPa/N.
    pub tension_across_layers: f64,
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
        let hot_spots = [cut.over_the_root(), cut.beside_the_rib()].concat();
        let mut used: Vec<usize> = hot_spots.iter().flatten().flatten().map(|p| p.0).collect();
        used.sort_unstable();
        used.dedup();
        let response = |(forces, moved): (&Forces, &Vec<_>)| {
            let stresses: Vec<_> = used.iter().map(|&e| body.stresses(e, moved)).collect();
            let at = |(element, x): &Place| {
                let i = used.partition_point(|e| e < element);
                elements::between_points(&stresses[i], *x)
            };
            let mean = |places: &Vec<Place>| -> Matrix3<f64> {
                places.iter().map(at).sum::<Matrix3<f64>>() / places.len() as f64
            };
            let spots = hot_spots.iter().map(|[near, far]| extrapolated(mean(near), mean(far)));
            let (stress, tension) = spots.fold((0.0, 0.0), |(stress, tension), spot| {
                (f64::max(stress, equivalent(&spot)), f64::max(tension, spot.m33))
            });
            Response {
                compliance: forces.iter().map(|(node, f)| f.dot(&moved[*node])).sum(),
                stress,
                tension_across_layers: tension,
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
        let blend = |a: f64, b: f64| a + part * (b - a);
        Response {
            compliance: blend(a.compliance, b.compliance),
            stress: blend(a.stress, b.stress),
            tension_across_layers: blend(a.tension_across_layers, b.tension_across_layers),
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
    weights.map(|(node, weight)| (node, weight * normal)).collect()
}

/// Stress at a root from those half a step and one and a half steps away: linear, as the surface stress of
/// bending is, and without the singularity of the corner (hot-spot stress after Hobbacher, IIW-2259-15).
pub fn extrapolated(near: Matrix3<f64>, far: Matrix3<f64>) -> Matrix3<f64> {
    1.5 * near - 0.5 * far
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

    /// The driver's and the follower's tooth of a pair.
    pub fn tooth(&self, pair: usize, tooth: usize) -> &[ToothStrength; 2] {
        &self.pairs[pair][tooth]
    }
}
