//! The follower's joint, as recipe features: ball and socket, or pin and bore.

use super::hub::MOUNT_TOP;
use super::recipe::{Feature, Shape};
use super::support::{BASE_BOTTOM, BASE_TOP};
use crate::motion::Class;

/// Outer radius of the socket ring.
pub const RING_RADIUS: &str = "(ball_radius + joint_play + socket_wall)";
/// y of the socket's screws.
pub const LUG_SCREW_Y: &str = "(ball_radius + joint_play + socket_wall + lug_length / 2)";

/// Top of the pin's full radius: below the follower's web (1R) or the closed end of its bore.
pub const PIN_TOP_R1: &str =
    "(mount_bottom + mount_thickness - cap_pocket - web_thickness - safety_gap)";
const PIN_TOP_R1T1: &str = "(mount_bottom + lift_min - safety_gap)";
/// Upper face of the web that the cap holds down, 1R.
pub const WEB_TOP: &str = "(mount_bottom + mount_thickness - cap_pocket)";

/// Ball and the necks that carry it; follower frame.
pub fn ball() -> Vec<Feature> {
    vec![
        Feature::add(
            "ball",
            Shape::Ball {
                center: ["0".into(), "0".into(), "0".into()],
                radius: "ball_radius".into(),
            },
        ),
        Feature::add(
            "upper neck",
            Shape::upright("0", "0", ("0", "drum_start + 1"), "neck_radius"),
        ),
    ]
}

/// The neck below the ball, where there is a drum below.
pub fn lower_neck() -> Feature {
    Feature::add(
        "lower neck",
        Shape::upright("0", "0", ("-drum_start - 1", "0"), "neck_radius"),
    )
}

/// Ring, arm and screw lugs around the ball, not yet hollow; Σ.
pub fn socket_body(arm_end: &str) -> Vec<Feature> {
    vec![
        socket_ring(),
        socket_lugs(),
        Feature::add(
            "arm",
            Shape::block(
                ("0", arm_end),
                ("-arm_half_width", "arm_half_width"),
                ("-arm_half_height", "arm_half_height"),
            ),
        ),
    ]
}

/// The ring alone.
pub fn socket_ring() -> Feature {
    Feature::add(
        "socket ring",
        Shape::upright(
            "0",
            "0",
            ("-ring_half_height", "ring_half_height"),
            RING_RADIUS,
        ),
    )
}

/// The lugs for the screws that close the socket.
pub fn socket_lugs() -> Feature {
    let reach = format!("{RING_RADIUS} + lug_length");
    Feature::add(
        "socket lugs",
        Shape::block(
            ("-lug_half_thickness", "lug_half_thickness"),
            (&format!("-({reach})"), &reach),
            ("-lug_half_height", "lug_half_height"),
        ),
    )
}

/// The hollow that holds the ball.
pub fn socket_hollow() -> Feature {
    Feature::cut(
        "socket hollow",
        Shape::Ball {
            center: ["0".into(), "0".into(), "0".into()],
            radius: "ball_radius + joint_play".into(),
        },
    )
}

/// Holes for the socket's two screws, along x.
pub fn socket_screws(radius: &str) -> Vec<Feature> {
    [("left", ""), ("right", "-")]
        .map(|(side, sign)| {
            Feature::cut(
                &format!("{side} socket screw"),
                Shape::along_x(
                    [
                        "-lug_half_thickness - 1",
                        &format!("{sign}{LUG_SCREW_Y}"),
                        "0",
                    ],
                    "2 * lug_half_thickness + 2",
                    radius,
                ),
            )
        })
        .into()
}

