//! How large min Q can be at all, whatever the teeth: an upper bound from the motion, the centre distance
//! and how far from the joint's centre contacts reach.
//!
//! Conjugation asks for n·v_rel = 0 at the contact. With the follower's joint centre C as reference, its
//! velocity ċ along z, driver speed ω₁ and the moment m = (p − C)×n this reads
//!
//!   ω_rel·m = ω₁ L n_y − ċ n_z,
//!
//! so the moment about ω_rel is fixed by the normal alone: at most ω₁ L/|ω_rel| where nothing slides. The
//! other moments are bounded by |m| ≤ |p − C| ≤ P. That is the set A(φ) of admissible wrenches.
//!
//! **Any K.** For every unit d, Q ≤ max_k d·n̄_k ≤ max over A of d·n̄.
//!
//! **K = N+1.** The hull is a simplex with vertices v_i and facets of unit normal u_i at distance q_i ≥ Q;
//! λ are the weights with Σ λ_i v_i = 0. Then Σ λ_i v_i u_iᵀ/q_i = −I (apply it to every vertex), hence for
//! any matrix W: tr W = −Σ λ_i u_i·W v_i / q_i ≤ max|W v|/Q, that is
//!
//!   Q ≤ max over A of |W v| / tr W.
//!
//! W = I gives r/N, a diagonal W the inradius 1/√(Σ 1/s²) of a box with half sides s. Every W is
//! a bound; the least of a grid of diagonal ones (along ω_rel, across it, along the slide) is taken.

use crate::design::Design;
use crate::motion::{Class, Motion};

/// Upper bounds of min Q and min Q*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QBound {
    /// Of min Q, in its unit.
    pub q: f64,
    /// Of min Q*.
    pub q_star: f64,
    /// Driver angle where the bound of Q* is least, rad.
    pub phi: f64,
}

/// The admissible wrenches at one φ.
#[derive(Debug, Clone, Copy)]
struct Admissible {
    /// Largest moment about ω_rel per unit of n_y: ω₁ L/|ω_rel|, in the unit of moments.
    turn: f64,
    /// Share of the slide in it: ċ/(ω₁ L).
    slide: f64,
    /// Largest moment in all: P, in the unit of moments.
    reach: f64,
}

impl Admissible {
    /// Largest size of the wrench with weights for the slide, the moment about ω_rel and the moments
    /// across it.
    fn largest(&self, class: Class, [slide, along, across]: [f64; 3]) -> f64 {
        // |W v|² = slide² n_z² + (along² − across²) m_ω² + across² |m|² with m_ω = turn (n_y − slide n_z):
        // a quadratic form in (n_y, n_z), |(n_y, n_z)| ≤ 1, besides the last term.
        let reach = match class {
            Class::R1 | Class::R1T1 => 0.0,
            Class::R3 | Class::R3T1 => across * self.reach,
        };
        let across = match class {
            Class::R1 | Class::R1T1 => 0.0,
            Class::R3 | Class::R3T1 => across,
        };
        let slides = if class.slides() { slide } else { 0.0 };
        let gain = (along * along - across * across) * self.turn * self.turn;
        let (yy, yz) = (gain, -gain * self.slide);
        let zz = gain * self.slide * self.slide + slides * slides;
        let (mean, half) = (0.5 * (yy + zz), 0.5 * (yy - zz));
        let form = (mean + half.hypot(yz)).max(0.0);
        (form + reach * reach).sqrt()
    }

    /// Bound of Q for `contacts` contacts.
    fn bound(&self, class: Class, contacts: usize) -> f64 {
        let about = self.turn * 1f64.hypot(self.slide);
        let mut least = about;
        if class.slides() {
            least = least.min(1.0);
        }
        if class.is_spherical() {
            least = least.min(self.reach);
        }
        if contacts > class.dof() + 1 {
            return least;
        }
        // Weights relative to what the wrench can be in each direction.
        let size = |x: f64| if x > 0.0 { 1.0 / x } else { 1.0 };
        let steps = |on: bool| if on { -GRID..=GRID } else { 0..=0 };
        for a in steps(class.slides()) {
            for b in steps(class.is_spherical()) {
                let w = [RATIO.powi(a), size(about), RATIO.powi(b) * size(self.reach)];
                let trace = match class {
                    Class::R1 => w[1],
                    Class::R1T1 => w[0] + w[1],
                    Class::R3 => w[1] + 2.0 * w[2],
                    Class::R3T1 => w[0] + w[1] + 2.0 * w[2],
                };
                least = least.min(self.largest(class, w) / trace);
            }
        }
        least
    }
}

