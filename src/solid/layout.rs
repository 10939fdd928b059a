//! The recipe of a design: named parameters with their ranges, and the features of every body.

use super::hub::{self, FollowerPlan};
use super::measure::{self, Measures};
use super::recipe::{Body, Feature, Parameter, Recipe};
use super::{joints, pieces, support};
use crate::Result;
use crate::design::{Design, Gear};
use crate::envelope;
use crate::motion::{Class, Motion};

/// Parametric solids of everything that is not a tooth or a rib.
///
/// # Errors
/// [`crate::Error::Infeasible`] when the motion leaves no room for the joint.
pub fn recipe(design: &Design, motion: &Motion) -> Result<Recipe> {
    let measures = Measures::of(design, motion);
    if let Some(joint) = &measures.envelope.ball_joint
        && joint.ring_half_height < 2.0
    {
        return Err(crate::Error::Infeasible {
            reason: format!(
                "the follower tilts by {:.1}°, which leaves {:.1} mm of socket to hold its ball",
                measures.envelope.reach.tilt.to_degrees(),
                2.0 * joint.ring_half_height
            ),
            place: "follower-support joint".into(),
            hint: "smaller tilt, larger support.ball_radius_mm or smaller support.neck_radius_mm"
                .into(),
        });
    }
    Ok(Recipe {
        parameters: parameters(design, &measures),
        bodies: bodies(design.class, &measures, design.settings.hub.mount_holes),
    })
}

fn bodies(class: Class, measures: &Measures, mount_holes: usize) -> Vec<Body> {
    let plan = FollowerPlan {
        class,
        sides: measures.sides,
        mount_holes,
    };
    let mut follower = hub::follower(plan);
    if class.is_spherical() && measures.sides.1 {
        follower.push(joints::lower_neck());
    }
    let mut bodies = vec![
        body("driver", Some(Gear::Driver), hub::driver()),
        body("follower", Some(Gear::Follower), follower),
    ];

    let mut frame = support::base();
    frame.extend(support::bridge());
    frame.extend(support::stand(class));
    frame.push(support::upper_bearing());
    frame.push(support::lower_bearing());
    if class == Class::R3 {
        frame.push(joints::socket_hollow());
    }
    frame.extend(joints::pin(class));
    if class == Class::R1 {
        frame.push(joints::pin_cap());
        frame.push(joints::pin_end());
    }
    let mut support = body("support", None, frame);
    support.pieces = pieces::support(class);
    bodies.push(support);

    if class == Class::R3T1 {
        let mut features = support::slider();
        features.push(joints::socket_hollow());
        features.push(support::guide());
        let mut slider = body("slider", None, features);
        slider.pieces = pieces::slider();
        bodies.push(slider);
    }
    bodies
}

fn body(name: &str, teeth: Option<Gear>, features: Vec<Feature>) -> Body {
    Body {
        name: name.into(),
        teeth,
        features,
        pieces: Vec::new(),
    }
}

/// Radius at which the ribs end, inside the smallest hub and outside a bore, mm.
pub fn rib_foot(design: &Design, gear: Gear) -> f64 {
    let settings = &design.settings;
    match gear {
        Gear::Driver => settings.hub.driver_radius_mm - 1.0,
        Gear::Follower if design.class.is_spherical() => settings.hub.follower_radius_mm - 1.0,
        Gear::Follower => {
            let bore = measure::pin_radius(settings) + settings.fit.joint_play_mm;
            0.5 * (bore + settings.hub.follower_radius_mm)
        }
    }
}

/// Parameter list under construction; every entry is a row of the user's table.
struct Table {
    rows: Vec<Parameter>,
    group: &'static str,
}

impl Table {
    /// A value that the maker may turn between `min` and `max`.
    fn free(&mut self, name: &str, (min, value, max): (f64, f64, f64), description: &str) {
        let round = |x: f64| (x * 1e4).round() / 1e4;
        self.rows.push(Parameter {
            name: name.into(),
            value: round(value),
            min: round(min),
            max: round(max),
            group: self.group.into(),
            description: description.into(),
        });
    }

    /// A value that teeth or motion dictate.
    fn fixed(&mut self, name: &str, value: f64, description: &str) {
        self.free(name, (value, value, value), description);
    }

    /// A value between its half and its double.
    fn scaled(&mut self, name: &str, value: f64, description: &str) {
        self.free(name, (0.5 * value, value, 2.0 * value), description);
    }
}

