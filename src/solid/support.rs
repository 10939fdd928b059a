//! The frame, as recipe features in Σ: base plate, driver tower with bridge, follower stand or guide.

use super::hub::DRIVER_X;
use super::joints;
use super::recipe::{Feature, Shape};
use crate::motion::Class;

/// Upper and lower face of the base plate.
pub const BASE_TOP: &str = "(driver_bottom - joint_play)";
/// Lower face of the base plate.
pub const BASE_BOTTOM: &str = "(driver_bottom - joint_play - plate_thickness)";
/// Lower face of the bridge, which is the top of the driver tower.
pub const BRIDGE_BOTTOM: &str = "(driver_top + joint_play)";
/// Upper face of the bridge.
pub const BRIDGE_TOP: &str = "(driver_top + joint_play + bridge_thickness)";
/// Half width of the bridge's arm: radius of its bearing eye.
pub const EYE: &str = "(journal_radius + joint_play + bearing_wall)";
/// Face of the driver tower away from the driver.
pub const TOWER_BACK: &str = "(tower_front - tower_thickness)";
/// Middle of the driver tower.
pub const TOWER_X: &str = "(tower_front - tower_thickness / 2)";
/// Screws of the bridge.
pub const BRIDGE_SCREW_Y: &str = "(tower_half_width - 3.5)";
/// Upper face of the follower stand's foot.
pub const FOOT_TOP: &str = "(driver_bottom - joint_play + foot_thickness)";
/// Where the slider's guide begins behind the carriage's wall.
pub const RAIL_FRONT: &str = "(stand_front + guide_wall + joint_play)";

/// Base plate and driver tower.
pub fn base() -> Vec<Feature> {
    vec![
        Feature::add(
            "base plate",
            Shape::block(
                (TOWER_BACK, "base_end"),
                ("-base_half_width", "base_half_width"),
                (BASE_BOTTOM, BASE_TOP),
            ),
        ),
        Feature::add(
            "driver tower",
            Shape::block(
                (TOWER_BACK, "tower_front"),
                ("-tower_half_width", "tower_half_width"),
                (&format!("{BASE_TOP} - 1"), BRIDGE_BOTTOM),
            ),
        ),
    ]
}

/// The bridge from the driver tower to the upper journal, without its bore.
pub fn bridge() -> Vec<Feature> {
    vec![
        Feature::add(
            "bridge head",
            Shape::block(
                (TOWER_BACK, "tower_front"),
                ("-tower_half_width", "tower_half_width"),
                (BRIDGE_BOTTOM, BRIDGE_TOP),
            ),
        ),
        Feature::add(
            "bridge arm",
            Shape::block(
                ("tower_front - 1", DRIVER_X),
                (&format!("-{EYE}"), EYE),
                (BRIDGE_BOTTOM, BRIDGE_TOP),
            ),
        ),
        Feature::add(
            "bridge eye",
            Shape::upright(DRIVER_X, "0", (BRIDGE_BOTTOM, BRIDGE_TOP), EYE),
        ),
    ]
}

/// Bearing hole of the upper journal.
pub fn upper_bearing() -> Feature {
    Feature::cut(
        "upper bearing",
        Shape::upright(
            DRIVER_X,
            "0",
            (
                &format!("{BRIDGE_BOTTOM} - 1"),
                &format!("{BRIDGE_TOP} + 1"),
            ),
            "journal_radius + joint_play",
        ),
    )
}

/// Bearing hole of the lower journal.
pub fn lower_bearing() -> Feature {
    Feature::cut(
        "lower bearing",
        Shape::upright(
            DRIVER_X,
            "0",
            (&format!("{BASE_BOTTOM} - 1"), &format!("{BASE_TOP} + 1")),
            "journal_radius + joint_play",
        ),
    )
}

/// The key on the driver tower that locates the bridge, grown by `fit` (an expression) for its pocket.
pub fn bridge_key(pocket: bool) -> Feature {
    let (half, top) = match pocket {
        true => ("(2 + piece_fit)", "2.5"),
        false => ("2", "2"),
    };
    let shape = Shape::block(
        (
            &format!("{TOWER_X} - {half}"),
            &format!("{TOWER_X} + {half}"),
        ),
        (&format!("-{half}"), half),
        (
            &format!("{BRIDGE_BOTTOM} - 1"),
            &format!("{BRIDGE_BOTTOM} + {top}"),
        ),
    );
    match pocket {
        true => Feature::cut("bridge key pocket", shape),
        false => Feature::add("bridge key", shape),
    }
}

/// The bridge's two screws, vertical; through holes in the bridge or tapped holes in the tower.
pub fn bridge_screws(tapped: bool) -> Vec<Feature> {
    let (z, radius) = match tapped {
        true => (
            (
                format!("{BRIDGE_BOTTOM} - 10"),
                format!("{BRIDGE_BOTTOM} + 1"),
            ),
            "screw_tap_radius",
        ),
        false => (
            (format!("{BRIDGE_BOTTOM} - 1"), format!("{BRIDGE_TOP} + 1")),
            "screw_hole_radius",
        ),
    };
    [("left", ""), ("right", "-")]
        .map(|(side, sign)| {
            Feature::cut(
                &format!("{side} bridge screw"),
                Shape::upright(
                    TOWER_X,
                    &format!("{sign}{BRIDGE_SCREW_Y}"),
                    (&z.0, &z.1),
                    radius,
                ),
            )
        })
        .into()
}

