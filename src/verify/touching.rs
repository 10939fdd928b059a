//! Do the meshes carry the contacts of the design: at every station of every tooth pair both flanks
//! must be there, half the clearance behind the contact point. From this follow the tooth pairs that
//! really touch at each φ, and the contact ratio as built.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::claim::{Bound, Claim, tooth_place};
use super::overlap::Part;
use crate::design::{Design, Gear};

/// Stations of a tooth that are looked at.
const STATIONS: usize = 9;

/// Largest deviation of a flank from its place, mm: facets of swept teeth stay far below, and so
/// does the precision of an STL file.
const DEVIATION: f64 = 0.02;

/// A station of a tooth pair and how far each gear's flank is behind the contact point.
struct Flank {
    phi: f64,
    k: usize,
    j: usize,
    gear: Gear,
    /// Distance along the normal into the material; NaN where no surface is near.
    behind: f64,
}

/// Claims about the contacts as the meshes have them.
pub(super) fn claims(design: &Design, (driver, follower): (&Part, &Part)) -> Vec<Claim> {
    let wanted = 0.5 * design.section.clearance;
    let teeth: Vec<(usize, usize)> = design
        .sub_gear_pairs
        .iter()
        .enumerate()
        .flat_map(|(k, pair)| (0..pair.teeth.len()).map(move |j| (k, j)))
        .collect();
    let flanks: Vec<Flank> = teeth
        .par_iter()
        .flat_map_iter(|&(k, j)| {
            let stations = &design.sub_gear_pairs[k].teeth[j].stations;
            let last = stations.len().saturating_sub(1);
            (0..STATIONS.min(stations.len())).flat_map(move |i| {
                let s = &stations[i * last / (STATIONS - 1)];
                [(Gear::Driver, driver), (Gear::Follower, follower)].map(|(gear, part)| {
                    let (p, n, _) = s.frame(gear);
                    Flank {
                        phi: s.phi,
                        k,
                        j,
                        gear,
                        behind: behind(part, p, n),
                    }
                })
            })
        })
        .collect();
    let meaning = "every tooth is where the design puts it, along its whole contact";
    if flanks.is_empty() {
        return vec![
            Claim::new("flanks in place", meaning).undecided("the design has no contact stations"),
        ];
    }
    let deviation = |f: &Flank| match (f.behind - wanted).abs() {
        d if d.is_finite() => d,
        _ => f64::INFINITY,
    };
    let mut claims = Vec::new();
    for gear in [Gear::Driver, Gear::Follower] {
        let worst = flanks
            .iter()
            .filter(|f| f.gear == gear)
            .max_by(|a, b| deviation(a).total_cmp(&deviation(b)));
        let Some(worst) = worst else { continue };
        let name = format!(
            "flanks of the {} in place",
            format!("{gear:?}").to_lowercase()
        );
        claims.push(
            Claim::new(name, meaning)
                .decide(deviation(worst), "mm", Bound::AtMost(DEVIATION))
                .at(tooth_place(worst.phi, worst.k, worst.j)),
        );
    }
    claims.push(hand_over(design, &flanks, deviation));
    claims
}

/// Contact ratio as built: every tooth must still be there where the next one takes over.
fn hand_over(design: &Design, flanks: &[Flank], deviation: impl Fn(&Flank) -> f64) -> Claim {
    let claim = Claim::new(
        "hand-over",
        "each tooth takes over before the one before it lets go",
    );
    let mut worst: Option<(f64, String)> = None;
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        let pitch = std::f64::consts::TAU / pair.teeth.len() as f64;
        for (j, tooth) in pair.teeth.iter().enumerate() {
            let good: Vec<f64> = flanks
                .chunks(2)
                .filter(|pair| (pair[0].k, pair[0].j) == (k, j))
                .filter(|pair| pair.iter().all(|f| deviation(f) <= DEVIATION))
                .map(|pair| pair[0].phi)
                .collect();
            let span = match (good.first(), good.last()) {
                (Some(a), Some(b)) => b - a,
                _ => 0.0,
            };
            let ratio = span / pitch;
            if worst
                .as_ref()
                .is_none_or(|(w, _)| ratio.is_nan() || ratio < *w)
            {
                worst = Some((ratio, tooth_place(tooth.phi_start, k, j)));
            }
        }
    }
    match worst {
        Some((ratio, place)) => claim
            .decide(ratio, "contact ratio", Bound::AtLeast(1.0))
            .at(place),
        None => claim.undecided("the design has no teeth"),
    }
}

/// How far the surface of `part` is from `p` along `n`, both in the body's frame.
fn behind(part: &Part, p: Vector3<f64>, n: Vector3<f64>) -> f64 {
    part.tree.nearest(p, 2.0).map_or(f64::NAN, |(near, _)| {
        let offset = near.q - p;
        // Off to the side is not behind: the flank has to be met along the normal.
        offset.norm() * offset.dot(&n).signum()
    })
}