/// Phases looked at, at most.
const PHASES: usize = 720;
/// Weights tried to each side, and their ratio.
const GRID: i32 = 12;
const RATIO: f64 = 1.15;

/// The bound for the motion, size and reach of `design`; `None` without contacts.
pub fn of(design: &Design, motion: &Motion) -> Option<QBound> {
    let contacts = design.sub_gear_pairs.len();
    let stations = || {
        let teeth = design.sub_gear_pairs.iter().flat_map(|pair| &pair.teeth);
        teeth.flat_map(|tooth| &tooth.stations)
    };
    let reach = stations()
        .map(|s| (nalgebra::Vector3::from(s.p) - motion.joint_centre(s.phi)).norm())
        .reduce(f64::max)?;
    let distance = design.settings.gear.center_distance_mm;
    let drive = design.settings.gear.drive();
    let class = motion.class();
    let mut bound = QBound {
        q: f64::INFINITY,
        q_star: f64::INFINITY,
        phi: 0.0,
    };
    // Any phases give a bound, and the admissible wrenches change slowly.
    for sample in design
        .closure
        .iter()
        .step_by(design.closure.len().div_ceil(PHASES).max(1))
    {
        let follower = motion.state(sample.phi);
        let driver = drive.state(sample.phi);
        // Speed of the driver's points at O, mm/rad.
        let speed = distance * drive.rate();
        let centre = motion.joint_centre(sample.phi);
        let turning = (follower.omega - driver.omega).norm();
        let at = |unit: f64| Admissible {
            turn: speed / turning / unit,
            slide: follower.velocity(centre).z / speed,
            reach: reach / unit,
        };
        bound.q = bound.q.min(at(1.0).bound(class, contacts));
        let q_star = at(0.5 * distance).bound(class, contacts);
        if q_star < bound.q_star {
            bound = QBound {
                q_star,
                phi: sample.phi,
                ..bound
            };
        }
    }
    bound.q.is_finite().then_some(bound)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closure::{Wrench, measure};
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    #[test]
    fn a_uniform_turn_allows_half_the_distance_and_a_slide_a_half() {
        let at = Admissible {
            turn: 12.5,
            slide: 0.0,
            reach: 30.0,
        };
        assert_relative_eq!(at.bound(Class::R1, 2), 12.5);
        // Scaled moments: a unit disc, of whose triangles the regular one has the largest inradius.
        let disc = Admissible { turn: 1.0, ..at };
        assert_relative_eq!(disc.bound(Class::R1T1, 3), 0.5, epsilon = 1e-12);
        assert_relative_eq!(disc.bound(Class::R1T1, 4), 1.0, epsilon = 1e-12);
    }

    /// Wrenches of admissible contacts, in the frame with ω_rel along the first moment.
    fn admissible(class: Class, at: &Admissible, [a, b, c, d]: [f64; 4]) -> Wrench {
        // n on the sphere, the moment across as long as |m| ≤ reach leaves it, in direction d.
        let (nz, turn) = (2.0 * a - 1.0, std::f64::consts::TAU * b);
        let ny = (1.0 - nz * nz).max(0.0).sqrt() * turn.cos();
        let about = at.turn * (ny - at.slide * nz);
        let across = c * (at.reach * at.reach - about * about).max(0.0).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * d).sin_cos();
        match class {
            Class::R1 => [about, 0.0, 0.0, 0.0],
            Class::R1T1 => [nz, about, 0.0, 0.0],
            Class::R3 => [about, across * cos, across * sin, 0.0],
            Class::R3T1 => [nz, about, across * cos, across * sin],
        }
    }

    proptest! {
        /// No set of admissible contacts closes better than the bound says.
        #[test]
        fn no_contacts_close_better(
            numbers in prop::collection::vec(prop::array::uniform4(0.0f64..1.0), 12),
            turn in 0.3f64..1.5,
            slide in -0.6f64..0.6,
            more in 0.0f64..2.0,
        ) {
            for class in [Class::R1, Class::R1T1, Class::R3, Class::R3T1] {
                let slide = if class.slides() { slide } else { 0.0 };
                let at = Admissible { turn, slide, reach: turn * 1f64.hypot(slide) + more };
                let all: Vec<Wrench> = numbers.iter().map(|x| admissible(class, &at, *x)).collect();
                let k = class.dof() + 1;
                for set in all.windows(k) {
                    prop_assert!(measure(set, class.dof()) <= at.bound(class, k) + 1e-9);
                }
                prop_assert!(measure(&all, class.dof()) <= at.bound(class, 12) + 1e-9);
            }
        }
    }
}
