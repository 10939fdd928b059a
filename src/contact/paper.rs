//! The published tooth pair: locus and normal angle as splines, conjugation by a penalty.
//!
//! The locus p(φ) is an open cubic B-spline. With T² = ṗ − v₂(p) the contact normal is
//! n = N² cos θ + B² sin θ, θ(φ) a second spline, in the plane perpendicular to T². Perpendicularity
//! to T¹ = ṗ − v₁(p), the other half of conjugation, is asked for by the energy E_norm (Eq. 7).
//!
//! The publication leaves the frame {N², B²} and the energies to a supplement that we do not have. Here
//! N² is the projection of a fixed reference direction r onto the plane, normalised, and
//! B² = T̂² × N². This is smooth in p and ṗ wherever T² is not parallel to r; r lies in the xy plane at
//! the pressure angle [`PRESSURE_ANGLE`] on the turning side, so that θ = 0 is a sound start and
//! T² (along the helix of a tooth) stays away from it.
//!
//! Gradients are taken in reverse: an energy adds its derivatives by the sampled vectors to
//! [`Adjoint`]s, and [`ToothModel::pull_back`] turns these into derivatives by the variables.

use nalgebra::Vector3;

use super::plane::Plane;
use super::spline::Weights;
use super::{Contact, Node};
use crate::design::Gear;
use crate::motion::MotionState;

/// Pressure angle of the reference direction, rad.
pub const PRESSURE_ANGLE: f64 = std::f64::consts::FRAC_PI_6;

/// One tooth pair's interval: motion states and spline weights at the samples.
#[derive(Debug, Clone)]
pub struct ToothModel {
    stations: Vec<(Node, Weights, Weights)>,
    reference: Vector3<f64>,
    interval: f64,
    unit: f64,
    control: (usize, usize),
}

/// Contact vectors at one sample, in Σ.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Contact point, mm.
    pub p: Vector3<f64>,
    /// Contact normal into the follower, unit.
    pub n: Vector3<f64>,
    /// T¹, mm/rad.
    pub t1: Vector3<f64>,
    /// T², mm/rad.
    pub t2: Vector3<f64>,
    frame: Frame,
    theta: f64,
}

/// Derivatives of a scalar by the vectors of a [`Sample`].
#[derive(Debug, Clone, Copy)]
pub struct Adjoint {
    /// By the contact point.
    pub p: Vector3<f64>,
    /// By the normal.
    pub n: Vector3<f64>,
    /// By T¹.
    pub t1: Vector3<f64>,
    /// By T².
    pub t2: Vector3<f64>,
}

impl Adjoint {
    /// No derivative.
    pub fn zero() -> Adjoint {
        let zero = Vector3::zeros();
        Adjoint {
            p: zero,
            n: zero,
            t1: zero,
            t2: zero,
        }
    }
}

/// {T̂², N², B²}: r projected onto the plane perpendicular to T².
#[derive(Debug, Clone, Copy)]
struct Frame {
    reference: Vector3<f64>,
    length: f64,
    tangent: Vector3<f64>,
    /// |w| of w = r − (r·t) t.
    share: f64,
    normal: Vector3<f64>,
    binormal: Vector3<f64>,
}

impl Frame {
    fn new(reference: Vector3<f64>, t2: Vector3<f64>) -> Frame {
        let length = t2.norm();
        let tangent = t2 / length;
        let w = reference - reference.dot(&tangent) * tangent;
        let share = w.norm();
        let normal = w / share;
        Frame {
            reference,
            length,
            tangent,
            share,
            normal,
            binormal: tangent.cross(&normal),
        }
    }

    fn direction(&self, theta: f64) -> Vector3<f64> {
        let (s, c) = theta.sin_cos();
        self.normal * c + self.binormal * s
    }

    /// Derivative of [`Self::direction`] when T² and θ move at the given rates.
    fn direction_rate(&self, theta: f64, t2_rate: Vector3<f64>, theta_rate: f64) -> Vector3<f64> {
        let (s, c) = theta.sin_cos();
        let (r, t) = (self.reference, self.tangent);
        let t_rate = across(t, t2_rate) / self.length;
        let w_rate = -r.dot(&t_rate) * t - r.dot(&t) * t_rate;
        let n_rate = across(self.normal, w_rate) / self.share;
        let b_rate = t_rate.cross(&self.normal) + t.cross(&n_rate);
        n_rate * c + b_rate * s + (self.binormal * c - self.normal * s) * theta_rate
    }

