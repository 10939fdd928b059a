//! Every setting of a design with its documented default; the `[gear]`, `[fit]`, `[hub]`,
//! `[spokes]`, `[support]`, `[search]`, `[load]` tables of a motion file are read straight into these.

mod check;
mod profile;

use serde::{Deserialize, Serialize};

use crate::motion::Drive;

pub use profile::{Allowances, Profile};

/// All settings of a design.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Tooth and band geometry.
    pub gear: Gear,
    /// Gaps between moving parts.
    pub fit: Fit,
    /// Hubs, shafts and the end-effector mount.
    pub hub: Hub,
    /// Ribs that carry the teeth.
    pub spokes: Spokes,
    /// Frame and joints.
    pub support: Support,
    /// Optimiser.
    pub search: Search,
    /// What the mechanism has to carry.
    pub load: crate::load::Load,
}

/// Number of sub-gear pairs K: from N+1 upwards, to N+4 at the most, or fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"auto\" or a whole number")]
pub enum PairCount {
    /// A fixed K ≥ N+1.
    Fixed(usize),
    /// `"auto"`: from N+1 upwards until the hold is good ([`Search::least_hold`]).
    Auto(Auto),
}

/// Teeth per band of one of the gears: as many as both have, or a number of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"auto\" or a whole number")]
pub enum ToothCount {
    /// A number of its own.
    Fixed(usize),
    /// `"auto"`: [`Gear::teeth`].
    Auto(Auto),
}

impl ToothCount {
    /// The number, `both` being that of both gears.
    pub fn or(self, both: usize) -> usize {
        match self {
            ToothCount::Fixed(own) => own,
            ToothCount::Auto(_) => both,
        }
    }
}

/// Largest flank radius, mm.
pub const FLATTEST: f64 = 25.0;

/// Most that a rib may thicken on one side ([`Spokes::flare_mm`]), mm.
pub const MOST_FLARE: f64 = 20.0;

/// Radius of the flanks: as large as the teeth allow, or fixed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"auto\" or a number")]
pub enum FlankRadius {
    /// A fixed radius, mm.
    Fixed(f64),
    /// `"auto"`: as large as contact allows along every tooth, if the proof agrees; else a round bead.
    Auto(Auto),
}

/// The word `auto`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Auto {
    /// `"auto"`.
    #[serde(rename = "auto")]
    Auto,
}

impl Settings {
    /// Sizes that were not `given` (by section and field) follow the profile, and a tooth that is thinner
    /// than they allow for; a contact ratio that was given is kept.
    pub(crate) fn follow(&mut self, given: impl Fn(&str, &str) -> bool) {
        self.follow_profile(&given);
        let gear = &mut self.gear;
        if given("gear", "contact_ratio") && !given("gear", "least_contact_ratio") {
            gear.least_contact_ratio = gear.least_contact_ratio.max(gear.contact_ratio);
        }
        let at_most = |section: &str, key: &str, size: &mut f64, most: f64| {
            if *size > most && most > 0.0 && !given(section, key) {
                *size = most;
            }
        };
        let bead = gear.bead_radius();
        at_most("gear", "tip_mm", &mut gear.tip_mm, bead);
        at_most("gear", "root_mm", &mut gear.root_mm, bead);
        let rib = &mut self.spokes.thickness_mm;
        at_most("spokes", "thickness_mm", rib, gear.tooth_thickness_mm);
    }
}

/// Tooth and band geometry (defaults: the publication's constants).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gear {
    /// L, distance from O to the driver axis, mm. Default 25.
    pub center_distance_mm: f64,
    /// J, teeth per band on driver and follower. Default 10.
    pub teeth: usize,
    /// J₁, teeth per band on the driver: as many as the follower has, or a multiple. The driver then makes
    /// one turn while the follower makes as many. Default "auto": [`Gear::teeth`].
    pub driver_teeth: ToothCount,
    /// J₂, teeth per band on the follower. Default "auto": [`Gear::teeth`].
    pub follower_teeth: ToothCount,
    /// c, contact ratio. Default 1.44.
    pub contact_ratio: f64,
    /// Contact ratio that is tried where no gear is found at `contact_ratio`, or only one that holds
    /// weakly: shorter teeth fold less and leave more room. Default 1.1; the contact ratio itself where
    /// that is given.
    pub least_contact_ratio: f64,
    /// K, number of sub-gear pairs. Default "auto".
    pub sub_gear_pairs: PairCount,
    /// Tooth thickness across the bead, along the contact normal, mm. Default 1.8.
    pub tooth_thickness_mm: f64,
    /// Radius of the convex flank across the tooth, mm, at most 25: the flatter, the more it carries.
    /// Default "auto".
    pub flank_radius_mm: FlankRadius,
    /// Height of the tooth beyond the contact point, mm; at most the bead radius. Default 0.9, or the bead
    /// radius if that is smaller.
    pub tip_mm: f64,
    /// Depth of the fixed cross section behind the contact point, towards the hub, mm. Default 0.6, or
    /// the bead radius if that is smaller: the rib does the rest.
    pub root_mm: f64,
    /// Smallest wall anywhere, mm. Default 0.8.
    pub minimum_wall_mm: f64,
    /// l, control points of the published locus spline. Default 4.
    pub locus_control_points: usize,
    /// ρ, control points of the published normal-angle spline. Default 4.
    pub normal_control_points: usize,
    /// R, samples of Q per subinterval. Default 36.
    pub samples: usize,
    /// ε, threshold of the form-closure indicator. Default 0.02.
    pub closure_threshold: f64,
    /// ω₁, weight of E_norm. Default 120.
    pub norm_weight: f64,
}