/// The follower stand: foot with tower and socket (3R) or with the slider's rail (3R1T).
pub fn stand(class: Class) -> Vec<Feature> {
    let foot = Feature::add(
        "stand foot",
        Shape::block(
            ("stand_front", "base_end"),
            ("-stand_half_width", "stand_half_width"),
            (BASE_TOP, FOOT_TOP),
        ),
    );
    match class {
        Class::R3 => {
            let mut features = vec![
                foot,
                Feature::add(
                    "follower tower",
                    Shape::block(
                        ("stand_front", "stand_front + stand_thickness"),
                        ("-stand_half_width", "stand_half_width"),
                        (BASE_TOP, "arm_half_height"),
                    ),
                ),
            ];
            features.extend(joints::socket_body("stand_front + 1"));
            features
        }
        Class::R3T1 => vec![foot, rail("0", RAIL_TOP)],
        Class::R1 | Class::R1T1 => Vec::new(),
    }
}

/// End of the rail: above the carriage at its highest.
const RAIL_TOP: &str = "carriage_half_height + lift_max + 2";

fn rail(grow: &str, top: &str) -> Feature {
    Feature::add("rail", rail_block(grow, (BASE_TOP, top)))
}

fn rail_block(grow: &str, z: (&str, &str)) -> Shape {
    Shape::block(
        (
            &format!("{RAIL_FRONT} - {grow}"),
            &format!("{RAIL_FRONT} + stand_thickness + {grow}"),
        ),
        (
            &format!("-rail_half_width - {grow}"),
            &format!("rail_half_width + {grow}"),
        ),
        z,
    )
}

/// The slider of 3R1T in Σ at zero lift: socket, arm and carriage, not yet hollow.
pub fn slider() -> Vec<Feature> {
    let mut features = joints::socket_body("stand_front + 1");
    features.push(Feature::add(
        "carriage",
        Shape::block(
            (
                "stand_front",
                "stand_front + stand_thickness + 2 * guide_wall + 2 * joint_play",
            ),
            (
                "-rail_half_width - joint_play - guide_wall",
                "rail_half_width + joint_play + guide_wall",
            ),
            ("-carriage_half_height", "carriage_half_height"),
        ),
    ));
    features
}

/// The slider's guide hole.
pub fn guide() -> Feature {
    Feature::cut(
        "guide",
        rail_block(
            "joint_play",
            ("-carriage_half_height - 1", "carriage_half_height + 1"),
        ),
    )
}

/// Key on the base plate that guides the stand, or the groove for it under the stand's foot.
pub fn stand_key(groove: bool) -> Feature {
    let (half, height) = match groove {
        true => ("3", "1.5"),
        false => ("(3 - piece_fit)", "(1.5 - piece_fit)"),
    };
    let shape = Shape::block(
        ("stand_front", "base_end"),
        (&format!("-{half}"), half),
        (
            &format!("{BASE_TOP} - 1"),
            &format!("{BASE_TOP} + {height}"),
        ),
    );
    match groove {
        true => Feature::cut("stand groove", shape),
        false => Feature::add("stand key", shape),
    }
}

/// The two screws that hold the stand down; through its foot, or tapped in the base.
pub fn stand_screws(tapped: bool) -> Vec<Feature> {
    let (z, radius) = match tapped {
        true => (
            (format!("{BASE_BOTTOM} - 1"), format!("{BASE_TOP} + 1")),
            "screw_tap_radius",
        ),
        false => (
            (format!("{BASE_TOP} - 1"), format!("{FOOT_TOP} + 1")),
            "screw_hole_radius",
        ),
    };
    vertical_pair(
        "stand screw",
        "base_end - 5",
        "(stand_half_width - 4)",
        (&z.0, &z.1),
        radius,
    )
}

/// Screws of the pin's flange, from below: countersunk in the flange, or tapped in the base.
pub fn pin_screws(tapped: bool) -> Vec<Feature> {
    let radius = if tapped {
        "screw_tap_radius"
    } else {
        "screw_hole_radius"
    };
    let bottom = format!("{BASE_BOTTOM} - 1");
    let top = format!("{BASE_TOP} + 1");
    let y = "(pin_radius / 2 + pin_flange_radius / 2)";
    let mut features = vertical_pair("pin screw", "0", y, (&bottom, &top), radius);
    if !tapped {
        features.extend([("left", ""), ("right", "-")].map(|(side, sign)| {
            Feature::cut(
                &format!("{side} pin screw head"),
                Shape::Cone {
                    base: ["0".into(), format!("{sign}{y}"), BASE_BOTTOM.into()],
                    axis: [0.0, 0.0, 1.0],
                    length: "screw_hole_radius".into(),
                    r0: "2 * screw_hole_radius".into(),
                    r1: "screw_hole_radius".into(),
                },
            )
        }));
    }
    features
}

fn vertical_pair(name: &str, x: &str, y: &str, z: (&str, &str), radius: &str) -> Vec<Feature> {
    [("left", ""), ("right", "-")]
        .map(|(side, sign)| {
            Feature::cut(
                &format!("{side} {name}"),
                Shape::upright(x, &format!("{sign}{y}"), z, radius),
            )
        })
        .into()
}
