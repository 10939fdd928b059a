//! Which values make sense, alone and together.

use super::{FLATTEST, FlankRadius, MOST_FLARE, Method, PairCount, Settings, ToothCount};
use crate::Problem;
use crate::motion::{Class, Cycle};

/// Teeth of all bands of a gear.
const MOST_TEETH: usize = 480;

/// Teeth of a band of the driver.
const MOST_ON_DRIVER: usize = 180;

/// How many times as many teeth as the follower the driver may have.
const MOST_TIMES: usize = 6;

/// Collects what is out of range.
#[derive(Default)]
struct Checker {
    problems: Vec<Problem>,
}

impl Checker {
    /// `min ≤ value ≤ max`, finite.
    fn range(&mut self, place: &str, value: f64, min: f64, max: f64) {
        if !(min..=max).contains(&value) {
            let what = format!("is {value}, allowed {min} to {max}");
            self.problems.push(Problem::new(place, what, ""));
        }
    }

    /// `min ≤ value ≤ max`.
    fn count(&mut self, place: &str, value: usize, min: usize, max: usize) {
        if !(min..=max).contains(&value) {
            let what = format!("is {value}, allowed {min} to {max}");
            self.problems.push(Problem::new(place, what, ""));
        }
    }

    /// Relation between several settings that must hold. NaN values are named by [`Self::range`].
    fn holds(&mut self, place: &str, violated: bool, what: String, hint: &str) {
        if violated {
            self.problems.push(Problem::new(place, what, hint));
        }
    }
}

impl Settings {
    /// Everything wrong with these settings for a mechanism of `class`; empty if usable.
    pub fn problems(&self, class: Class) -> Vec<Problem> {
        let mut checker = Checker::default();
        self.check_ranges(&mut checker);
        self.check_teeth(&mut checker, class);
        self.check_room(&mut checker, class);
        checker.problems.extend(self.load.problems());
        checker.problems
    }

    /// What does not go with a driver that runs through `cycle`.
    pub fn cycle_problems(&self, cycle: Cycle) -> Vec<Problem> {
        let mut checker = Checker::default();
        let gear = &self.gear;
        checker.holds(
            "gear.driver_teeth",
            !cycle.wraps() && gear.teeth_on_driver() != gear.tooth_pairs(),
            "is given for a reciprocating driver, whose follower may turn at any rate".into(),
            "leave it out; own_turn says how fast the follower turns",
        );
        checker.holds(
            "search.method",
            !cycle.wraps() && self.search.method == Method::Paper,
            "\"paper\" knows no reciprocating driver".into(),
            "search.method = \"exact\"",
        );
        checker.problems
    }

