//! The pieces to print, and how they go together.

use serde::Serialize;

use super::joints;
use super::recipe::{Feature, Piece, Shape};
use super::support;
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
        base.push(support::stand_key(true));
        base.extend(support::stand_screws(true));
        let mut stand = support::stand(class);
        if class == Class::R3 {
            open_socket(&mut stand);
        }
        stand.push(support::stand_key(false));
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

/// Screws and steps of the assembly; `screw` is the nominal size, "M3".
pub fn assembly(class: Class, screw: &str) -> Assembly {
    let mut printed = vec![
        ("driver", "driver gear with its shaft"),
        ("follower", "follower gear with the end-effector mount"),
        ("base", "base plate with the driver tower"),
        ("bridge", "upper bearing of the driver"),
    ];
    let mut bought = vec![(2, format!("{screw}×16 pan-head screw (bridge)"))];
    let mut steps = vec![
        "Deburr the journals, the bearings and the joint; everything must turn freely by hand."
            .to_string(),
        "Lower the driver into the bearing hole of the base plate.".to_string(),
        "Put the bridge over the driver's upper journal, onto the key of the tower, and screw it down."
            .to_string(),
    ];
    let socket = "Lay the follower's ball into the open half of the socket, close it with the socket cap and tighten its two screws evenly; the ball must still turn freely.";
    let stand = "Turn driver and follower to their marks for φ = 0 and slide the stand along its groove towards the driver until the teeth mesh and its foot is flush with the end of the base plate; screw it down.";
    let pin = "Move the follower sideways into mesh, over the pin hole of the base plate.";
    match class {
        Class::R1 | Class::R1T1 => {
            printed.push(("pin", "pin of the follower"));
            bought.push((2, format!("{screw}×8 countersunk screw (pin flange)")));
            steps.push(pin.into());
            steps.push("Push the pin through the base plate from below into the follower's bore and screw its flange down.".into());
            if class == Class::R1 {
                printed.push(("pin_cap", "cap that keeps the follower on its pin"));
                bought.push((1, format!("{screw}×8 pan-head screw (pin cap)")));
                steps.push(
                    "Lay the cap into the pocket of the mount and screw it onto the pin.".into(),
                );
            } else {
                steps.push("Check that the follower slides freely along the pin.".into());
            }
        }
        Class::R3 => {
            printed.push(("stand", "follower tower with half of the socket"));
            printed.push(("socket_cap", "other half of the socket"));
            bought.push((2, format!("{screw}×12 pan-head screw (socket)")));
            bought.push((2, format!("{screw}×10 pan-head screw (stand)")));
            steps.push(socket.into());
            steps.push(stand.into());
        }
        Class::R3T1 => {
            printed.push(("stand", "foot with the slider's rail"));
            printed.push(("slider_carriage", "carriage with half of the socket"));
            printed.push(("socket_cap", "other half of the socket"));
            bought.push((2, format!("{screw}×12 pan-head screw (socket)")));
            bought.push((2, format!("{screw}×10 pan-head screw (stand)")));
            steps.push(socket.into());
            steps.push("Slide the carriage onto the rail of the stand from above.".into());
            steps.push(stand.into());
        }
    }
    steps.push("Turn the driver by its shaft end: the follower must pass through its whole motion without a tight spot.".into());
    Assembly {
        printed: printed
            .into_iter()
            .map(|(name, what)| (name.into(), what.into()))
            .collect(),
        bought,
        steps,
    }
}