impl Default for Gear {
    fn default() -> Self {
        Gear {
            center_distance_mm: 25.0,
            teeth: 10,
            driver_teeth: ToothCount::Auto(Auto::Auto),
            follower_teeth: ToothCount::Auto(Auto::Auto),
            contact_ratio: 1.44,
            least_contact_ratio: 1.1,
            sub_gear_pairs: PairCount::Auto(Auto::Auto),
            tooth_thickness_mm: 1.8,
            flank_radius_mm: FlankRadius::Auto(Auto::Auto),
            tip_mm: 0.9,
            root_mm: 0.6,
            minimum_wall_mm: 0.8,
            locus_control_points: 4,
            normal_control_points: 4,
            samples: 36,
            closure_threshold: 0.02,
            norm_weight: 120.0,
        }
    }
}

impl Gear {
    /// J₂, tooth pairs of a band that meet in one period of the motion: the follower's teeth.
    pub fn tooth_pairs(&self) -> usize {
        self.follower_teeth.or(self.teeth)
    }

    /// J₁, teeth of a band on the driver.
    pub fn teeth_on_driver(&self) -> usize {
        self.driver_teeth.or(self.teeth)
    }

    /// How the driver turns.
    pub fn drive(&self) -> Drive {
        let copies = self.teeth_on_driver() / self.tooth_pairs().max(1);
        Drive::new(self.center_distance_mm, copies)
    }

    /// Radius of the round bead that fits into the section, mm: half the thickness, or the flanks' radius
    /// where that is smaller. The search takes the teeth for such beads.
    pub fn bead_radius(&self) -> f64 {
        let half = 0.5 * self.tooth_thickness_mm;
        match self.flank_radius_mm {
            FlankRadius::Fixed(radius) => radius.min(half),
            FlankRadius::Auto(_) => half,
        }
    }
}

/// Gaps between moving parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fit {
    /// How the parts are made: sets the gaps below, and in `[load]` the errors to expect, where they are
    /// not given. Default "any".
    pub profile: Profile,
    /// Flank-to-flank gap at the contact, mm; half is taken off each tooth. Default 0.1.
    pub clearance_mm: f64,
    /// Radial gap of pins, journals and the ball, mm. Default 0.15.
    pub joint_play_mm: f64,
    /// Gap between printed pieces that are screwed together, mm. Default 0.1.
    pub piece_fit_mm: f64,
    /// How far the first layers of the pieces in `print/` are drawn in, because a filament printer presses
    /// them wide, mm; as high as it is wide. Default 0.
    pub elephant_foot_mm: f64,
    /// How far a made surface may lie outside its place, mm: so much is added to all bodies where they must
    /// stay apart. Default 0.03.
    pub surface_error_mm: f64,
    /// Smallest gap wanted between parts that must never touch, mm. Default 0.3.
    pub safety_gap_mm: f64,
    /// Largest angle by which the follower may be loose with the motor held, deg. Default 1.5.
    pub max_play_deg: f64,
    /// The same as a displacement of the load point, mm. Default 1.5.
    pub max_play_mm: f64,
}

impl Default for Fit {
    fn default() -> Self {
        let profile = Profile::default();
        let needs = profile.allowances();
        Fit {
            profile,
            clearance_mm: needs.clearance_mm,
            joint_play_mm: needs.joint_play_mm,
            piece_fit_mm: needs.piece_fit_mm,
            elephant_foot_mm: needs.elephant_foot_mm,
            surface_error_mm: needs.surface_error_mm,
            safety_gap_mm: 0.3,
            max_play_deg: 1.5,
            max_play_mm: 1.5,
        }
    }
}