    fn check_ranges(&self, c: &mut Checker) {
        let Settings {
            gear,
            fit,
            hub,
            spokes,
            support,
            search,
            load: _,
        } = self;
        c.range(
            "gear.center_distance_mm",
            gear.center_distance_mm,
            5.0,
            500.0,
        );
        c.count("gear.teeth", gear.teeth, 3, 60);
        let (driver, follower) = (gear.teeth_on_driver(), gear.tooth_pairs());
        if let ToothCount::Fixed(teeth) = gear.driver_teeth {
            c.count("gear.driver_teeth", teeth, 3, MOST_ON_DRIVER);
        }
        if let ToothCount::Fixed(teeth) = gear.follower_teeth {
            c.count("gear.follower_teeth", teeth, 3, 60);
        }
        let times = (driver / follower.max(1)).clamp(1, MOST_TIMES);
        let [less, more] = [times, times + 1].map(|n| n.saturating_mul(follower));
        let works = match times < MOST_TIMES && more <= MOST_ON_DRIVER {
            true => format!("{less} or {more}"),
            false => less.to_string(),
        };
        c.holds(
            "gear.driver_teeth",
            driver > MOST_TIMES.saturating_mul(follower) || !driver.is_multiple_of(follower.max(1)),
            format!(
                "is {driver}, no multiple (up to {MOST_TIMES} times) of the {follower} teeth of the follower: a \
                 tooth would have to fit several that move differently"
            ),
            &format!("{works} teeth on the driver"),
        );
        c.holds(
            "gear.driver_teeth",
            driver != follower && search.method == Method::Paper,
            format!("is {driver}, the follower has {follower}: search.method \"paper\" knows equal numbers only"),
            "equal numbers, or search.method = \"exact\"",
        );
        c.range(
            "gear.tooth_thickness_mm",
            gear.tooth_thickness_mm,
            0.2,
            20.0,
        );
        if let FlankRadius::Fixed(radius) = gear.flank_radius_mm {
            c.range("gear.flank_radius_mm", radius, 0.05, FLATTEST);
        }
        c.range("gear.tip_mm", gear.tip_mm, 0.0, 10.0);
        c.range("gear.root_mm", gear.root_mm, 0.0, 20.0);
        c.range("gear.minimum_wall_mm", gear.minimum_wall_mm, 0.05, 10.0);
        c.count(
            "gear.locus_control_points",
            gear.locus_control_points,
            4,
            16,
        );
        c.count(
            "gear.normal_control_points",
            gear.normal_control_points,
            4,
            16,
        );
        c.count("gear.samples", gear.samples, 4, 1000);
        c.range("gear.closure_threshold", gear.closure_threshold, 0.0, 10.0);
        c.range("gear.norm_weight", gear.norm_weight, 0.001, 1e6);
        c.range("fit.clearance_mm", fit.clearance_mm, 0.0, 2.0);
        c.range("fit.joint_play_mm", fit.joint_play_mm, 0.0, 2.0);
        c.range("fit.piece_fit_mm", fit.piece_fit_mm, 0.0, 0.3);
        c.range("fit.elephant_foot_mm", fit.elephant_foot_mm, 0.0, 0.6);
        c.range("fit.surface_error_mm", fit.surface_error_mm, 0.0, 1.0);
        c.range("fit.safety_gap_mm", fit.safety_gap_mm, 0.0, 5.0);
        c.range("fit.max_play_deg", fit.max_play_deg, 0.01, 180.0);
        c.range("fit.max_play_mm", fit.max_play_mm, 0.01, 1000.0);
        c.range("hub.driver_radius_mm", hub.driver_radius_mm, 0.5, 400.0);
        c.range("hub.follower_radius_mm", hub.follower_radius_mm, 0.5, 400.0);
        c.range("hub.journal_radius_mm", hub.journal_radius_mm, 0.5, 200.0);
        c.range("hub.shaft_end_mm", hub.shaft_end_mm, 0.0, 500.0);
        c.range("hub.mount_radius_mm", hub.mount_radius_mm, 1.0, 400.0);
        c.range("hub.mount_thickness_mm", hub.mount_thickness_mm, 0.4, 100.0);
        c.count("hub.mount_holes", hub.mount_holes, 0, 24);
        c.range(
            "hub.mount_hole_diameter_mm",
            hub.mount_hole_diameter_mm,
            0.3,
            50.0,
        );
        c.range("spokes.thickness_mm", spokes.thickness_mm, 0.1, 20.0);
        c.range("spokes.flare_mm", spokes.flare_mm, 0.0, MOST_FLARE);
        c.range("support.plate_mm", support.plate_mm, 0.8, 100.0);
        c.range("support.ball_radius_mm", support.ball_radius_mm, 1.0, 200.0);
        c.range("support.neck_radius_mm", support.neck_radius_mm, 0.5, 200.0);
        c.range("support.socket_wall_mm", support.socket_wall_mm, 0.4, 50.0);
        c.range("support.pin_radius_mm", support.pin_radius_mm, 0.5, 200.0);
        c.range(
            "support.screw_hole_diameter_mm",
            support.screw_hole_diameter_mm,
            1.6,
            5.0,
        );
        c.range("search.effort", search.effort, 0.001, 1000.0);
        c.range(
            "gear.least_contact_ratio",
            gear.least_contact_ratio,
            1.01,
            3.0,
        );
        c.range("search.least_hold", search.least_hold, 0.0, 1.0);
        c.range("search.time_limit_s", search.time_limit_s, 0.0, 1e7);
    }

    fn check_teeth(&self, c: &mut Checker, class: Class) {
        let (gear, fit) = (&self.gear, &self.fit);
        let ratio = gear.contact_ratio;
        c.holds(
            "gear.contact_ratio",
            !(ratio > 1.0 && ratio <= 3.0),
            format!("is {ratio}, allowed more than 1 up to 3"),
            "above 1 the next tooth takes over before the last one lets go",
        );
        if let PairCount::Fixed(k) = gear.sub_gear_pairs {
            let least = class.dof() + 1;
            c.holds(
                "gear.sub_gear_pairs",
                !(least..=12).contains(&k),
                format!("is {k}, allowed {least} to 12 or \"auto\" in class {class}"),
                "N degrees of freedom need at least N+1 contacts",
            );
            c.holds(
                "gear.sub_gear_pairs",
                k * gear.teeth_on_driver() > MOST_TEETH,
                format!(
                    "is {k}, with {} teeth in a band more than {MOST_TEETH} teeth on a gear",
                    gear.teeth_on_driver()
                ),
                "fewer bands or fewer teeth in each; bodies of so many teeth take minutes to build",
            );
        }
        let thickness = gear.tooth_thickness_mm;
        c.holds(
            "gear.tip_mm",
            gear.tip_mm > gear.bead_radius(),
            format!(
                "is {}, more than the radius of the bead: half of tooth_thickness_mm = {thickness}, or \
                 flank_radius_mm where that is less",
                gear.tip_mm
            ),
            "a lower tip, or thicker teeth",
        );
        c.holds(
            "gear.minimum_wall_mm",
            gear.minimum_wall_mm > thickness - fit.clearance_mm,
            format!(
                "is {}, more than a tooth has: tooth_thickness_mm = {thickness} less clearance_mm = {}",
                gear.minimum_wall_mm, fit.clearance_mm
            ),
            "make the teeth thicker",
        );
        c.holds(
            "spokes.thickness_mm",
            self.spokes.thickness_mm > thickness,
            format!(
                "is {}, more than gear.tooth_thickness_mm = {thickness}",
                self.spokes.thickness_mm
            ),
            "ribs thicker than their teeth would touch the other gear",
        );
        c.holds(
            "spokes.thickness_mm",
            self.spokes.thickness_mm < gear.minimum_wall_mm,
            format!(
                "is {}, less than gear.minimum_wall_mm = {}",
                self.spokes.thickness_mm, gear.minimum_wall_mm
            ),
            "",
        );
        c.holds(
            "gear.root_mm",
            gear.root_mm > 0.5 * gear.center_distance_mm,
            format!(
                "is {}, more than half of center_distance_mm = {}",
                gear.root_mm, gear.center_distance_mm
            ),
            "the root would reach beyond the axis",
        );
        let around = gear.drive().follower_pitch_radius(1.0) * std::f64::consts::TAU;
        let pitch = around / gear.tooth_pairs().max(1) as f64;
        let needed = 2.0 * (thickness + fit.clearance_mm);
        c.holds(
            "gear.teeth",
            pitch < needed,
            format!(
                "{} teeth at center_distance_mm = {} are {pitch:.2} mm apart, two teeth with their gaps need {needed:.2} mm",
                gear.tooth_pairs(),
                gear.center_distance_mm
            ),
            "fewer or thinner teeth, or a larger centre distance",
        );
    }