fn parameters(design: &Design, m: &Measures) -> Vec<Parameter> {
    let settings = &design.settings;
    let (gear, fit, hubs, frame) = (
        &settings.gear,
        &settings.fit,
        &settings.hub,
        &settings.support,
    );
    let class = design.class;
    let scale = gear.center_distance_mm / 25.0;
    let pin = measure::pin_radius(settings);
    let wall = gear.minimum_wall_mm;
    let tap = 0.375 * frame.screw_hole_diameter_mm;
    let driver_bottom = m.base_top + fit.joint_play_mm;
    let mut t = Table {
        rows: Vec::new(),
        group: "Fit",
    };
    t.fixed(
        "center_distance",
        gear.center_distance_mm,
        "L, distance from O to the driver axis",
    );
    t.free(
        "joint_play",
        (0.02, fit.joint_play_mm, 0.5),
        "radial gap of journals, pin and ball, axial gap of the driver",
    );
    t.free(
        "safety_gap",
        (0.1, fit.safety_gap_mm, 1.0),
        "gap between parts that never touch",
    );
    t.free(
        "piece_fit",
        (0.0, fit.piece_fit_mm, 0.3),
        "gap between printed pieces that are screwed together",
    );

    t.group = "Hub";
    t.free(
        "driver_hub_radius",
        (m.driver_hub.0, m.driver_hub.1, m.driver_hub.1),
        "radius of the driver's drum",
    );
    t.free(
        "driver_bottom",
        (driver_bottom - 20.0, driver_bottom, driver_bottom),
        "lower end of the driver's drum; the base plate lies below",
    );
    t.free(
        "driver_top",
        (m.driver_top, m.driver_top, m.driver_top + m.driver_top_free),
        "upper end of the driver's drum; the bridge lies above",
    );
    t.free(
        "journal_radius",
        (2.0, hubs.journal_radius_mm, hubs.journal_radius_mm),
        "radius of the driver's journals and shaft end",
    );
    t.scaled(
        "shaft_end",
        hubs.shaft_end_mm,
        "length of the shaft end above the bridge, for a crank or coupling",
    );
    t.free(
        "shaft_flat",
        (
            0.0001,
            0.25 * hubs.journal_radius_mm,
            0.5 * hubs.journal_radius_mm,
        ),
        "depth of the flat on the shaft end",
    );
    t.free(
        "follower_hub_radius",
        (
            m.follower_hub.0 + 0.01,
            m.follower_hub.1.max(m.follower_hub.0 + 0.01),
            m.follower_hub.1.max(m.follower_hub.0 + 0.01),
        ),
        "radius of the follower's drums",
    );
    t.fixed(
        "follower_collar_radius",
        m.follower_hub.0,
        "radius of the drums next to the socket and of the mount's neck",
    );
    if class != Class::R1 {
        t.fixed(
            "follower_bottom",
            m.follower_ends.0,
            "lower end of the follower's drum",
        );
    }
    t.fixed(
        "follower_top",
        m.follower_ends.1,
        "upper end of the follower's drum",
    );
    t.free(
        "mount_bottom",
        (m.mount_bottom, m.mount_bottom, m.mount_bottom),
        "lower face of the end-effector mount",
    );
    t.free(
        "mount_radius",
        (m.follower_hub.0, m.mount_radius, m.mount_radius),
        "radius of the end-effector mount",
    );
    t.free(
        "mount_thickness",
        (1.0, hubs.mount_thickness_mm, hubs.mount_thickness_mm),
        "thickness of the end-effector mount",
    );
    let pocket = match class {
        Class::R1 => pin + fit.safety_gap_mm,
        _ => 0.0,
    };
    let hole = 0.5 * hubs.mount_hole_diameter_mm;
    let bolt = match class {
        Class::R1 => 0.5 * (pocket + m.mount_radius),
        _ => m.mount_radius - hole - wall.max(1.2),
    };
    t.free(
        "mount_bolt_radius",
        (pocket + hole + wall, bolt, m.mount_radius - hole - wall),
        "radius of the mount's bolt circle",
    );
    t.free(
        "mount_hole_radius",
        (0.4, hole, hole + 0.5),
        "radius of the mount's screw holes",
    );

    t.group = "Support";
    t.free(
        "plate_thickness",
        (4.0, frame.plate_mm, 20.0),
        "thickness of the base plate",
    );
    t.scaled(
        "base_half_width",
        18.0 * scale,
        "half width of the base plate",
    );
    let tower_front = -gear.center_distance_mm - m.driver_reach - fit.safety_gap_mm - 0.7;
    t.free(
        "tower_front",
        (tower_front - 20.0, tower_front, tower_front),
        "x of the driver tower's face towards the driver",
    );
    t.free(
        "tower_thickness",
        (6.0, 8.0_f64.max(8.0 * scale), 20.0 * scale.max(1.0)),
        "thickness of the driver tower",
    );
    t.free(
        "tower_half_width",
        (8.0, 9.0_f64.max(9.0 * scale), 18.0 * scale.max(1.0)),
        "half width of the driver tower",
    );
    let eye = measure::eye_radius(design);
    let thickest_bridge = match m.eye_free > eye {
        true => measure::THICKEST_BRIDGE,
        false => measure::BRIDGE_THICKNESS,
    };
    t.free(
        "bridge_thickness",
        (4.0, measure::BRIDGE_THICKNESS, thickest_bridge),
        "thickness of the bridge, length of the upper bearing",
    );
    t.free(
        "bearing_wall",
        (1.5, measure::EYE_WALL, measure::EYE_WALL + m.eye_free - eye),
        "wall around the upper bearing",
    );
    t.free(
        "screw_hole_radius",
        (0.8, 0.5 * frame.screw_hole_diameter_mm, 2.5),
        "clearance-hole radius of the frame's screws",
    );
    t.free(
        "screw_tap_radius",
        (0.6, tap, 2.2),
        "hole radius that the screws cut their thread into",
    );

    t.group = "Joint";
    let lift = m.envelope.reach.lift;
    if let Some(joint) = &m.envelope.ball_joint {
        let stand = 8.0_f64.max(8.0 * scale);
        t.free(
            "ball_radius",
            (
                0.95 * joint.ball_radius,
                joint.ball_radius,
                joint.ball_radius,
            ),
            "radius of the follower's ball",
        );
        t.free(
            "neck_radius",
            (
                0.6 * joint.neck_radius,
                joint.neck_radius,
                joint.neck_radius,
            ),
            "radius of the necks beside the ball",
        );
        t.free(
            "socket_wall",
            (1.5, frame.socket_wall_mm, frame.socket_wall_mm),
            "wall of the socket ring",
        );
        t.free(
            "ring_half_height",
            (
                0.8 * joint.ring_half_height,
                joint.ring_half_height,
                joint.ring_half_height,
            ),
            "half height of the socket ring",
        );
        t.free(
            "arm_half_height",
            (
                0.6 * joint.arm_half_height,
                joint.arm_half_height,
                joint.arm_half_height,
            ),
            "half height of the arm that holds the socket",
        );
        t.free(
            "arm_half_width",
            (
                0.5 * joint.arm_half_width,
                joint.arm_half_width,
                joint.arm_half_width,
            ),
            "half width of that arm",
        );
        t.fixed(
            "drum_start",
            joint.drum_start,
            "distance of the follower's drums from O",
        );
        t.free(
            "lug_half_height",
            (joint.lug_half_height, m.lug_half_height, m.lug_half_height),
            "half height of the lugs for the socket's screws",
        );
        t.fixed(
            "lug_length",
            envelope::LUG_LENGTH,
            "length of those lugs beyond the ring",
        );
        t.fixed(
            "lug_half_thickness",
            envelope::LUG_HALF_THICKNESS,
            "half thickness of those lugs",
        );
        t.free(
            "stand_front",
            (m.follower_reach, m.follower_reach, m.follower_reach + 20.0),
            "x of the follower stand's face towards the follower",
        );
        t.free(
            "stand_thickness",
            (5.0, stand, 2.0 * stand),
            "thickness of the follower tower or rail",
        );
        t.fixed(
            "stand_half_width",
            11.0_f64.max(11.0 * scale),
            "half width of the follower stand",
        );
        t.fixed(
            "foot_thickness",
            measure::FOOT_THICKNESS,
            "thickness of the stand's foot",
        );
        let mut depth = stand + 14.0;
        if class == Class::R3T1 {
            t.fixed(
                "carriage_half_height",
                measure::CARRIAGE_SHARE * gear.center_distance_mm,
                "half height of the slider's carriage",
            );
            t.fixed("guide_wall", 3.0, "wall around the slider's guide");
            t.fixed(
                "rail_half_width",
                7.0_f64.max(7.0 * scale),
                "half width of the slider's rail",
            );
            t.fixed("lift_max", lift.1, "highest joint centre");
            depth += 6.0 + 2.0 * fit.joint_play_mm;
        }
        t.free(
            "base_end",
            (
                m.follower_reach + depth,
                m.follower_reach + depth,
                m.follower_reach + depth + 40.0,
            ),
            "end of the base plate on the follower's side",
        );
    } else {
        t.fixed("pin_radius", pin, "radius of the follower's pin");
        let flange = pin + 8.0;
        t.fixed("pin_flange_radius", flange, "radius of the pin's flange");
        if class == Class::R1 {
            t.fixed(
                "pin_neck_radius",
                0.65 * pin,
                "radius of the pin's upper end",
            );
            t.fixed(
                "web_thickness",
                3.0,
                "thickness of the follower's web that the cap holds",
            );
            t.fixed("cap_thickness", 2.0, "thickness of the cap");
            t.fixed(
                "cap_pocket",
                5.0,
                "depth of the pocket for the cap and its screw",
            );
        } else {
            t.fixed("lift_min", lift.0, "lowest follower position");
            t.fixed("vent_radius", 0.8, "radius of the vent above the pin");
        }
        t.free(
            "base_end",
            (flange + 3.0, flange + 3.0, flange + 60.0),
            "end of the base plate on the follower's side",
        );
    }
    t.rows
}
