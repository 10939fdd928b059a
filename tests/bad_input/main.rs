//! Every kind of bad input has its own message: where, what was found, what is allowed.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

mod hostile;
mod motions;

use std::path::Path;

use mpcgear::motion::{Class, MotionFile, starter};
use mpcgear::settings::Settings;
use mpcgear::{Error, Result};

/// What reading `text` says; panics if it is accepted.
fn message(text: &str) -> String {
    error(text, Path::new(".")).to_string()
}

fn error(text: &str, folder: &Path) -> Error {
    match MotionFile::parse(text, Path::new("my.toml"), folder) {
        Ok(_) => panic!("must be refused:\n{text}"),
        Err(error) => error,
    }
}

/// Asserts that the message of `text` contains all `parts`, and that it is bad input.
fn refused(text: &str, parts: &[&str]) {
    let error = error(text, Path::new("."));
    assert_eq!(error.exit_code(), 2, "{error}");
    contains(&error.to_string(), parts);
}

fn contains(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in:\n{message}");
    }
}

/// A good motion file of `class` with `more` at its end.
fn with(class: &str, motion: &str, more: &str) -> String {
    format!("class = \"{class}\"\n[motion]\n{motion}\n{more}\n")
}

fn uniform(more: &str) -> String {
    with("1R", "kind = \"formula\"", more)
}

/// A table of `rows` in a folder with a motion file that refers to it.
fn table(class: &str, csv: &str) -> Result<()> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("poses.csv"), csv).unwrap();
    let text = with(class, "kind = \"table\"\nfile = \"poses.csv\"", "");
    MotionFile::parse(&text, Path::new("my.toml"), folder.path()).map(|_| ())
}

fn table_refused(class: &str, csv: &str, parts: &[&str]) {
    let error = table(class, csv).expect_err("must be refused");
    assert_eq!(error.exit_code(), 2, "{error}");
    contains(&error.to_string(), parts);
}

/// CSV of a uniform turn with `turns` turns per period, edited row by row.
fn rows(count: usize, turns: f64, edit: impl Fn(usize, &mut [f64; 8])) -> String {
    let mut text = String::from("phi_deg,x,y,z,qw,qx,qy,qz\n");
    for i in 0..=count {
        let phi = 360.0 * i as f64 / count as f64;
        let half = turns * phi.to_radians() / 2.0;
        let mut row = [phi, 0.0, 0.0, 0.0, half.cos(), 0.0, 0.0, half.sin()];
        edit(i, &mut row);
        text += &row.map(|v| v.to_string()).join(",");
        text += "\n";
    }
    text
}

#[test]
fn good_files_pass() {
    for text in [
        uniform(""),
        uniform("[gear]\nteeth = 12\ncenter_distance_mm = 30"),
    ] {
        MotionFile::parse(&text, Path::new("my.toml"), Path::new(".")).unwrap();
    }
    table("1R", &rows(36, -1.0, |_, _| {})).unwrap();
    table(
        "1R",
        &rows(8, -1.0, |i, row| {
            if i % 2 == 0 {
                row[4] *= -1.0;
                row[7] *= -1.0
            }
        }),
    )
    .unwrap();
}

