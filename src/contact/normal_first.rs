//! Conjugate curves from a chosen normal: exact by construction.
//!
//! Choose the contact normal n(φ) and the axial coordinate s(φ) of the locus. Conjugation asks for
//!
//! (a) n·v_rel(p) = 0, a plane (n × ω_rel)·p = −n·v_rel(O), and
//! (b) n·ṗ = n·v₂(p), which for q = n·p is the scalar equation q̇ = ṅ·p + n·v₂(p).
//!
//! At every φ the contact point solves the 3×3 system of n·p = q, (a) and e_z·p = s; q is integrated
//! from the middle of the interval both ways. Both gears then share point and normal to round-off.
//! The published formulation reaches (a) by a penalty only; this one replaces it.

use nalgebra::{Matrix3, Vector3};

use crate::motion::{Cycle, Drive, Motion, MotionState};

/// Driver and follower at one φ.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// Phase, rad.
    pub phi: f64,
    /// Driver state.
    pub driver: MotionState,
    /// Follower state.
    pub follower: MotionState,
}

/// Motion states of all J contact intervals, tabulated once: 2·steps + 1 nodes a tooth, so that a
/// Runge-Kutta step over two nodes finds its midpoint in the table.
#[derive(Debug, Clone)]
pub struct Grid {
    /// How the driver turns.
    pub drive: Drive,
    /// The phases of all teeth.
    pub cycle: Cycle,
    /// Mean speed at which the follower turns against the driver, per phase.
    pub turning: f64,
    /// Distance of the mean pitch point from the follower's axis, mm.
    pub pitch_radius: f64,
    /// Half the length of a contact interval, rad.
    pub half_interval: f64,
    /// Number of integration steps a tooth; even. Stations are steps + 1.
    pub steps: usize,
    /// Nodes of tooth j, from start to end of its interval.
    pub teeth: Vec<Vec<Node>>,
}

impl Grid {
    /// Tabulates `teeth` intervals of contact ratio `contact_ratio` (Eq. 9) with `steps` steps each
    /// (rounded up to even).
    pub fn new(motion: &Motion, gear: &crate::settings::Gear, steps: usize) -> Grid {
        let steps = steps.next_multiple_of(2);
        let (cycle, drive) = (motion.cycle(), gear.drive());
        let pairs = cycle.pairs(gear.tooth_pairs());
        let pitch = cycle.length() / pairs as f64;
        let half_interval = 0.5 * gear.contact_ratio * pitch;
        let node = |phi: f64| Node {
            phi,
            driver: drive.state(phi),
            follower: motion.state(phi),
        };
        let teeth = (0..pairs)
            .map(|j| {
                let centre = cycle.start() + (j as f64 + 0.5) * pitch;
                (0..=2 * steps)
                    .map(|i| node(centre + half_interval * (i as f64 / steps as f64 - 1.0)))
                    .collect()
            })
            .collect();
        Grid {
            drive,
            cycle,
            turning: motion.turning(),
            pitch_radius: drive.follower_pitch_radius(motion.turning()),
            half_interval,
            steps,
            teeth,
        }
    }
}

/// Design variables of one tooth pair; angles in rad, lengths in mm, `u` runs from −½ to ½ over the
/// contact interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothLaw {
    /// Pressure angle α at u = 0: positive pushes the follower away from the driver.
    pub alpha: f64,
    /// Helix-like angle β at u = 0: share of the normal along z.
    pub beta: f64,
    /// Change of α over the interval.
    pub alpha_change: f64,
    /// Change of β over the interval.
    pub beta_change: f64,
    /// Turning side: +1 or −1, the sign of n_y.
    pub side: f64,
    /// Axial coordinate of the locus at u = 0.
    pub z: f64,
    /// Axial travel of the locus over the interval.
    pub travel: f64,
    /// Offset of the contact from the pitch point along n at u = 0.
    pub offset: f64,
}

impl ToothLaw {
    /// Unit normal into the follower and its derivative by u.
    pub(crate) fn normal(&self, u: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (sa, ca) = (self.alpha + self.alpha_change * u).sin_cos();
        let (sb, cb) = (self.beta + self.beta_change * u).sin_cos();
        let by_alpha = Vector3::new(cb * ca, -self.side * cb * sa, 0.0);
        let by_beta = Vector3::new(-sb * sa, -self.side * sb * ca, cb);
        (
            Vector3::new(cb * sa, self.side * cb * ca, sb),
            by_alpha * self.alpha_change + by_beta * self.beta_change,
        )
    }
}

