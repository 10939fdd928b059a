//! Drums, shaft and end-effector mount of driver and follower, as recipe features.

use super::joints;
use super::recipe::{Feature, Shape};
use super::support::{BASE_BOTTOM, BRIDGE_TOP};
use crate::motion::Class;

/// x of the driver axis.
pub const DRIVER_X: &str = "-center_distance";

/// Drum, journals at both ends and the shaft end with its flat; driver frame.
pub fn driver() -> Vec<Feature> {
    let shaft_top = format!("{BRIDGE_TOP} + shaft_end");
    let upright = |z: (&str, &str), radius: &str| Shape::upright(DRIVER_X, "0", z, radius);
    vec![
        Feature::add(
            "drum",
            upright(("driver_bottom", "driver_top"), "driver_hub_radius"),
        ),
        Feature::add(
            "lower journal",
            upright(
                (&format!("{BASE_BOTTOM} + joint_play"), "driver_bottom + 1"),
                "journal_radius",
            ),
        ),
        Feature::add(
            "upper journal and shaft end",
            upright(("driver_top - 1", &shaft_top), "journal_radius"),
        ),
        Feature::cut(
            "shaft flat",
            Shape::block(
                (
                    "-center_distance + journal_radius - shaft_flat",
                    "-center_distance + journal_radius + 1",
                ),
                ("-journal_radius - 1", "journal_radius + 1"),
                (
                    &format!("{BRIDGE_TOP} + safety_gap"),
                    &format!("{shaft_top} + 1"),
                ),
            ),
        ),
    ]
}

/// Which drums the follower has, and how many holes its mount has.
#[derive(Debug, Clone, Copy)]
pub struct FollowerPlan {
    /// Class of the joint.
    pub class: Class,
    /// Teeth above O, teeth below O.
    pub sides: (bool, bool),
    /// Screw holes in the mount.
    pub mount_holes: usize,
}

/// Drums, joint parts and mount; follower frame.
pub fn follower(plan: FollowerPlan) -> Vec<Feature> {
    let mut features = Vec::new();
    if plan.class.is_spherical() {
        features.extend(joints::ball());
        features.extend(drum("upper", 1.0, "follower_top"));
        if plan.sides.1 {
            features.extend(drum("lower", -1.0, "-follower_bottom"));
        }
    } else {
        features.push(Feature::add(
            "drum",
            Shape::upright(
                "0",
                "0",
                (follower_bottom(plan.class), "follower_top"),
                "follower_hub_radius",
            ),
        ));
    }
    features.push(Feature::add(
        "mount neck",
        Shape::upright(
            "0",
            "0",
            ("follower_top - 1", "mount_bottom + mount_thickness / 2"),
            "follower_collar_radius",
        ),
    ));
    features.push(Feature::add(
        "mount flange",
        Shape::upright("0", "0", ("mount_bottom", MOUNT_TOP), "mount_radius"),
    ));
    features.extend(joints::bore(plan.class));
    features.extend((0..plan.mount_holes).map(|i| {
        let angle = i as f64 * std::f64::consts::TAU / plan.mount_holes as f64;
        Feature::cut(
            &format!("mount hole {}", i + 1),
            Shape::upright(
                &format!("mount_bolt_radius * {:.9}", angle.cos()),
                &format!("mount_bolt_radius * {:.9}", angle.sin()),
                (
                    "mount_bottom + mount_thickness / 3",
                    "mount_bottom + mount_thickness + 1",
                ),
                "mount_hole_radius",
            ),
        )
    }));
    features
}

/// Upper face of the mount.
pub const MOUNT_TOP: &str = "mount_bottom + mount_thickness";

/// Lower end of a follower that turns on a pin.
pub fn follower_bottom(class: Class) -> &'static str {
    match class {
        Class::R1 => "driver_bottom",
        _ => "follower_bottom",
    }
}

/// One drum beside the ball, from `drum_start` to |z| = `end`, with a tapered end towards the
/// socket so that its rim stays clear when it tilts.
fn drum(side: &str, direction: f64, end: &str) -> Vec<Feature> {
    let sign = if direction < 0.0 { "-" } else { "" };
    let taper = "(follower_hub_radius - follower_collar_radius)";
    let along = |from: String, length: String, r0: &str, r1: &str| Shape::Cone {
        base: ["0".into(), "0".into(), format!("{sign}({from})")],
        axis: [0.0, 0.0, direction],
        length,
        r0: r0.into(),
        r1: r1.into(),
    };
    vec![
        Feature::add(
            &format!("{side} collar"),
            along(
                "drum_start".into(),
                format!("{taper} + 0.01"),
                "follower_collar_radius",
                "follower_hub_radius",
            ),
        ),
        Feature::add(
            &format!("{side} drum"),
            along(
                format!("drum_start + {taper}"),
                format!("{end} - drum_start - {taper}"),
                "follower_hub_radius",
                "follower_hub_radius",
            ),
        ),
    ]
}
