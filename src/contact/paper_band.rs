//! The published sub-gear pair (Eq. 10): J tooth pairs with band energies and constraints.
//!
//! Minimise Σ_j E_j + E_circ + E_para subject to C_spac ≤ 0 and C_widt ≤ 0. The expressions are ours
//! (theirs are in a supplement that we do not have), dimensionless throughout; gradients are analytic.

use nalgebra::Vector3;

use super::paper::{Adjoint, Sample, ToothModel};
use super::plane::Plane;
use super::spline::greville;
use super::{Grid, Trace};
use crate::design::Gear;
use crate::settings::Settings;

/// Where a band starts from: every locus is the same segment parallel to z, θ = 0. Lengths in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandStart {
    /// Turning side: +1 or −1, the sign of n_y at θ = 0.
    pub side: f64,
    /// z of the locus at the start of the contact interval.
    pub z_start: f64,
    /// Axial travel of the locus over the interval, signed.
    pub travel: f64,
    /// Offset of the segment along x from the pitch line x = −L/2.
    pub offset: f64,
}

/// Terms of the band's objective: their values, or their weights.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energies {
    /// n ⟂ T¹, summed over the teeth.
    pub norm: f64,
    /// Collinear tangents, summed over the teeth.
    pub tang: f64,
    /// Plane curves, summed over the teeth.
    pub plan: f64,
    /// Start points and end points on circles about the hub axes.
    pub circ: f64,
    /// Planes of start and end points parallel.
    pub para: f64,
}

impl Energies {
    fn sum(&self) -> f64 {
        self.norm + self.tang + self.plan + self.circ + self.para
    }
}

/// Start or end of a contact interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Start,
    Finish,
}

const GEARS: [Gear; 2] = [Gear::Driver, Gear::Follower];

/// Band as a program in J·(3l + ρ) variables.
#[derive(Debug, Clone)]
pub struct BandModel {
    /// Weights of the energies; zero leaves a term out.
    pub weights: Energies,
    teeth: Vec<ToothModel>,
    side: f64,
    center_distance: f64,
    /// Least distance between bead axes of neighbouring teeth, mm.
    spacing: f64,
    /// Bead axis lies this far behind the contact point, mm.
    bead_radius: f64,
    /// Least axial distance between start and end points, mm, and its direction.
    width: f64,
    direction: f64,
}

/// What the samples of all teeth say, and what the objective says back.
type Samples = Vec<Vec<Sample>>;
type Adjoints = Vec<Vec<Adjoint>>;

impl BandModel {
    /// Model over every `stride`-th node of `grid`.
    pub fn new(grid: &Grid, settings: &Settings, start: &BandStart, stride: usize) -> BandModel {
        let gear = &settings.gear;
        let control = (gear.locus_control_points, gear.normal_control_points);
        let unit = UNIT * grid.drive.center_distance();
        let teeth = grid
            .teeth
            .iter()
            .map(|nodes| {
                let nodes = nodes.iter().step_by(stride).copied();
                ToothModel::new(nodes, start.side.signum(), unit, control)
            })
            .collect();
        BandModel {
            weights: Energies {
                norm: gear.norm_weight,
                tang: 1.0,
                plan: 1.0,
                circ: 1.0,
                para: 1.0,
            },
            teeth,
            side: start.side.signum(),
            center_distance: grid.drive.center_distance(),
            spacing: gear.tooth_thickness_mm
                + settings.fit.safety_gap_mm
                + SPACING_MARGIN * grid.drive.center_distance(),
            bead_radius: 0.5 * gear.tooth_thickness_mm,
            width: WIDTH_SHARE * start.travel.abs(),
            direction: start.travel.signum(),
        }
    }

    /// Number of variables.
    pub fn variables(&self) -> usize {
        self.teeth.iter().map(ToothModel::variables).sum()
    }

    /// Number of constraints: C_spac for each gear and tooth, C_widt for each gear.
    pub fn constraints(&self) -> usize {
        2 * self.teeth.len() + 2
    }