impl Node {
    /// Pitch point at height `z`: where the gears' relative velocity has no component across z, mm.
    /// For a uniform motion it is (−L/2, 0, z); a wobbling follower moves it about, as the centrodes of
    /// non-circular gears.
    pub fn pitch_point(&self, z: f64) -> Vector3<f64> {
        let w = self.follower.omega - self.driver.omega;
        let v = self.follower.v_origin - self.driver.v_origin;
        Vector3::new((w.x * z - v.y) / w.z, (v.x + w.y * z) / w.z, z)
    }

    /// How far the follower's plane at height `z` stands above that height between the gears, at the
    /// pitch point of a uniform turn, `radius` from the follower's axis, mm.
    pub fn rise(&self, z: f64, radius: f64) -> f64 {
        let pose = &self.follower.pose;
        let axis = pose.rotation.column(2);
        let to = Vector3::new(-radius, 0.0, 0.0) - pose.translation;
        (z - axis.x * to.x - axis.y * to.y) / axis.z + pose.translation.z - z
    }
}

/// One contact in Σ with its first derivatives.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// Driver angle, rad.
    pub phi: f64,
    /// Contact point, mm.
    pub p: Vector3<f64>,
    /// Unit normal into the follower.
    pub n: Vector3<f64>,
    /// T¹ = ṗ − v₁(p), mm/rad.
    pub t1: Vector3<f64>,
    /// T² = ṗ − v₂(p), mm/rad.
    pub t2: Vector3<f64>,
    /// Second-order gap g ≥ 0: the teeth part by ½ g δφ² beside the contact, mm/rad².
    pub gap: f64,
    /// dn/dφ seen from the driver and from the follower, 1/rad.
    pub turning: [Vector3<f64>; 2],
}

impl Contact {
    /// Smallest induced normal curvature of two beads of radius `radius` (mm) in any tangential
    /// direction, 1/mm: condition (4) of conjugation, positive where the surfaces part on all sides.
    ///
    /// The Weingarten map W of a bead is known along its path, W T = dn, and across it, 1/radius; the
    /// surfaces part by ½ x·(W₁ + W₂)x.
    pub fn induced_curvature(&self, radius: f64) -> f64 {
        let e1 = self.t1.normalize();
        let e2 = self.n.cross(&e1);
        let mut sum = nalgebra::Matrix2::zeros();
        // The follower's outward normal is −n.
        for (t, turning) in [(self.t1, self.turning[0]), (self.t2, -self.turning[1])] {
            let along = t.normalize();
            let across = self.n.cross(&along);
            let (tt, tb) = (
                turning.dot(&along) / t.norm(),
                turning.dot(&across) / t.norm(),
            );
            let own = nalgebra::Matrix2::new(tt, tb, tb, 1.0 / radius);
            let basis = nalgebra::Matrix2::new(
                e1.dot(&along),
                e2.dot(&along),
                e1.dot(&across),
                e2.dot(&across),
            );
            sum += basis.transpose() * own * basis;
        }
        let (mean, half) = (0.5 * sum.trace(), 0.5 * (sum[(0, 0)] - sum[(1, 1)]));
        // Far from overflow, so plainly.
        mean - (half * half + sum[(0, 1)] * sum[(0, 1)]).sqrt()
    }
}

/// A traced tooth pair.
pub type Trace = Vec<Contact>;

/// The linear system of one node for a normal law, solved for the contact point.
struct Local {
    n: Vector3<f64>,
    n_rate: Vector3<f64>,
    omega_rel: Vector3<f64>,
    v_rel: Vector3<f64>,
    inverse: Matrix3<f64>,
    z: f64,
    z_rate: f64,
}

