//! The pieces to print, and how they go together.

use serde::Serialize;

use super::expression::Values;
use super::recipe::{Feature, Piece, Recipe, Shape};
use super::{joints, support};
use crate::Result;
use crate::motion::Class;

/// Everything `parts.md` says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Assembly {
    /// Printed pieces: file stem and what it is.
    pub printed: Vec<(String, String)>,
    /// Bought parts: number and what.
    pub bought: Vec<(u32, String)>,
    /// Steps in order.
    pub steps: Vec<String>,
}

const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// Pieces of the support body.
pub fn support(class: Class) -> Vec<Piece> {
    let mut base = support::base();
    base.push(support::bridge_key(false));
    base.push(support::lower_bearing());
    base.extend(support::bridge_screws(true));
    let mut bridge = support::bridge();
    bridge.push(support::upper_bearing());
    bridge.push(support::bridge_key(true));
    bridge.extend(support::bridge_screws(false));

    let mut pieces = Vec::new();
    if class.is_spherical() {
        base.push(support::stand_key(false));
        base.extend(support::stand_screws(true));
        let mut stand = support::stand(class);
        if class == Class::R3 {
            open_socket(&mut stand);
        }
        stand.push(support::stand_key(true));
        stand.extend(support::stand_screws(false));
        pieces.push(piece("stand", stand, UP));
        if class == Class::R3 {
            pieces.push(socket_cap());
        }
    } else {
        base.extend(joints::pin_seat());
        base.extend(support::pin_screws(true));
        let mut pin = joints::pin(class);
        pin.push(joints::pin_flange());
        pin.extend(support::pin_screws(false));
        if class == Class::R1 {
            pin.push(joints::cap_screw("screw_tap_radius"));
            let cap = vec![joints::pin_cap(), joints::cap_screw("screw_hole_radius")];
            pieces.push(piece("pin_cap", cap, UP));
        }
        pieces.push(piece("pin", pin, UP));
    }
    pieces.insert(0, piece("base", base, UP));
    pieces.insert(1, piece("bridge", bridge, UP));
    pieces
}

/// Pieces of the slider body of 3R1T.
pub fn slider() -> Vec<Piece> {
    let mut carriage = support::slider();
    open_socket(&mut carriage);
    carriage.push(support::guide());
    vec![
        piece("slider_carriage", carriage, [-1.0, 0.0, 0.0]),
        socket_cap(),
    ]
}

fn piece(name: &str, features: Vec<Feature>, up: [f64; 3]) -> Piece {
    Piece {
        name: name.into(),
        features,
        up,
    }
}

/// Keeps the half x > 0 of a socket and drills its tapped holes.
fn open_socket(features: &mut Vec<Feature>) {
    features.push(joints::socket_hollow());
    features.push(half_space("half of the cap", "-far", "0"));
    features.extend(joints::socket_screws("screw_tap_radius"));
}

/// The half ring x < 0 that closes the socket.
fn socket_cap() -> Piece {
    let mut cap = vec![joints::socket_ring(), joints::socket_lugs()];
    cap.push(joints::socket_hollow());
    cap.push(half_space("half of the stand", "0", "far"));
    cap.extend(joints::socket_screws("screw_hole_radius"));
    piece("socket_cap", cap, [-1.0, 0.0, 0.0])
}

fn half_space(name: &str, from: &str, to: &str) -> Feature {
    let far = |end: &str| end.replace("far", "(2 * center_distance)");
    Feature::cut(
        name,
        Shape::block(
            (&far(from), &far(to)),
            ("-(2 * center_distance)", "(2 * center_distance)"),
            ("-(2 * center_distance)", "(2 * center_distance)"),
        ),
    )
}

/// Lengths that screws are sold in, mm.
const SCREW_LENGTHS: [f64; 12] = [
    4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0,
];

/// Nominal size of a screw whose clearance hole is that wide, in half millimetres: 3.4 → M3.
fn nominal(hole_diameter: f64) -> f64 {
    (2.0 * hole_diameter / 1.1).floor() / 2.0
}

/// "2 M3×16 pan-head screws" that reach through at most `room` mm.
fn screws(number: u32, size: f64, room: f64, head: &str) -> (u32, String) {
    let length = SCREW_LENGTHS
        .into_iter()
        .filter(|&l| l <= room)
        .fold(SCREW_LENGTHS[0], f64::max);
    (number, format!("M{size}×{length} {head}"))
}

/// What to print, what to buy and how to put it together, for a recipe of `class`.
///
/// # Errors
/// [`crate::Error::Internal`] when the recipe lacks a parameter of its class.
pub fn assembly(class: Class, recipe: &Recipe) -> Result<Assembly> {
    let values = Values::new(&recipe.parameters);
    let size = nominal(2.0 * values.eval("screw_hole_radius")?);
    let mut printed = vec![
        ("driver", "driver gear with its shaft"),
        ("follower", "follower gear with the end-effector mount"),
        ("base", "base plate with the driver tower"),
        ("bridge", "upper bearing of the driver"),
    ];
    let bridge = values.eval("bridge_thickness + 10")?;
    let mut bought = vec![screws(2, size, bridge, "pan-head screws (bridge)")];
    let mut steps = vec![
        "Deburr the journals, the bearings and the joint; everything must turn freely by hand.",
        "Lower the driver into the bearing hole of the base plate.",
        "Put the bridge over the driver's upper journal, onto the key of the tower, and screw it down.",
    ];
    if class.is_spherical() {
        let socket = values.eval("2 * lug_half_thickness")?;
        let stand = values.eval("foot_thickness + plate_thickness")?;
        bought.push(screws(2, size, socket, "pan-head screws (socket cap)"));
        bought.push(screws(2, size, stand, "pan-head screws (stand)"));
        steps.push("Lay the follower's ball into the open half of the socket, close it with the socket cap and tighten its two screws evenly; the ball must still turn freely.");
        if class == Class::R3 {
            printed.push(("stand", "follower tower with half of the socket"));
        } else {
            printed.push(("stand", "foot with the slider's rail"));
            printed.push(("slider_carriage", "carriage with half of the socket"));
            steps.push("Slide the carriage onto the rail of the stand from above.");
        }
        printed.push(("socket_cap", "other half of the socket"));
        steps.push("Turn driver and follower to φ = 0, slide the stand along its key towards the driver until the teeth mesh and its foot is flush with the end of the base plate, and screw it down.");
    } else {
        let flange = values.eval("plate_thickness - 0.5")?;
        printed.push(("pin", "pin of the follower"));
        bought.push(screws(2, size, flange, "countersunk screws (pin flange)"));
        steps.push("Turn driver and follower to φ = 0 and move the follower sideways into mesh, over the pin hole of the base plate.");
        steps.push("Push the pin through the base plate from below into the follower's bore and screw its flange down.");
        if class == Class::R1 {
            let cap = values.eval("cap_thickness + 7")?;
            printed.push(("pin_cap", "cap that keeps the follower on its pin"));
            bought.push(screws(1, size, cap, "pan-head screw (pin cap)"));
            steps.push("Lay the cap into the pocket of the mount and screw it onto the pin.");
        } else {
            steps.push("Check that the follower slides freely along the pin.");
        }
    }
    steps.push("Turn the driver by its shaft end: the follower must pass through its whole motion without a tight spot.");
    let text = |(name, what): (&str, &str)| (name.to_string(), what.to_string());
    Ok(Assembly {
        printed: printed.into_iter().map(text).collect(),
        bought,
        steps: steps.into_iter().map(String::from).collect(),
    })
}