    /// Variables of `start` with their lower and upper bounds: the locus stays within a box around
    /// its segment, θ within half a turn.
    pub fn start(&self, settings: &Settings, start: &BandStart) -> [Vec<f64>; 3] {
        let length = self.center_distance;
        let unit = UNIT * length;
        let locus = greville(settings.gear.locus_control_points);
        let reach = REACH * length;
        let (z0, z1) = (start.z_start, start.z_start + start.travel);
        let box_low = Vector3::new(
            -0.5 * length - reach,
            -reach,
            z0.min(z1) - AXIAL_SLACK * length,
        );
        let box_high = Vector3::new(
            -0.5 * length + reach,
            reach,
            z0.max(z1) + AXIAL_SLACK * length,
        );
        let [mut x, mut lower, mut upper] = [const { Vec::new() }; 3];
        for _ in &self.teeth {
            for u in &locus {
                let p = Vector3::new(start.offset - 0.5 * length, 0.0, z0 + u * start.travel);
                x.extend((p / unit).iter());
                lower.extend((box_low / unit).iter());
                upper.extend((box_high / unit).iter());
            }
            let angles = settings.gear.normal_control_points;
            x.resize(x.len() + angles, 0.0);
            lower.resize(lower.len() + angles, f64::NEG_INFINITY);
            upper.resize(upper.len() + angles, f64::INFINITY);
        }
        [x, lower, upper]
    }

