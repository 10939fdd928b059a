//! The contacts that carry load at a driver angle, read between the stations of a design.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2, Vector3};

use crate::design::{Design, Gear, Section, SubGearPair, ToothPair};
use crate::motion::{Class, Motion, MotionState};
use crate::solid::section;
use crate::{Error, Result};

/// Stations a value is interpolated from: a polynomial of degree five, whose error at the usual
/// 20 to 40 stations per tooth is below 1e-8 of the value.
pub(crate) const WINDOW: usize = 6;

/// Angles closer than this to a hand-over are at it, rad.
const HANDOVER: f64 = 1e-9;

/// One tooth pair in contact.
#[derive(Debug, Clone)]
pub struct Contact {
    /// Sub-gear pair k, from 0.
    pub pair: usize,
    /// Tooth j, from 0.
    pub tooth: usize,
    /// Where it is along its tooth: share of the contact interval, from 0 to 1.
    pub share: f64,
    /// Contact point in Σ, mm.
    pub p: Vector3<f64>,
    /// Unit contact normal in Σ, into the follower.
    pub n: Vector3<f64>,
    /// Tangent directions e₁, e₂ in Σ with e₁ × e₂ = n; the curvatures below refer to them.
    pub tangents: [Vector3<f64>; 2],
    /// Direction across the driver's tooth and across the follower's, on the tangents.
    pub across: [Vector2<f64>; 2],
    /// Height of both flanks above and below the contact, mm.
    pub flank_height: f64,
    /// Curvature of the driver's flank, 1/mm, positive where it bulges towards the follower.
    pub driver_curvature: Matrix2<f64>,
    /// Curvature of the follower's flank, 1/mm, positive where it bulges towards the driver.
    pub follower_curvature: Matrix2<f64>,
}

/// Contacts, bodies and joint at one driver angle.
#[derive(Debug, Clone)]
pub struct Configuration {
    /// Driver angle, rad.
    pub phi: f64,
    /// Class of the joint.
    pub class: Class,
    /// One contact per sub-gear pair.
    pub contacts: Vec<Contact>,
    /// State of the driver.
    pub driver: MotionState,
    /// State of the follower.
    pub follower: MotionState,
    /// Present joint centre, Σ, mm.
    pub centre: Vector3<f64>,
}

impl Configuration {
    /// Contacts at `phi` (rad): of each sub-gear pair the tooth whose subinterval holds `phi`.
    ///
    /// # Errors
    /// [`Error::Infeasible`] when no tooth of a pair reaches `phi` or has too few stations.
    pub fn at(design: &Design, motion: &Motion, phi: f64) -> Result<Configuration> {
        let driver = design.settings.gear.drive().state(phi);
        let follower = motion.state(phi);
        let contacts = design
            .sub_gear_pairs
            .iter()
            .enumerate()
            .map(|(k, pair)| {
                let (j, phi_tooth) = active_tooth(pair, phi).ok_or_else(|| missing(phi, k))?;
                let mut contact = contact(
                    &pair.teeth[j],
                    phi_tooth,
                    (&driver, &follower),
                    &design.section_of(pair),
                )
                .ok_or_else(|| missing(phi, k))?;
                (contact.pair, contact.tooth) = (k, j);
                Ok(contact)
            })
            .collect::<Result<_>>()?;
        Ok(Configuration {
            phi,
            class: design.class,
            contacts,
            driver,
            follower,
            centre: motion.joint_centre(phi),
        })
    }

    /// Relative velocity of the follower against the driver at `p` (Σ), mm/rad.
    pub fn sliding(&self, p: Vector3<f64>) -> Vector3<f64> {
        self.follower.velocity(p) - self.driver.velocity(p)
    }
}

fn missing(phi: f64, pair: usize) -> Error {
    Error::Infeasible {
        reason: "no tooth in contact".into(),
        place: format!("φ = {:.2}°, sub-gear pair {}", phi.to_degrees(), pair + 1),
        hint: "the design does not cover the whole driver range; design it again".into(),
    }
}

