//! The examples that need no file beside them: what `mpcgear new --example` writes.

/// Their names and texts.
const EXAMPLES: [(&str, &str); 13] = [
    ("uniform_1r", include_str!("../../examples/uniform_1r.toml")),
    (
        "quick_return_1r",
        include_str!("../../examples/quick_return_1r.toml"),
    ),
    (
        "stirrer_20_10_1r",
        include_str!("../../examples/stirrer_20_10_1r.toml"),
    ),
    (
        "stroke_1r1t",
        include_str!("../../examples/stroke_1r1t.toml"),
    ),
    ("trefoil", include_str!("../../examples/trefoil.toml")),
    (
        "trefoil_20_10",
        include_str!("../../examples/trefoil_20_10.toml"),
    ),
    (
        "pick_and_place_3r",
        include_str!("../../examples/pick_and_place_3r.toml"),
    ),
    (
        "flapping_wing_3r",
        include_str!("../../examples/flapping_wing_3r.toml"),
    ),
    (
        "wobble_lift_3r1t",
        include_str!("../../examples/wobble_lift_3r1t.toml"),
    ),
    (
        "camera_head_3r",
        include_str!("../../examples/camera_head_3r.toml"),
    ),
    (
        "stirrer_1r1t",
        include_str!("../../examples/stirrer_1r1t.toml"),
    ),
    ("press_1r", include_str!("../../examples/press_1r.toml")),
    ("tray_3r", include_str!("../../examples/tray_3r.toml")),
];

/// Their names.
pub fn names() -> [&'static str; EXAMPLES.len()] {
    EXAMPLES.map(|(name, _)| name)
}

/// The motion file of an example.
pub fn example(name: &str) -> Option<&'static str> {
    let found = EXAMPLES.iter().find(|(own, _)| *own == name);
    found.map(|(_, text)| *text)
}