    /// Variables of each tooth.
    fn split<'a>(&self, x: &'a [f64]) -> impl Iterator<Item = &'a [f64]> {
        let each = self.teeth.first().map_or(1, ToothModel::variables).max(1);
        x.chunks_exact(each)
    }

    /// Samples of all teeth at the variables `x`.
    fn samples(&self, x: &[f64]) -> Samples {
        self.teeth
            .iter()
            .zip(self.split(x))
            .map(|(t, x)| t.samples(x))
            .collect()
    }

    /// Weighted energies at `x`; their gradient is written to `gradient`.
    pub fn energies(&self, x: &[f64], gradient: &mut [f64]) -> Energies {
        let samples = self.samples(x);
        let mut adjoints = self.no_adjoints();
        let w = &self.weights;
        let mut e = Energies::default();
        for ((tooth, s), g) in self.teeth.iter().zip(&samples).zip(&mut adjoints) {
            e.norm += tooth.e_norm(s, w.norm, g);
            e.tang += tooth.e_tang(s, w.tang, g);
            e.plan += tooth.e_plan(s, w.plan, g);
        }
        e.circ = self.e_circ(&samples, w.circ, &mut adjoints);
        e.para = self.e_para(&samples, w.para, &mut adjoints);
        gradient.fill(0.0);
        self.pull_back(&samples, &adjoints, gradient);
        e
    }

    /// Objective of Eq. 10 at `x` and its gradient.
    pub fn objective(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.energies(x, gradient).sum()
    }

    /// Constraints at `x`, satisfied where ≤ 0, and row by row their gradients: C_spac of the
    /// driver's teeth, of the follower's, C_widt of driver and follower.
    pub fn constrain(&self, x: &[f64], values: &mut [f64], jacobian: &mut [f64]) {
        let samples = self.samples(x);
        jacobian.fill(0.0);
        let count = self.teeth.len();
        let mut rows = values
            .iter_mut()
            .zip(jacobian.chunks_exact_mut(x.len().max(1)));
        for gear in GEARS {
            for (j, (value, row)) in rows.by_ref().take(count).enumerate() {
                *value = self.c_spac(&samples, gear, j, row);
            }
        }
        for (gear, (value, row)) in GEARS.into_iter().zip(rows) {
            *value = self.c_widt(&samples, gear, row);
        }
    }

    fn no_adjoints(&self) -> Adjoints {
        self.teeth
            .iter()
            .map(|t| vec![Adjoint::zero(); t.len()])
            .collect()
    }

    fn pull_back(&self, samples: &Samples, adjoints: &Adjoints, gradient: &mut [f64]) {
        let mut rest = gradient;
        for ((tooth, s), g) in self.teeth.iter().zip(samples).zip(adjoints) {
            let (mine, others) = rest.split_at_mut(tooth.variables());
            tooth.pull_back(s, g, mine);
            rest = others;
        }
    }

    /// Start or end points of all teeth in the frame of `gear`.
    fn ends(&self, samples: &Samples, gear: Gear, end: End) -> Vec<Vector3<f64>> {
        self.teeth
            .iter()
            .zip(samples)
            .map(|(tooth, s)| {
                let i = self.index(tooth, end);
                tooth.state(gear, i).pose.inverse_apply(s[i].p)
            })
            .collect()
    }

    fn index(&self, tooth: &ToothModel, end: End) -> usize {
        match end {
            End::Start => 0,
            End::Finish => tooth.len() - 1,
        }
    }

    /// Adds derivatives by the points of [`Self::ends`] to the adjoints.
    fn push_ends(&self, gear: Gear, end: End, by_points: &[Vector3<f64>], adjoints: &mut Adjoints) {
        for ((tooth, by), g) in self.teeth.iter().zip(by_points).zip(adjoints) {
            let i = self.index(tooth, end);
            g[i].p += tooth.state(gear, i).pose.rotation * by;
        }
    }

    /// E_circ = Σ over gears and ends of (variance of the distance from the hub axis + mean squared
    /// distance from the best plane)/L², times `weight`.
    fn e_circ(&self, samples: &Samples, weight: f64, adjoints: &mut Adjoints) -> f64 {
        let scale = weight / self.center_distance.powi(2);
        let mut sum = 0.0;
        for gear in GEARS {
            let axis = match gear {
                Gear::Driver => Vector3::new(-self.center_distance, 0.0, 0.0),
                Gear::Follower => Vector3::zeros(),
            };
            for end in [End::Start, End::Finish] {
                let points = self.ends(samples, gear, end);
                let count = points.len() as f64;
                let arms: Vec<Vector3<f64>> = points
                    .iter()
                    .map(|p| (p - axis).component_mul(&Vector3::new(1.0, 1.0, 0.0)))
                    .collect();
                let mean = arms.iter().map(|a| a.norm()).sum::<f64>() / count;
                let variance = arms.iter().map(|a| (a.norm() - mean).powi(2)).sum::<f64>() / count;
                let plane = Plane::fit(&points);
                let by: Vec<Vector3<f64>> = points
                    .iter()
                    .zip(&arms)
                    .map(|(p, a)| {
                        let by_radius = 2.0 / count * (1.0 - mean / a.norm()) * a;
                        scale * (by_radius + plane.thickness_by(*p))
                    })
                    .collect();
                self.push_ends(gear, end, &by, adjoints);
                sum += scale * (variance + plane.thickness);
            }
        }
        sum
    }

    /// E_para = Σ over gears of 1 − (m_start·m_end)² = |m_start × m_end|², m the normals of the best
    /// planes, times `weight`.
    fn e_para(&self, samples: &Samples, weight: f64, adjoints: &mut Adjoints) -> f64 {
        let mut sum = 0.0;
        for gear in GEARS {
            let [start, finish] =
                [End::Start, End::Finish].map(|end| self.ends(samples, gear, end));
            let (a, b) = (Plane::fit(&start), Plane::fit(&finish));
            let slope = -2.0 * weight * a.normal.dot(&b.normal);
            let by = |points: &[Vector3<f64>], plane: &Plane, other: &Plane| -> Vec<_> {
                points
                    .iter()
                    .map(|p| plane.normal_by(*p, slope * other.normal))
                    .collect()
            };
            self.push_ends(gear, End::Start, &by(&start, &a, &b), adjoints);
            self.push_ends(gear, End::Finish, &by(&finish, &b, &a), adjoints);
            sum += weight * a.normal.cross(&b.normal).norm_squared();
        }
        sum
    }

    /// C_spac of tooth `j` and its successor on `gear`: (spacing − distance)/L, where the distance is
    /// the smooth minimum −τ ln Σ exp(−d/τ) over the samples of both bead axes. It is below the
    /// distance of the nearest samples by τ times the logarithm of how many are about as near.
    fn c_spac(&self, samples: &Samples, gear: Gear, j: usize, row: &mut [f64]) -> f64 {
        let next = (j + 1) % self.teeth.len();
        let depth = match gear {
            Gear::Driver => -self.bead_radius,
            Gear::Follower => self.bead_radius,
        };
        let axis = |j: usize| -> Vec<(usize, Vector3<f64>)> {
            let tooth = &self.teeth[j];
            (0..tooth.len())
                .step_by(SPACING_STRIDE)
                .map(|i| {
                    let s = &samples[j][i];
                    (
                        i,
                        tooth.state(gear, i).pose.inverse_apply(s.p + depth * s.n),
                    )
                })
                .collect()
        };
        let (here, there) = (axis(j), axis(next));
        let gaps: Vec<Vector3<f64>> = here
            .iter()
            .flat_map(|a| there.iter().map(move |b| b.1 - a.1))
            .collect();
        let nearest = gaps.iter().map(|d| d.norm()).fold(f64::INFINITY, f64::min);
        let tau = SOFTNESS * self.bead_radius;
        let shares: Vec<f64> = gaps
            .iter()
            .map(|d| ((nearest - d.norm()) / tau).exp())
            .collect();
        let total: f64 = shares.iter().sum();

        let mut adjoints = [j, next].map(|j| vec![Adjoint::zero(); self.teeth[j].len()]);
        let pairs = here
            .iter()
            .flat_map(|a| there.iter().map(move |b| (a.0, b.0)));
        for ((i, k), (gap, share)) in pairs.zip(gaps.iter().zip(&shares)) {
            // d(distance)/d(b − a) is share/total along the gap; C = (spacing − distance)/L.
            let by = gap * (share / total / gap.norm() / self.center_distance);
            for (side, (tooth, at, sign)) in [(j, i, 1.0), (next, k, -1.0)].into_iter().enumerate()
            {
                let g = self.teeth[tooth].state(gear, at).pose.rotation * by * sign;
                adjoints[side][at].p += g;
                adjoints[side][at].n += g * depth;
            }
        }
        let each = self.teeth[j].variables();
        for (tooth, adjoint) in [j, next].into_iter().zip(&adjoints) {
            let mine = &mut row[tooth * each..(tooth + 1) * each];
            self.teeth[tooth].pull_back(&samples[tooth], adjoint, mine);
        }
        (self.spacing - (nearest - tau * total.ln())) / self.center_distance
    }

    /// C_widt of `gear`: (width − (centre_end − centre_start)·m)/L, m the normal of the start points'
    /// plane, directed along the travel.
    fn c_widt(&self, samples: &Samples, gear: Gear, row: &mut [f64]) -> f64 {
        let [start, finish] = [End::Start, End::Finish].map(|end| self.ends(samples, gear, end));
        let (a, b) = (Plane::fit(&start), Plane::fit(&finish));
        let sign = (a.normal.z * self.direction).signum();
        let apart = b.centre - a.centre;
        let scale = -sign / self.center_distance;
        let by_centre = a.normal * (scale / start.len() as f64);
        let by_start: Vec<_> = start
            .iter()
            .map(|p| a.normal_by(*p, scale * apart) - by_centre)
            .collect();
        let mut adjoints = self.no_adjoints();
        self.push_ends(gear, End::Start, &by_start, &mut adjoints);
        self.push_ends(
            gear,
            End::Finish,
            &vec![by_centre; finish.len()],
            &mut adjoints,
        );
        self.pull_back(samples, &adjoints, row);
        self.width / self.center_distance + scale * apart.dot(&a.normal)
    }

    /// `x` with every tooth made conjugate that can be: see [`ToothModel::finish`].
    pub fn finish(&self, x: &[f64], tolerance: f64) -> Vec<f64> {
        let teeth = self.teeth.iter().zip(self.split(x));
        teeth
            .flat_map(|(tooth, x)| tooth.finish(x, tolerance).unwrap_or_else(|| x.to_vec()))
            .collect()
    }

    /// The band at the variables `x`.
    pub fn band(&self, x: &[f64]) -> PaperBand {
        let teeth: Vec<PaperTooth> = self
            .teeth
            .iter()
            .zip(self.split(x))
            .map(|(tooth, x)| PaperTooth {
                control_points: tooth.control_points(x),
                angles: tooth.angles(x).to_vec(),
                trace: tooth.contacts(x),
            })
            .collect();
        let worst = |f: fn(&super::Contact) -> f64| {
            // NaN is the worst of all, and f64::max would drop it.
            teeth
                .iter()
                .flat_map(|t| &t.trace)
                .map(f)
                .fold(0.0, |a: f64, b| {
                    if a.is_nan() || b.is_nan() {
                        f64::NAN
                    } else {
                        a.max(b)
                    }
                })
        };
        PaperBand {
            side: self.side,
            residual_rolling: worst(|c| c.n.dot(&(c.t1 - c.t2)).abs()),
            residual_tangent: worst(|c| c.n.dot(&c.t2).abs()),
            energies: self.energies(x, &mut vec![0.0; x.len()]),
            teeth,
        }
    }
}