    /// Derivatives by T² and θ of a scalar whose derivative by the direction is `g`.
    fn pull_back(&self, theta: f64, g: Vector3<f64>) -> (Vector3<f64>, f64) {
        let (s, c) = theta.sin_cos();
        let (r, t) = (self.reference, self.tangent);
        let by_binormal = g * s;
        let by_normal = g * c + by_binormal.cross(&t);
        let by_w = across(self.normal, by_normal) / self.share;
        let by_tangent = self.normal.cross(&by_binormal) - by_w.dot(&t) * r - r.dot(&t) * by_w;
        let by_theta = g.dot(&(self.binormal * c - self.normal * s));
        (across(t, by_tangent) / self.length, by_theta)
    }
}

/// Part of `v` perpendicular to the unit vector `u`.
fn across(u: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
    v - u.dot(&v) * u
}

impl ToothModel {
    /// Model over `nodes`, equally spaced over the contact interval; `side` is the sign of n_y at
    /// θ = 0, `unit` the length in mm of one unit of the locus variables, `control` the numbers of
    /// control points (l, ρ).
    pub fn new(
        nodes: impl Iterator<Item = Node>,
        side: f64,
        unit: f64,
        control: (usize, usize),
    ) -> ToothModel {
        let nodes: Vec<Node> = nodes.collect();
        let last = nodes.len().saturating_sub(1).max(1) as f64;
        let interval = match (nodes.first(), nodes.last()) {
            (Some(a), Some(b)) => b.phi - a.phi,
            _ => 0.0,
        };
        let stations = nodes
            .into_iter()
            .enumerate()
            .map(|(i, node)| {
                let u = i as f64 / last;
                (node, Weights::at(control.0, u), Weights::at(control.1, u))
            })
            .collect();
        let (s, c) = PRESSURE_ANGLE.sin_cos();
        ToothModel {
            stations,
            reference: Vector3::new(s, side * c, 0.0),
            interval,
            unit,
            control,
        }
    }

    /// Number of variables, 3l + ρ: locus control points in units, then angle control points in rad.
    pub fn variables(&self) -> usize {
        3 * self.control.0 + self.control.1
    }

    /// Locus control points of `x`, mm.
    pub fn control_points(&self, x: &[f64]) -> Vec<Vector3<f64>> {
        x[..3 * self.control.0]
            .chunks_exact(3)
            .map(|c| Vector3::new(c[0], c[1], c[2]) * self.unit)
            .collect()
    }

