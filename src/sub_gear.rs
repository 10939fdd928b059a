//! One sub-gear pair: the J tooth pairs of one contact, and what makes them fabricable by themselves.

use nalgebra::Vector3;

use crate::contact::{Grid, ToothLaw, Trace, trace};
use crate::design::Gear;

/// Design variables of a band: one tooth law, and how four of its numbers vary from tooth to tooth
/// with the first two harmonics of the driver angle at mid contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandLaw {
    /// Mean law of the band.
    pub tooth: ToothLaw,
    /// Amplitudes (cos φ, sin φ, cos 2φ, sin 2φ) added to α, β (rad), offset and z (mm).
    pub waves: [[f64; 4]; 4],
}

impl BandLaw {
    /// Law of the tooth whose contact interval is centred at driver angle `phi`.
    pub fn at(&self, phi: f64) -> ToothLaw {
        let basis = [phi.cos(), phi.sin(), (2.0 * phi).cos(), (2.0 * phi).sin()];
        let wave = |w: &[f64; 4]| w.iter().zip(basis).map(|(a, b)| a * b).sum::<f64>();
        let mut law = self.tooth;
        law.alpha += wave(&self.waves[0]);
        law.beta += wave(&self.waves[1]);
        law.offset += wave(&self.waves[2]);
        law.z += wave(&self.waves[3]);
        law
    }

    /// All design variables in a row, as stored in `design.json`.
    pub fn to_parameters(self) -> Vec<f64> {
        let t = self.tooth;
        let mut row =
            vec![t.alpha, t.beta, t.alpha_change, t.beta_change, t.side, t.z, t.travel, t.offset];
        row.extend(self.waves.iter().flatten());
        row
    }
}

/// Contacts of all J teeth.
#[derive(Debug, Clone)]
pub struct Band {
    /// What it was traced from.
    pub law: BandLaw,
    /// Contacts of tooth j from start to end of its interval.
    pub teeth: Vec<Trace>,
}

/// Why a band is no good by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Flaw {
    /// The construction degenerates or leaves the gear.
    Degenerate,
    /// Teeth cross beside the contact: second-order gap below the margin.
    Gap,
    /// A tangent (nearly) vanishes: undercut.
    Cusp,
    /// The sweep folds over itself.
    Fold,
    /// Neighbouring teeth of one gear are closer than thickness plus gap.
    Spacing,
    /// The other gear's hub is in the way.
    Hub,
    /// Socket or arm is in the way.
    Joint,
    /// Driver and follower teeth of the band collide away from their contact.
    Teeth,
}

/// Margins of a fabricable band, mm and mm/rad.
#[derive(Debug, Clone, Copy)]
pub struct Margins {
    /// Least second-order gap g, mm/rad².
    pub gap: f64,
    /// Least |T¹|, |T²|, mm/rad.
    pub tangent: f64,
    /// Least distance between bead axes of neighbouring teeth.
    pub spacing: f64,
    /// Radius of the swept bead.
    pub bead_radius: f64,
}

impl Band {
    /// Traces all teeth of `law`.
    ///
    /// # Errors
    /// [`Flaw::Degenerate`] when a tooth cannot be traced.
    pub fn trace(grid: &Grid, law: BandLaw) -> Result<Band, Flaw> {
        let teeth = (0..grid.teeth.len())
            .map(|j| {
                let middle = grid.teeth[j][grid.steps].phi;
                trace(grid, j, &law.at(middle)).ok_or(Flaw::Degenerate)
            })
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Band { law, teeth })
    }

    /// Checks what every tooth must satisfy by itself: gap, cusp, fold.
    ///
    /// # Errors
    /// The first flaw found.
    pub fn check_teeth(&self, grid: &Grid, margins: &Margins) -> Result<(), Flaw> {
        for (j, tooth) in self.teeth.iter().enumerate() {
            for c in tooth {
                let finite = c.gap.is_finite() && c.p.iter().all(|x| x.is_finite());
                if !finite {
                    return Err(Flaw::Degenerate);
                }
                if c.gap < margins.gap {
                    return Err(Flaw::Gap);
                }
                if c.t1.norm() < margins.tangent || c.t2.norm() < margins.tangent {
                    return Err(Flaw::Cusp);
                }
            }
            for gear in [Gear::Driver, Gear::Follower] {
                if folds(grid, j, tooth, gear, margins.bead_radius) {
                    return Err(Flaw::Fold);
                }
            }
        }
        Ok(())
    }

    /// Axis of the bead of tooth `j` in the frame of `gear`: the contact curve moved by the bead
    /// radius into the material; every `stride`-th contact.
    pub fn bead_axis(&self, grid: &Grid, j: usize, gear: Gear, bead_radius: f64, stride: usize) -> Vec<Vector3<f64>> {
        self.teeth[j]
            .iter()
            .enumerate()
            .step_by(stride)
            .map(|(i, c)| {
                let (p, n, _) = in_body(grid, j, i, c, gear);
                p + bead_radius * n
            })
            .collect()
    }
}

/// Contact point, normal into the material and tangent of station `i` of tooth `j` in the frame of
/// `gear`.
pub fn in_body(
    grid: &Grid,
    j: usize,
    i: usize,
    c: &crate::contact::Contact,
    gear: Gear,
) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let node = &grid.teeth[j][2 * i];
    match gear {
        Gear::Driver => {
            let rt = node.driver.pose.rotation.transpose();
            (node.driver.pose.inverse_apply(c.p), -(rt * c.n), rt * c.t1)
        }
        Gear::Follower => {
            let rt = node.follower.pose.rotation.transpose();
            (node.follower.pose.inverse_apply(c.p), rt * c.n, rt * c.t2)
        }
    }
}

/// Whether a bead of the given radius folds when swept along the tooth: some extreme point of the
/// cross section fails to advance by a quarter of what the contact point advances.
fn folds(grid: &Grid, j: usize, tooth: &Trace, gear: Gear, radius: f64) -> bool {
    let section = |i: usize| {
        let (p, n, t) = in_body(grid, j, i, &tooth[i], gear);
        let t = t.normalize();
        let b = t.cross(&n);
        let c = p + radius * n;
        (t, [p, c + radius * n, c + radius * b, c - radius * b])
    };
    let mut before = section(0);
    for i in 1..tooth.len() {
        let here = section(i);
        let t = before.0 + here.0;
        let advance = (here.1[0] - before.1[0]).dot(&t);
        let folded = (0..4).any(|k| !((here.1[k] - before.1[k]).dot(&t) > 0.25 * advance)) || !(advance > 0.0);
        if folded {
            return true;
        }
        before = here;
    }
    false
}