/// One tooth pair of a solved band.
#[derive(Debug, Clone)]
pub struct PaperTooth {
    /// Control points of the locus, mm.
    pub control_points: Vec<Vector3<f64>>,
    /// Control points of θ, rad.
    pub angles: Vec<f64>,
    /// Contacts at equally spaced driver angles over the contact interval.
    pub trace: Trace,
}

/// A band of the published formulation. Its conjugation is only as good as its residuals.
#[derive(Debug, Clone)]
pub struct PaperBand {
    /// The J tooth pairs.
    pub teeth: Vec<PaperTooth>,
    /// Turning side: +1 or −1, the sign of n_y at θ = 0.
    pub side: f64,
    /// Largest |n·v_rel| over all contacts, mm/rad: what the penalty has left.
    pub residual_rolling: f64,
    /// Largest |n·T²| over all contacts, mm/rad: zero to round-off by construction.
    pub residual_tangent: f64,
    /// Weighted energies.
    pub energies: Energies,
}

impl PaperBand {
    /// Larger of the two residuals, mm/rad; NaN when a contact is not finite, so accept a band with
    /// `residual_max() <= tolerance`, never refuse it with `>`.
    pub fn residual_max(&self) -> f64 {
        if self.residual_rolling.is_nan() || self.residual_tangent.is_nan() {
            f64::NAN
        } else {
            self.residual_rolling.max(self.residual_tangent)
        }
    }
}

/// Unit of the locus variables over L, so that a unit of a locus and of an angle variable move a
/// contact by similar amounts.
const UNIT: f64 = 0.1;

/// Half width of the box for locus control points in x and y, over L.
const REACH: f64 = 0.25;

/// How far a locus may leave its segment's z range, over L: room for other bands' teeth.
const AXIAL_SLACK: f64 = 0.1;

/// C_widt asks for this share of the starting travel.
const WIDTH_SHARE: f64 = 0.75;

/// Spacing beyond thickness and safety gap, over L.
const SPACING_MARGIN: f64 = 0.008;

/// Every second sample of a bead axis enters the smooth minimum: 0.5 mm apart at L = 25.
const SPACING_STRIDE: usize = 2;

/// Temperature τ of the smooth minimum over the bead radius.
const SOFTNESS: f64 = 0.1;
