//! Names for the expressions that the recipe's features share, for scripts that people read.

use super::{joints, support};

/// An expression in parameters that several features use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Landmark {
    /// Identifier, as of a parameter.
    pub name: &'static str,
    /// The expression exactly as it stands in the features, in parentheses.
    pub expression: &'static str,
    /// One line for the user.
    pub description: &'static str,
}

const fn landmark(
    name: &'static str,
    expression: &'static str,
    description: &'static str,
) -> Landmark {
    Landmark {
        name,
        expression,
        description,
    }
}

/// All landmarks of all classes.
pub const LANDMARKS: [Landmark; 15] = [
    landmark(
        "base_top",
        support::BASE_TOP,
        "upper face of the base plate",
    ),
    landmark(
        "base_bottom",
        support::BASE_BOTTOM,
        "lower face of the base plate",
    ),
    landmark(
        "bridge_bottom",
        support::BRIDGE_BOTTOM,
        "lower face of the bridge",
    ),
    landmark(
        "bridge_top",
        support::BRIDGE_TOP,
        "upper face of the bridge",
    ),
    landmark(
        "bridge_eye_radius",
        support::EYE,
        "radius of the bridge around the driver's journal",
    ),
    landmark(
        "tower_back",
        support::TOWER_BACK,
        "face of the driver tower away from the driver",
    ),
    landmark("tower_x", support::TOWER_X, "middle of the driver tower"),
    landmark(
        "bridge_screw_y",
        support::BRIDGE_SCREW_Y,
        "y of the bridge's screws",
    ),
    landmark(
        "foot_top",
        support::FOOT_TOP,
        "upper face of the follower stand's foot",
    ),
    landmark(
        "rail_front",
        support::RAIL_FRONT,
        "face of the slider's rail towards the follower",
    ),
    landmark(
        "socket_radius",
        joints::RING_RADIUS,
        "outer radius of the socket ring",
    ),
    landmark(
        "socket_screw_y",
        joints::LUG_SCREW_Y,
        "y of the socket's screws",
    ),
    landmark(
        "pin_top",
        joints::PIN_TOP_R1,
        "top of the pin's full radius",
    ),
    landmark(
        "web_top",
        joints::WEB_TOP,
        "face of the follower that the cap holds down",
    ),
    landmark(
        "pin_flange_top",
        joints::PIN_FLANGE_TOP,
        "upper face of the pin's flange",
    ),
];