    fn check_room(&self, c: &mut Checker, class: Class) {
        let (gear, fit, hub, support) = (&self.gear, &self.fit, &self.hub, &self.support);
        let distance = gear.center_distance_mm;
        let hubs = hub.driver_radius_mm + hub.follower_radius_mm + fit.safety_gap_mm;
        c.holds(
            "hub.driver_radius_mm",
            hubs >= distance,
            format!(
                "hubs of {} and {} mm with fit.safety_gap_mm do not fit between axes gear.center_distance_mm = {distance} apart",
                hub.driver_radius_mm, hub.follower_radius_mm
            ),
            "smaller hubs or a larger centre distance",
        );
        c.holds(
            "hub.journal_radius_mm",
            hub.journal_radius_mm > hub.driver_radius_mm,
            format!(
                "is {}, more than driver_radius_mm = {}",
                hub.journal_radius_mm, hub.driver_radius_mm
            ),
            "the hub's shoulder runs on the bearing",
        );
        c.holds(
            "hub.mount_hole_diameter_mm",
            hub.mount_holes > 0 && hub.mount_hole_diameter_mm + 2.0 * gear.minimum_wall_mm > hub.mount_radius_mm,
            format!(
                "is {}, with walls of gear.minimum_wall_mm more than mount_radius_mm = {} has room for",
                hub.mount_hole_diameter_mm, hub.mount_radius_mm
            ),
            "smaller holes or a larger mount",
        );
        if !class.is_spherical() {
            let bore = support.pin_radius_mm + fit.joint_play_mm + gear.minimum_wall_mm;
            c.holds(
                "support.pin_radius_mm",
                bore > hub.follower_radius_mm,
                format!(
                    "is {}, with fit.joint_play_mm and gear.minimum_wall_mm {bore:.2}, more than hub.follower_radius_mm = {}",
                    support.pin_radius_mm, hub.follower_radius_mm
                ),
                "a thinner pin or a larger follower hub",
            );
            // The pin's upper end has 0.65 of its radius, the thread 0.375 of the hole's diameter.
            let (end, thread) = (
                0.65 * support.pin_radius_mm,
                0.375 * support.screw_hole_diameter_mm,
            );
            c.holds(
                "support.pin_radius_mm",
                class == Class::R1 && end < thread + 0.4,
                format!(
                    "is {}: around the thread of the cap's screw (support.screw_hole_diameter_mm = {}) {:.2} mm are left, at least 0.4 mm are needed",
                    support.pin_radius_mm,
                    support.screw_hole_diameter_mm,
                    end - thread
                ),
                "a thicker pin or a smaller screw",
            );
            return;
        }
        let ball = support.ball_radius_mm;
        c.holds(
            "support.neck_radius_mm",
            support.neck_radius_mm + fit.safety_gap_mm >= ball,
            format!(
                "is {}, with fit.safety_gap_mm not less than ball_radius_mm = {ball}",
                support.neck_radius_mm
            ),
            "the socket holds the ball around the neck",
        );
        let socket = ball + fit.joint_play_mm + support.socket_wall_mm + hub.journal_radius_mm;
        c.holds(
            "support.ball_radius_mm",
            socket + fit.safety_gap_mm >= distance,
            format!(
                "ball, socket wall and the driver's journal need {socket:.2} mm, gear.center_distance_mm is {distance}"
            ),
            "a smaller ball or a larger centre distance",
        );
    }
}
