//! The conditions of conjugation, from the stations of `design.json` and the motion alone: nothing of
//! what the optimiser computed on the way is believed. Derivatives along the tooth are differences of
//! the stations.

use nalgebra::Vector3;

use super::claim::{Bound, Claim, Spot};
use crate::design::{Design, Gear, Station, ToothPair};
use crate::motion::Motion;

/// Largest distance of points that should coincide, mm, and largest |n·v_rel|, |n·T²|, mm/rad.
const RESIDUAL: f64 = 1e-6;

/// Tangents shorter than this share of L are nearly cusps.
const TANGENT_SHARE: f64 = 0.04;

/// The worst of one quantity and where it is.
#[derive(Clone, Copy)]
struct Worst {
    value: f64,
    at: (f64, usize, usize),
}

impl Worst {
    /// Takes the larger of the two; NaN is larger than everything.
    fn note(&mut self, value: f64, at: (f64, usize, usize)) {
        if !self.value.is_nan() && (value.is_nan() || value > self.value) {
            *self = Worst { value, at };
        }
    }

    fn place(&self) -> Spot {
        let (phi, k, j) = self.at;
        Spot::phase(phi).on(Some((k, j)))
    }
}

/// Claims about every tooth pair of `design` under `motion`; `q_min` is the smallest Q of its contacts.
pub(super) fn claims(design: &Design, motion: &Motion, q_min: f64) -> Vec<Claim> {
    let none = Worst {
        value: f64::NEG_INFINITY,
        at: (0.0, 0, 0),
    };
    let mut point = none;
    let mut normal = none;
    let mut tangency = none;
    let mut sliding = none;
    // Quantities with a lower limit are kept negated.
    let (mut gap, mut tangent) = (none, none);
    let drive = design.settings.gear.drive();
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        for (j, tooth) in pair.teeth.iter().enumerate() {
            for (i, s) in tooth.stations.iter().enumerate() {
                let at = (s.phi, k, j);
                let bodies = [
                    (Gear::Driver, drive.state(s.phi)),
                    (Gear::Follower, motion.state(s.phi)),
                ];
                let (p, n) = (Vector3::from(s.p), Vector3::from(s.n));
                let v_rel = bodies[1].1.velocity(p) - bodies[0].1.velocity(p);
                sliding.note(n.dot(&v_rel).abs(), at);
                normal.note((n.norm() - 1.0).abs(), at);
                for (gear, state) in &bodies {
                    let (q, m, t) = s.frame(*gear);
                    point.note((state.pose.apply(q) - p).norm(), at);
                    let into = if *gear == Gear::Driver { -n } else { n };
                    normal.note((state.pose.rotation * m - into).norm(), at);
                    tangency.note(m.dot(&t).abs(), at);
                }
                let Some([p_rate, n_rate]) = rates(tooth, i) else {
                    continue;
                };
                let t2 = p_rate - bodies[1].1.velocity(p);
                tangency.note(n.dot(&t2).abs(), at);
                for (_, state) in &bodies {
                    tangent.note(-(p_rate - state.velocity(p)).norm(), at);
                }
                let omega = bodies[1].1.omega - bodies[0].1.omega;
                let g =
                    (n_rate - bodies[0].1.omega.cross(&n)).dot(&v_rel) - n.dot(&omega.cross(&t2));
                gap.note(-g, at);
            }
        }
    }
    if point.value == f64::NEG_INFINITY {
        let name = Claim::new(
            "conjugation",
            "the flanks of driver and follower fit each other",
        );
        return vec![name.undecided("the design has no contact stations")];
    }
    let mut claims = vec![
        Claim::new(
            "shared contact points",
            "driver and follower meet in one point",
        )
        .decide(point.value, "mm", Bound::AtMost(RESIDUAL))
        .at(point.place()),
        Claim::new("common normal", "the two flanks face each other exactly")
            .decide(normal.value, "", Bound::AtMost(RESIDUAL))
            .at(normal.place()),
        Claim::new(
            "no approach",
            "the flanks slide past each other, neither digging in nor parting",
        )
        .decide(sliding.value, "mm/rad", Bound::AtMost(RESIDUAL))
        .at(sliding.place()),
        Claim::new(
            "normal across the curve",
            "the contact runs along the flank, not into it",
        )
        .decide(tangency.value, "mm/rad", Bound::AtMost(RESIDUAL))
        .at(tangency.place()),
    ];
    if gap.value == f64::NEG_INFINITY {
        let name = Claim::new(
            "second-order gap",
            "the flanks part on both sides of the contact",
        );
        claims.push(name.undecided("too few stations to differentiate"));
        return claims;
    }
    claims.push(
        Claim::new(
            "second-order gap",
            "the flanks part on both sides of the contact",
        )
        .decide(-gap.value, "mm/rad²", Bound::AtLeast(0.0))
        .at(gap.place()),
    );
    claims.push(
        Claim::new(
            "no cusps",
            "the contact never stands still on a flank, which would be an undercut",
        )
        .decide(
            -tangent.value,
            "mm/rad",
            Bound::AtLeast(TANGENT_SHARE * drive.center_distance()),
        )
        .at(tangent.place()),
    );
    claims.push(kinematic_error(design, q_min, (point.value, sliding)));
    claims
}

/// What the residuals add up to at the follower: at worst the flanks are off by the point error and
/// approach at the worst rate for half a contact interval; the least favourable direction of the
/// follower answers with error/Q.
fn kinematic_error(design: &Design, q: f64, (point, sliding): (f64, Worst)) -> Claim {
    let length = design
        .sub_gear_pairs
        .iter()
        .flat_map(|p| &p.teeth)
        .map(|t| t.phi_end - t.phi_start)
        .fold(0.0, f64::max);
    let claim = Claim::new(
        "kinematic error",
        "the follower performs the motion that was asked for",
    );
    let flank = 2.0 * point + 0.5 * length * sliding.value;
    if !(q > 0.0) {
        return claim
            .undecided("without form closure an error at the flank has no bound at the follower");
    }
    let follower = flank / q;
    // 0.1 µm on the flank and one second of arc (or 5 nm along z) at the follower.
    let holds = flank <= 1e-4 && follower <= 5e-6;
    if !follower.is_finite() {
        return claim
            .undecided("the residuals are not numbers")
            .at(sliding.place());
    }
    claim
        .say(
            holds,
            format!(
                "{:.2e} µm at the flank, {:.2e} arc seconds at the follower",
                flank * 1e3,
                follower.to_degrees() * 3600.0
            ),
            "≤ 0.1 µm, ≤ 1 arc second",
        )
        .measured(flank * 1e3, "µm", 0.1)
        .at(sliding.place())
}

/// dp/dφ and dn/dφ at station `i` by central differences of sixth order; `None` within three stations
/// of an end.
fn rates(tooth: &ToothPair, i: usize) -> Option<[Vector3<f64>; 2]> {
    let s = &tooth.stations;
    if i < 3 || i + 3 >= s.len() {
        return None;
    }
    let h = (s[i + 3].phi - s[i - 3].phi) / 6.0;
    let rate = |get: &dyn Fn(&Station) -> Vector3<f64>| {
        let step = |d: usize| get(&s[i + d]) - get(&s[i - d]);
        (45.0 * step(1) - 9.0 * step(2) + step(3)) / (60.0 * h)
    };
    Some([rate(&|s| s.p.into()), rate(&|s| s.n.into())])
}
