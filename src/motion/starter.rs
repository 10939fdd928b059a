//! Starter files: what `mpcgear new` writes.

use super::Class;

/// All settings with their defaults, as comments.
const SETTINGS: &str = include_str!("starter_settings.toml");

/// A commented motion file of `class` that designs as it is.
pub fn starter(class: Class) -> String {
    let (does, motion) = match class {
        Class::R1 => (
            "the follower turns about z",
            r#"# Turn about the follower's own axis, rad. It must amount to -1 turn per turn of the driver.
own_turn = "-phi + 0.2*sin(phi)""#,
        ),
        Class::R1T1 => (
            "the follower turns about z and slides along z",
            r#"# Turn about the follower's own axis, rad. It must amount to -1 turn per turn of the driver.
own_turn = "-phi"
# Position of the joint's centre, mm; only z may move.
translation = ["0", "0", "2*sin(phi)"]"#,
        ),
        Class::R3 => (
            "the follower turns about a ball joint at the origin",
            r#"# Turn about the follower's own axis, rad, applied first; -1 turn per turn of the driver.
own_turn = "-phi"
# Then this rotation: an axis-angle vector, rad. Instead, `axis` gives the direction of the
# follower's axis: axis = ["0.1*cos(2*phi)", "0.1*sin(2*phi)", "1"]
rotation = ["7*deg*sin(phi)", "4*deg*sin(2*phi)", "0"]"#,
        ),
        Class::R3T1 => (
            "the follower turns about a ball joint that slides along z",
            r#"# Turn about the follower's own axis, rad, applied first; -1 turn per turn of the driver.
own_turn = "-phi"
# Then this rotation: an axis-angle vector, rad. Instead, `axis` gives the direction of the
# follower's axis: axis = ["0.1*cos(2*phi)", "0.1*sin(2*phi)", "1"]
rotation = ["5*deg*cos(2*phi)", "5*deg*sin(2*phi)", "0"]
# Position of the ball's centre, mm; only z may move.
translation = ["0", "0", "1.2*sin(phi)"]"#,
        ),
    };
    format!(
        r#"# Motion file of mpcgear. Design it with: mpcgear design FILE -o FOLDER
name = "my_{class}_gear"
class = "{class}"            # {does}; also: {others}

[motion]
# kind = "formula" writes the motion with phi, the driver's angle in rad, and sin, cos, pi, deg …
# Other kinds: "table" (poses in a CSV file), "keyframes" (poses in this file), "path" (a curve).
kind = "formula"
{motion}
# drive = "reciprocating"        # the driver goes there and back, which frees the follower's net turn,
# range_deg = [-60, 60]          # over these angles; 0 is among them
{SETTINGS}"#,
        others = Class::ALL
            .into_iter()
            .filter(|other| *other != class)
            .map(|other| other.to_string())
            .collect::<Vec<_>>()
            .join(", "),
    )
}