    /// Angle control points of `x`, rad.
    pub fn angles<'a>(&self, x: &'a [f64]) -> &'a [f64] {
        &x[3 * self.control.0..]
    }

    /// Evaluates all samples at the variables `x`. A vanishing T² or one parallel to r gives NaN.
    pub fn samples(&self, x: &[f64]) -> Vec<Sample> {
        let points = self.control_points(x);
        self.stations
            .iter()
            .map(|(node, locus, angle)| {
                let p = blend(&locus.value, &points);
                let p_rate = blend(&locus.first, &points) / self.interval;
                let t2 = p_rate - node.follower.velocity(p);
                let frame = Frame::new(self.reference, t2);
                let theta = dot(&angle.value, self.angles(x));
                Sample {
                    p,
                    n: frame.direction(theta),
                    t1: p_rate - node.driver.velocity(p),
                    t2,
                    frame,
                    theta,
                }
            })
            .collect()
    }

    /// Adds to `gradient` the derivatives by the variables of a scalar given by its derivatives by
    /// the samples.
    pub fn pull_back(&self, samples: &[Sample], adjoints: &[Adjoint], gradient: &mut [f64]) {
        let (by_points, by_angles) = gradient.split_at_mut(3 * self.control.0);
        for (((node, locus, angle), sample), adjoint) in
            self.stations.iter().zip(samples).zip(adjoints)
        {
            let (by_t2, by_theta) = sample.frame.pull_back(sample.theta, adjoint.n);
            let (t1, t2) = (adjoint.t1, adjoint.t2 + by_t2);
            // T = ṗ − v₀ − ω × p, so p moves T by −ω × dp.
            let by_p = adjoint.p + node.driver.omega.cross(&t1) + node.follower.omega.cross(&t2);
            let by_rate = (t1 + t2) / self.interval;
            for (a, g) in by_points.chunks_exact_mut(3).enumerate() {
                let d = (by_p * locus.value[a] + by_rate * locus.first[a]) * self.unit;
                g.iter_mut().zip(d.iter()).for_each(|(g, d)| *g += d);
            }
            by_angles
                .iter_mut()
                .zip(&angle.value)
                .for_each(|(g, w)| *g += by_theta * w);
        }
    }

    /// Contacts at the samples, with the second-order gap from ṅ of the splines.
    pub fn contacts(&self, x: &[f64]) -> Vec<Contact> {
        let points = self.control_points(x);
        self.stations
            .iter()
            .zip(self.samples(x))
            .map(|((node, locus, angle), s)| {
                let (driver, follower) = (&node.driver, &node.follower);
                let p_rate = blend(&locus.first, &points) / self.interval;
                let p_rate_rate = blend(&locus.second, &points) / (self.interval * self.interval);
                let t2_rate = p_rate_rate
                    - follower.v_origin_rate
                    - follower.omega_rate.cross(&s.p)
                    - follower.omega.cross(&p_rate);
                let theta_rate = dot(&angle.first, self.angles(x)) / self.interval;
                let n_rate = s.frame.direction_rate(s.theta, t2_rate, theta_rate);
                let v_rel = s.t1 - s.t2;
                let omega_rel = follower.omega - driver.omega;
                let gap = (n_rate - driver.omega.cross(&s.n)).dot(&v_rel)
                    - s.n.dot(&omega_rel.cross(&s.t2));
                Contact {
                    phi: node.phi,
                    p: s.p,
                    n: s.n,
                    t1: s.t1,
                    t2: s.t2,
                    gap,
                    turning: [
                        n_rate - driver.omega.cross(&s.n),
                        n_rate - follower.omega.cross(&s.n),
                    ],
                }
            })
            .collect()
    }

    /// State of `gear` at sample `i`.
    pub fn state(&self, gear: Gear, i: usize) -> &MotionState {
        let node = &self.stations[i].0;
        match gear {
            Gear::Driver => &node.driver,
            Gear::Follower => &node.follower,
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.stations.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.stations.is_empty()
    }

    /// E_norm = mean (n·T̂¹)², times `weight`.
    pub fn e_norm(&self, samples: &[Sample], weight: f64, adjoints: &mut [Adjoint]) -> f64 {
        let weight = weight / samples.len() as f64;
        let mut sum = 0.0;
        for (s, g) in samples.iter().zip(adjoints) {
            let length = s.t1.norm();
            let t1 = s.t1 / length;
            let d = s.n.dot(&t1);
            g.n += 2.0 * weight * d * t1;
            g.t1 += 2.0 * weight * d / length * across(t1, s.n);
            sum += weight * d * d;
        }
        sum
    }

    /// E_tang = mean |T̂¹ × T̂²|² = mean 1 − (T̂¹·T̂²)², times `weight`.
    pub fn e_tang(&self, samples: &[Sample], weight: f64, adjoints: &mut [Adjoint]) -> f64 {
        let weight = weight / samples.len() as f64;
        let mut sum = 0.0;
        for (s, g) in samples.iter().zip(adjoints) {
            let (l1, l2) = (s.t1.norm(), s.t2.norm());
            let (t1, t2) = (s.t1 / l1, s.t2 / l2);
            let c = t1.dot(&t2);
            g.t1 -= 2.0 * weight * c / l1 * across(t1, t2);
            g.t2 -= 2.0 * weight * c / l2 * across(t2, t1);
            // As a cross product: 1 − c² loses the small values we are after.
            sum += weight * t1.cross(&t2).norm_squared();
        }
        sum
    }

    /// E_plan = Σ over both gears of the tooth curve's mean squared distance from its best plane over
    /// that from its centroid, times `weight`.
    pub fn e_plan(&self, samples: &[Sample], weight: f64, adjoints: &mut [Adjoint]) -> f64 {
        let mut sum = 0.0;
        for gear in [Gear::Driver, Gear::Follower] {
            let curve: Vec<Vector3<f64>> = samples
                .iter()
                .enumerate()
                .map(|(i, s)| self.state(gear, i).pose.inverse_apply(s.p))
                .collect();
            let plane = Plane::fit(&curve);
            let ratio = plane.thickness / plane.spread;
            for (i, (q, g)) in curve.iter().zip(adjoints.iter_mut()).enumerate() {
                let by_q = (plane.thickness_by(*q) - ratio * plane.spread_by(*q)) / plane.spread;
                g.p += self.state(gear, i).pose.rotation * by_q * weight;
            }
            sum += weight * ratio;
        }
        sum
    }
}

fn blend(weights: &[f64], points: &[Vector3<f64>]) -> Vector3<f64> {
    weights.iter().zip(points).map(|(w, p)| p * *w).sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