/// The follower's bore: through with a pocket for the cap (1R), blind with a vent (1R1T).
pub fn bore(class: Class) -> Vec<Feature> {
    let upright = |z: (&str, &str), radius: &str| Shape::upright("0", "0", z, radius);
    let bore_radius = "pin_radius + joint_play";
    match class {
        Class::R1 => vec![
            Feature::cut(
                "bore",
                upright(
                    ("driver_bottom - 1", &format!("{PIN_TOP_R1} + safety_gap")),
                    bore_radius,
                ),
            ),
            Feature::cut(
                "web hole",
                upright(
                    (&format!("{PIN_TOP_R1} - 1"), &format!("{WEB_TOP} + 1")),
                    "pin_neck_radius + joint_play",
                ),
            ),
            Feature::cut(
                "cap pocket",
                upright(
                    (WEB_TOP, &format!("{MOUNT_TOP} + 1")),
                    "pin_radius + safety_gap",
                ),
            ),
        ],
        Class::R1T1 => vec![
            Feature::cut(
                "bore",
                upright(("follower_bottom - 1", "mount_bottom"), bore_radius),
            ),
            Feature::cut(
                "vent",
                upright(
                    ("mount_bottom - 1", &format!("{MOUNT_TOP} + 1")),
                    "vent_radius",
                ),
            ),
        ],
        Class::R3 | Class::R3T1 => Vec::new(),
    }
}

/// The pin that the follower turns on; Σ. Empty for the spherical classes.
pub fn pin(class: Class) -> Vec<Feature> {
    let upright = |z: (&str, &str), radius: &str| Shape::upright("0", "0", z, radius);
    let shank = |top: &str| Feature::add("pin", upright((BASE_BOTTOM, top), "pin_radius"));
    match class {
        Class::R1 => vec![
            shank(PIN_TOP_R1),
            Feature::add(
                "pin neck",
                upright(
                    (
                        &format!("{PIN_TOP_R1} - 1"),
                        &format!("{WEB_TOP} + joint_play"),
                    ),
                    "pin_neck_radius",
                ),
            ),
        ],
        Class::R1T1 => vec![shank(PIN_TOP_R1T1)],
        Class::R3 | Class::R3T1 => Vec::new(),
    }
}

/// The flange that the pin is screwed to the base with, from below.
pub fn pin_flange() -> Feature {
    Feature::add(
        "pin flange",
        Shape::upright("0", "0", (BASE_BOTTOM, PIN_FLANGE_TOP), "pin_flange_radius"),
    )
}

/// Upper face of the pin's flange, half-way into the plate.
pub const PIN_FLANGE_TOP: &str = "(driver_bottom - joint_play - plate_thickness / 2)";

/// The cap on the pin's end that keeps a 1R follower down.
pub fn pin_cap() -> Feature {
    Feature::add(
        "pin cap",
        Shape::upright(
            "0",
            "0",
            (
                &format!("{WEB_TOP} + joint_play"),
                &format!("{WEB_TOP} + joint_play + cap_thickness"),
            ),
            "pin_radius",
        ),
    )
}

/// Joins pin and cap where the support is one body: their faces meet in one plane, where round-off
/// decides whether they touch.
pub fn pin_end() -> Feature {
    Feature::add(
        "pin end",
        Shape::upright(
            "0",
            "0",
            (
                &format!("{WEB_TOP} + joint_play / 2"),
                &format!("{WEB_TOP} + joint_play + cap_thickness / 2"),
            ),
            "pin_neck_radius",
        ),
    )
}

/// A hole along the pin's end for the cap's screw.
pub fn cap_screw(radius: &str) -> Feature {
    Feature::cut(
        "cap screw",
        Shape::upright(
            "0",
            "0",
            (
                &format!("{WEB_TOP} - 8"),
                &format!("{WEB_TOP} + cap_thickness + 1"),
            ),
            radius,
        ),
    )
}

/// Room for the pin and its flange in the base plate.
pub fn pin_seat() -> Vec<Feature> {
    vec![
        Feature::cut(
            "pin hole",
            Shape::upright(
                "0",
                "0",
                (&format!("{BASE_BOTTOM} - 1"), &format!("{BASE_TOP} + 1")),
                "pin_radius + piece_fit",
            ),
        ),
        Feature::cut(
            "pin flange pocket",
            Shape::upright(
                "0",
                "0",
                (&format!("{BASE_BOTTOM} - 1"), PIN_FLANGE_TOP),
                "pin_flange_radius + piece_fit",
            ),
        ),
    ]
}