/// Tooth of `pair` whose contact interval holds `phi` deepest inside, and `phi` shifted by whole
/// periods into that interval. Neighbours overlap by (c−1)T/J; the middle of the overlap is where
/// the subinterval of one ends and the next begins.
pub fn active_tooth(pair: &SubGearPair, phi: f64) -> Option<(usize, f64)> {
    let depth = |tooth: &ToothPair| {
        let middle = 0.5 * (tooth.phi_start + tooth.phi_end);
        let half = 0.5 * (tooth.phi_end - tooth.phi_start);
        let shifted = phi - TAU * ((phi - middle) / TAU).round();
        // Where one subinterval ends and the next begins, the next one's tooth counts.
        let newcomer = HANDOVER * (middle - shifted) / half;
        (half - (shifted - middle).abs() + newcomer, shifted)
    };
    pair.teeth
        .iter()
        .map(depth)
        .enumerate()
        .max_by(|a, b| a.1.0.total_cmp(&b.1.0))
        .filter(|(_, (depth, _))| *depth >= -2.0 * HANDOVER)
        .map(|(j, (_, shifted))| (j, shifted))
}

/// Lagrange weights of value, first and second derivative at `x` for unit-spaced nodes `0..WINDOW`.
pub(crate) fn weights(x: f64) -> [[f64; WINDOW]; 3] {
    let basis = |i: usize| {
        // The basis polynomial and its derivatives, one linear factor after the other.
        let (mut value, mut first, mut second) = (1.0, 0.0, 0.0);
        for m in (0..WINDOW).filter(|&m| m != i) {
            let scale = 1.0 / (i as f64 - m as f64);
            let factor = (x - m as f64) * scale;
            second = second * factor + 2.0 * first * scale;
            first = first * factor + value * scale;
            value *= factor;
        }
        [value, first, second]
    };
    let all: [[f64; 3]; WINDOW] = std::array::from_fn(basis);
    std::array::from_fn(|order| all.map(|of_node| of_node[order]))
}

/// First of the [`WINDOW`] stations around the stretch that begins at `station`, of `count` stations, which
/// are at least as many.
pub(crate) fn window(station: usize, count: usize) -> usize {
    station.saturating_sub(WINDOW / 2 - 1).min(count - WINDOW)
}

fn contact(
    tooth: &ToothPair,
    phi: f64,
    (driver, follower): (&MotionState, &MotionState),
    section: &Section,
) -> Option<Contact> {
    let count = tooth.stations.len();
    if count < WINDOW {
        return None;
    }
    let step = (tooth.phi_end - tooth.phi_start) / (count - 1) as f64;
    let x = (phi - tooth.phi_start) / step;
    let first = window(x.max(0.0) as usize, count);
    let w = weights(x - first as f64);
    let stations = &tooth.stations[first..first + WINDOW];
    let blend = |order: usize, get: &dyn Fn(usize) -> Vector3<f64>| {
        (0..WINDOW)
            .map(|i| w[order][i] * get(i))
            .sum::<Vector3<f64>>()
            / step.powi(order as i32)
    };

    let p = blend(0, &|i| Vector3::from(stations[i].p));
    let n = blend(0, &|i| Vector3::from(stations[i].n)).normalize();
    let any = if n.z.abs() < 0.9 {
        Vector3::z()
    } else {
        Vector3::x()
    };
    let e1 = any.cross(&n).normalize();
    let tangents = [e1, n.cross(&e1)];

    // The flank is a circle of the flank radius swept along the contact curve in the plane across
    // it. Along the curve it bends with p″·m, across with 1/r, twisted by b′·m; m is the normal
    // into the material, towards which a convex flank bends.
    let on_tangents = |v: Vector3<f64>| Vector2::from(tangents.map(|e| v.dot(&e)));
    let curvature = |gear: Gear, state: &MotionState| {
        let frame = |i: usize| stations[i].frame(gear);
        let m = blend(0, &|i| frame(i).1).normalize();
        let speed = blend(1, &|i| frame(i).0);
        let acceleration = blend(2, &|i| frame(i).0);
        let turn = blend(1, &|i| frame(i).1);
        let t = speed.normalize();
        let b = m.cross(&t);
        let along = acceleration.dot(&m) / speed.norm_squared();
        let twist = -b.dot(&turn) / speed.norm();
        let [t, b] = [t, b].map(|v| on_tangents(state.pose.rotation * v));
        let turn = Matrix2::from_rows(&[t.transpose(), b.transpose()]);
        let own = Matrix2::new(along, twist, twist, 1.0 / section.flank_radius);
        (turn.transpose() * own * turn, b)
    };
    let (driver_curvature, driver_across) = curvature(Gear::Driver, driver);
    let (follower_curvature, follower_across) = curvature(Gear::Follower, follower);
    Some(Contact {
        pair: 0,
        tooth: 0,
        share: x / (count - 1) as f64,
        p,
        n,
        tangents,
        across: [driver_across, follower_across],
        flank_height: section::flank_height(section),
        driver_curvature,
        follower_curvature,
    })
}