/// Hubs, shafts and the end-effector mount.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hub {
    /// Smallest driver hub radius, mm; grows to what the follower's teeth leave free. Default 5.
    pub driver_radius_mm: f64,
    /// Smallest follower hub radius, mm; grows to what the driver's teeth leave free. Default 4.2;
    /// around a pin at least 1.5 mm of wall.
    pub follower_radius_mm: f64,
    /// Radius of the driver's shaft journals, mm. Default 4.
    pub journal_radius_mm: f64,
    /// Length of the driver's shaft end beyond the upper bearing, with a flat for a crank or coupling, mm. Default 12.
    pub shaft_end_mm: f64,
    /// Radius of the end-effector mount's flange, mm. Default 8.
    pub mount_radius_mm: f64,
    /// Thickness of the end-effector mount's flange, mm. Default 3.
    pub mount_thickness_mm: f64,
    /// Screw holes in the mount's bolt circle. Default 3.
    pub mount_holes: usize,
    /// Diameter of those holes, mm. Default 2.5 (tapped M3).
    pub mount_hole_diameter_mm: f64,
}

impl Default for Hub {
    fn default() -> Self {
        Hub {
            driver_radius_mm: 5.0,
            follower_radius_mm: 4.2,
            journal_radius_mm: 4.0,
            shaft_end_mm: 12.0,
            mount_radius_mm: 8.0,
            mount_thickness_mm: 3.0,
            mount_holes: 3,
            mount_hole_diameter_mm: 2.5,
        }
    }
}

/// Ribs that carry the teeth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Spokes {
    /// Thickness of the rib from tooth root to hub, mm; at most the tooth thickness. Default 1.4, or
    /// the thickness of a thinner tooth.
    pub thickness_mm: f64,
    /// Most by which a rib thickens on either side from the tooth to the hub, mm: less where it would be in
    /// the way. Default 1.5; 0 keeps ribs as thick everywhere.
    pub flare_mm: f64,
}

impl Default for Spokes {
    fn default() -> Self {
        Spokes {
            thickness_mm: 1.4,
            flare_mm: 1.5,
        }
    }
}

/// Frame and joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Support {
    /// Thickness of the base plate, mm. Default 6.
    pub plate_mm: f64,
    /// Radius of the follower's ball (3R, 3R1T), mm. Default 5.5.
    pub ball_radius_mm: f64,
    /// Radius of the follower's necks beside the ball, mm. Default 3.
    pub neck_radius_mm: f64,
    /// Wall of the socket around the ball, mm. Default 2.
    pub socket_wall_mm: f64,
    /// Radius of the follower's pin (1R, 1R1T), mm. Default 3.
    pub pin_radius_mm: f64,
    /// Screw size of the frame, clearance-hole diameter, mm. Default 3.4 (M3).
    pub screw_hole_diameter_mm: f64,
}

impl Default for Support {
    fn default() -> Self {
        Support {
            plate_mm: 6.0,
            ball_radius_mm: 5.5,
            neck_radius_mm: 3.0,
            socket_wall_mm: 2.0,
            pin_radius_mm: 3.0,
            screw_hole_diameter_mm: 3.4,
        }
    }
}

/// How tooth pairs are parameterised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Normal first: conjugation exact by construction.
    #[default]
    Exact,
    /// The published B-spline formulation with penalties, solved by SLSQP.
    Paper,
}

/// Optimiser settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Search {
    /// Seed of all random streams. Default 1.
    pub seed: u64,
    /// Work relative to the default: candidates, generations, polish. Default 1.
    pub effort: f64,
    /// Stop after this long and keep the best, s; 0 = no limit. Default 0.
    pub time_limit_s: f64,
    /// Parameterisation. Default "exact".
    pub method: Method,
    /// Min Q* below which one more sub-gear pair is tried (where their number is "auto") and then the
    /// least contact ratio. Followers of designs below 0.14 were seen to jump out of their teeth under a
    /// load; from 0.2 on they follow, the more closely the more there is. Default 0.3; 0 takes the first
    /// number that closes the follower at all.
    pub least_hold: f64,
}

impl Default for Search {
    fn default() -> Self {
        Search {
            seed: 1,
            effort: 1.0,
            time_limit_s: 0.0,
            method: Method::Exact,
            least_hold: 0.3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_given_follows_a_thin_tooth() {
        let mut thin = Settings::default();
        thin.gear.tooth_thickness_mm = 1.0;
        let given = thin.clone();
        thin.follow(|_, key| key == "tooth_thickness_mm");
        let gear = &thin.gear;
        assert_eq!(
            (gear.bead_radius(), gear.tip_mm, gear.root_mm),
            (0.5, 0.5, 0.5)
        );
        assert_eq!(thin.spokes.thickness_mm, 1.0);
        let mut all = given.clone();
        all.follow(|_, _| true);
        assert_eq!(all, given);
    }
}