#[test]
fn files_that_are_no_motion_files() {
    let missing = MotionFile::read(Path::new("no/such.toml")).unwrap_err();
    assert_eq!(missing.exit_code(), 2);
    contains(&missing.to_string(), &["no/such.toml", "No such file"]);
    refused("class = \n", &["line 1", "not TOML"]);
    refused("class = \"1R\"\n[motion\nkind = 1", &["line 2", "not TOML"]);
    refused("", &["class: is missing", "[motion] is missing"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("binary.toml");
    std::fs::write(&path, [0x61, 0xff, 0xfe]).unwrap();
    contains(
        &MotionFile::read(&path).unwrap_err().to_string(),
        &["not text", "byte 1"],
    );
}

#[test]
fn a_huge_file_is_refused_unread() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.toml");
    let file = std::fs::File::create(&path).unwrap();
    file.set_len(100_000_000).unwrap(); // sparse: takes no room
    let error = MotionFile::read(&path).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    contains(&error.to_string(), &["100 MB", "allowed 4 MB"]);
    std::fs::rename(&path, folder.path().join("poses.csv")).unwrap();
    let text = with("1R", "kind = \"table\"\nfile = \"poses.csv\"", "");
    let error = MotionFile::parse(&text, Path::new("my.toml"), folder.path()).unwrap_err();
    contains(&error.to_string(), &["poses.csv", "allowed 50 MB"]);
}

#[test]
fn unknown_names_get_suggestions() {
    refused(
        &uniform("[gear]\ntooth = 12"),
        &["line 5, gear.tooth: unknown field", "`teeth`"],
    );
    refused(&uniform("[gears]"), &["gears: unknown field", "`gear`"]);
    refused(
        &with("4R", "kind = \"formula\"", ""),
        &["class: is \"4R\"", "\"3R1T\""],
    );
    refused(
        &with("3r", "kind = \"formula\"", ""),
        &["did you mean \"3R\"?"],
    );
    refused(
        &with("1R", "kind = \"formla\"", ""),
        &["motion.kind", "did you mean \"formula\"?"],
    );
    refused(
        &with("1R", "kind = \"formula\"\nown_trn = \"-phi\"", ""),
        &["`own_turn`"],
    );
    refused(
        &with(
            "3R",
            "kind = \"keyframes\"\n[[motion.keyframes]]\nphi = 3",
            "",
        ),
        &["motion.keyframes[1].phi", "`phi_deg`"],
    );
}

#[test]
fn all_problems_at_once() {
    let text = uniform(
        "[gear]\nteeth = 2\ncontact_ratio = 1\ntip_mm = \"high\"\nwarp = 9\n[fit]\nclearance_mm = nan\n[search]\neffort = 0",
    );
    insta::assert_snapshot!(message(&text), @r#"
    my.toml: 6 problem(s)
      - line 5, gear.teeth: is 2, allowed 3 to 60
      - line 6, gear.contact_ratio: is 1, allowed more than 1 up to 3
          hint: above 1 the next tooth takes over before the last one lets go
      - line 7, gear.tip_mm: is "high": invalid type: string "high", expected a number
          hint: the default is 0.9
      - line 8, gear.warp: unknown field
          hint: known here: center_distance_mm, closure_threshold, contact_ratio, driver_teeth, flank_radius_mm, follower_teeth, least_contact_ratio, locus_control_points, minimum_wall_mm, norm_weight, normal_control_points, root_mm, samples, sub_gear_pairs, teeth, tip_mm, tooth_thickness_mm
      - line 10, fit.clearance_mm: is NaN, allowed 0 to 2
      - line 12, search.effort: is 0, allowed 0.001 to 1000
    "#);
}

#[test]
fn ranges_of_a_reciprocating_driver() {
    let formula = |lines: &str, parts: &[&str]| {
        let text = format!("class = \"1R\"\n[motion]\nkind = \"formula\"\n{lines}");
        refused(&text, parts);
    };
    let there = "drive = \"reciprocating\"\n";
    formula(
        there,
        &["motion.range_deg", "is missing", "range_deg = [-60, 60]"],
    );
    formula("range_deg = [-60, 60]", &["drive is not \"reciprocating\""]);
    formula(
        &format!("{there}range_deg = [-5, 5]"),
        &["allowed are 20 to 330"],
    );
    formula(
        &format!("{there}range_deg = [20, 80]"),
        &["0 must be in it"],
    );
    formula(
        &format!("{there}range_deg = [nan, 80]"),
        &["motion.range_deg"],
    );
    formula("drive = \"rocking\"", &["rocking", "reciprocating"]);
    formula(
        &format!("{there}range_deg = [-60, 60]\n[gear]\ndriver_teeth = 20"),
        &["gear.driver_teeth", "own_turn says how fast"],
    );
    formula(
        &format!("{there}range_deg = [-60, 60]\n[search]\nmethod = \"paper\""),
        &["search.method", "no reciprocating driver"],
    );
}

#[test]
fn settings_out_of_range() {
    let gear = |line: &str, parts: &[&str]| refused(&uniform(&format!("[gear]\n{line}")), parts);
    gear("teeth = 2", &["gear.teeth", "is 2", "allowed 3 to 60"]);
    gear("teeth = -4", &["gear.teeth", "-4", "whole number"]);
    gear(
        "contact_ratio = 1.0",
        &["gear.contact_ratio", "more than 1"],
    );
    gear("contact_ratio = nan", &["gear.contact_ratio"]);
    gear("center_distance_mm = -25", &["is -25, allowed 5 to 500"]);
    gear("center_distance_mm = inf", &["is inf"]);
    gear(
        "tooth_thickness_mm = 0",
        &["gear.tooth_thickness_mm", "is 0"],
    );
    gear(
        "flank_radius_mm = 30",
        &["gear.flank_radius_mm", "is 30, allowed 0.05 to 25"],
    );
    gear(
        "flank_radius_mm = \"flat\"",
        &["gear.flank_radius_mm", "expected \"auto\" or a number"],
    );
    gear(
        "flank_radius_mm = 0.5\ntip_mm = 0.9",
        &["gear.tip_mm", "flank_radius_mm where that is less"],
    );
    gear(
        "sub_gear_pairs = 1",
        &["gear.sub_gear_pairs", "allowed 2 to 12"],
    );
    gear(
        "sub_gear_pairs = \"many\"",
        &["gear.sub_gear_pairs", "\"auto\""],
    );
    gear("teeth = 40", &["gear.teeth", "mm apart"]);
    gear(
        "driver_teeth = 15",
        &[
            "gear.driver_teeth",
            "is 15, no multiple",
            "of the 10 teeth",
            "10 or 20 teeth",
        ],
    );
    gear(
        "driver_teeth = 6\nfollower_teeth = 12",
        &["gear.driver_teeth", "is 6, no multiple", "12 or 24 teeth"],
    );
    gear(
        "driver_teeth = 80",
        &[
            "no multiple (up to 6 times)",
            "hint: 60 teeth on the driver",
        ],
    );
    gear("driver_teeth = 0", &["is 0, allowed 3 to 180"]);
    gear(
        "driver_teeth = \"many\"",
        &["gear.driver_teeth", "\"auto\" or a whole number"],
    );
    refused(&uniform("[search]\neffort = 0"), &["search.effort"]);
    refused(
        &uniform("[search]\nseed = -1"),
        &["search.seed", "whole number"],
    );
    refused(
        &uniform("[search]\nmethod = \"fast\""),
        &["search.method", "exact", "paper"],
    );
    refused(
        &uniform("[spokes]\nthickness_mm = 3"),
        &["spokes.thickness_mm", "more than gear.tooth"],
    );
    refused(
        &uniform("[support]\npin_radius_mm = 5"),
        &["support.pin_radius_mm"],
    );
    refused(
        &uniform("[hub]\ndriver_radius_mm = 22"),
        &["hubs of 22 and 4.2"],
    );
    refused(
        &uniform("gear = 3").replace(
            "[motion]\nkind = \"formula\"\ngear = 3",
            "gear = 3\n[motion]\nkind = \"formula\"",
        ),
        &["gear: is not a table"],
    );
    let neck = "[support]\nneck_radius_mm = 7";
    refused(
        &with("3R", "kind = \"formula\"", neck),
        &["support.neck_radius_mm", "ball_radius_mm"],
    );
}

#[test]
fn starters_are_good_files_that_show_all_defaults() {
    let defaults = toml::Table::try_from(Settings::default()).unwrap();
    for class in Class::ALL {
        let text = starter(class);
        let (file, motion) =
            MotionFile::parse(&text, Path::new("my.toml"), Path::new(".")).unwrap();
        assert_eq!((file.class, motion.class()), (class, class));
        assert_eq!(file.settings, Settings::default());
        let settings: String = text
            .lines()
            .skip_while(|line| !line.starts_with("# [gear]"))
            .map(|line| line.strip_prefix("# ").unwrap_or(line).to_owned() + "\n")
            .collect();
        let shown: toml::Table = toml::from_str(&settings).unwrap();
        assert_eq!(shown, defaults);
    }
}