impl Local {
    /// `None` where the system degenerates: n ∥ ω_rel, or z within their plane.
    fn new(node: &Node, law: &ToothLaw, u: f64, interval: f64) -> Option<Local> {
        let (n, by_u) = law.normal(u);
        let omega_rel = node.follower.omega - node.driver.omega;
        let rows = Matrix3::from_rows(&[
            n.transpose(),
            n.cross(&omega_rel).transpose(),
            Vector3::z().transpose(),
        ]);
        // Rows are of size 1, |ω_rel| ≈ 2 and 1; below this the point runs away along the locus.
        if rows.determinant().abs() < 0.05 {
            return None;
        }
        Some(Local {
            n,
            n_rate: by_u / interval,
            omega_rel,
            v_rel: node.follower.v_origin - node.driver.v_origin,
            inverse: rows.try_inverse()?,
            z: law.z + law.travel * u,
            z_rate: law.travel / interval,
        })
    }

    fn point(&self, q: f64) -> Vector3<f64> {
        self.inverse * Vector3::new(q, -self.n.dot(&self.v_rel), self.z)
    }

    fn q_rate(&self, node: &Node, p: Vector3<f64>) -> f64 {
        self.n_rate.dot(&p) + self.n.dot(&node.follower.velocity(p))
    }

    fn contact(&self, node: &Node, q: f64) -> Contact {
        let p = self.point(q);
        let v1 = node.driver.velocity(p);
        let v2 = node.follower.velocity(p);
        let omega_rate = node.follower.omega_rate - node.driver.omega_rate;
        let v_rate = node.follower.v_origin_rate - node.driver.v_origin_rate;
        let plane_rate = self.n_rate.cross(&self.omega_rel) + self.n.cross(&omega_rate);
        let p_rate = self.inverse
            * Vector3::new(
                self.q_rate(node, p) - self.n_rate.dot(&p),
                -self.n_rate.dot(&self.v_rel) - self.n.dot(&v_rate) - plane_rate.dot(&p),
                self.z_rate,
            );
        let t2 = p_rate - v2;
        Contact {
            phi: node.phi,
            p,
            n: self.n,
            t1: p_rate - v1,
            t2,
            gap: (self.n_rate - node.driver.omega.cross(&self.n)).dot(&(v2 - v1))
                - self.n.dot(&self.omega_rel.cross(&t2)),
            turning: [node.driver.omega, node.follower.omega]
                .map(|w| self.n_rate - w.cross(&self.n)),
        }
    }
}

/// Traces tooth `j` of `grid`: `grid.steps + 1` contacts from start to end of the interval.
/// `None` where the law degenerates (see [`ToothLaw`]) or runs out of the gear.
pub fn trace(grid: &Grid, j: usize, law: &ToothLaw) -> Option<Trace> {
    let nodes = &grid.teeth[j];
    let interval = 2.0 * grid.half_interval;
    let step = interval / grid.steps as f64;
    let middle = grid.steps;
    let local = |i: usize| {
        Local::new(
            &nodes[i],
            law,
            i as f64 / (2 * grid.steps) as f64 - 0.5,
            interval,
        )
    };
    let pitch_point = nodes[middle].pitch_point(law.z);
    let middle_local = local(middle)?;
    let q_middle = middle_local.n.dot(&pitch_point) + law.offset;

    let mut contacts = vec![middle_local.contact(&nodes[middle], q_middle)];
    for direction in [1_isize, -1] {
        let h = step * direction as f64;
        let mut q = q_middle;
        let mut here = local(middle)?;
        for k in 0..grid.steps / 2 {
            let at =
                |offset: usize| (middle as isize + direction * (2 * k + offset) as isize) as usize;
            let (i0, i1, i2) = (at(0), at(1), at(2));
            let (half, next) = (local(i1)?, local(i2)?);
            let rate = |l: &Local, i: usize, q: f64| l.q_rate(&nodes[i], l.point(q));
            let k1 = rate(&here, i0, q);
            let k2 = rate(&half, i1, q + 0.5 * h * k1);
            let k3 = rate(&half, i1, q + 0.5 * h * k2);
            let k4 = rate(&next, i2, q + h * k3);
            q += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            let contact = next.contact(&nodes[i2], q);
            // A contact further than L from the pitch point belongs to no gear of this size.
            if !((contact.p - pitch_point).norm() < grid.drive.center_distance()) {
                return None;
            }
            contacts.push(contact);
            here = next;
        }
    }
    contacts.sort_by(|a, b| a.phi.total_cmp(&b.phi));
    Some(contacts)
}
