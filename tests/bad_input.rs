//! Every kind of bad input has its own message: where, what was found, what is allowed.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

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
    contains(&error.to_string(), &["100 MB", "allowed 50 MB"]);
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
          hint: known here: center_distance_mm, closure_threshold, contact_ratio, flank_radius_mm, locus_control_points, minimum_wall_mm, norm_weight, normal_control_points, root_mm, samples, sub_gear_pairs, teeth, tip_mm, tooth_thickness_mm
      - line 10, fit.clearance_mm: is NaN, allowed 0 to 2
      - line 12, search.effort: is 0, allowed 0.001 to 1000
    "#);
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
        "flank_radius_mm = 1.5",
        &["more than half of tooth_thickness_mm"],
    );
    gear(
        "flank_radius_mm = 0.5",
        &["gear.tip_mm", "more than flank_radius_mm"],
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
fn bad_formulas() {
    let formula = |class: &str, line: &str, parts: &[&str]| {
        refused(
            &with(class, &format!("kind = \"formula\"\n{line}"), ""),
            parts,
        );
    };
    formula(
        "1R",
        "own_turn = \"-phi + abs(sin(phi))\"",
        &["line 4, motion.own_turn", "derivative"],
    );
    formula("1R", "own_turn = \"-phi + q\"", &["`q`", "known"]);
    formula(
        "1R",
        "own_turn = \"-phi + sqrt(sin(phi))\"",
        &["not a finite number at φ"],
    );
    formula(
        "1R",
        "own_turn = \"-phi/2\"",
        &["does not close", "180.000°"],
    );
    formula(
        "1R",
        "own_turn = \"-phi + 0.001*phi*sin(phi)\"",
        &["does not close"],
    );
    formula("1R", "own_turn = 3", &["motion", "string"]);
    formula(
        "3R",
        "translation = [\"0\", \"0\", \"2*sin(phi)\"]",
        &["2.0000 mm at φ = 90.0°", "3R does not translate"],
    );
    formula(
        "3R1T",
        "translation = [\"sin(phi)\", \"0\", \"0\"]",
        &["1.0000 mm at φ = 90.0°", "along z only"],
    );
    formula(
        "1R",
        "rotation = [\"0.1*sin(phi)\", \"0\", \"0\"]",
        &["tilts by 5.730° at φ = 90.0°", "about z only"],
    );
    formula(
        "3R",
        "rotation = [\"0\",\"0\",\"0\"]\naxis = [\"0\",\"0\",\"1\"]",
        &["both `axis` and `rotation`"],
    );
    formula(
        "1R1T",
        "translation = [\"0\", \"0\", \"atan(1e4*sin(phi))\"]",
        &["jumps between"],
    );
    formula(
        "1R",
        "constants = { a = \"phi\" }",
        &["motion.constants.a", "depends on phi"],
    );
}

#[test]
fn wrong_net_turn_and_tilt_are_infeasible() {
    let infeasible = |text: &str, parts: &[&str]| {
        let error = error(text, Path::new("."));
        assert_eq!(error.exit_code(), 3, "{error}");
        contains(&error.to_string(), parts);
    };
    for (turn, found) in [
        ("phi", "+1 turns"),
        ("0*phi", "+0 turns"),
        ("-2*phi", "-2 turns"),
    ] {
        let formula = format!("kind = \"formula\"\nown_turn = \"{turn}\"");
        for class in ["1R", "3R"] {
            infeasible(
                &with(class, &formula, ""),
                &["net turn", found, "must make −1"],
            );
        }
    }
    let tilted = "kind = \"formula\"\naxis = [\"3*sin(2*phi)\", \"0\", \"1\"]";
    infeasible(&with("3R", tilted, ""), &["tilt", "71.6°", "φ = "]);
    for turns in [1.0, 0.0, -2.0] {
        let error = table("3R", &rows(12, turns, |_, _| {})).unwrap_err();
        assert_eq!(error.exit_code(), 3, "{turns}: {error}");
        contains(
            &error.to_string(),
            &["net turn", &format!("{turns:+.0} turns")],
        );
    }
}

#[test]
fn bad_tables() {
    let file = |edit: fn(usize, &mut [f64; 8])| rows(36, -1.0, edit);
    table_refused("1R", &rows(5, -1.0, |_, _| {}), &["6 rows, at least 8"]);
    table_refused("1R", "", &["0 rows"]);
    table_refused(
        "1R",
        &file(|i, r| {
            if i == 7 {
                r[0] = 55.0
            }
        }),
        &["poses.csv row 8", "does not increase"],
    );
    table_refused(
        "1R",
        &file(|i, r| {
            if i == 7 {
                r[3] = f64::NAN
            }
        }),
        &["poses.csv line 9", "z is `NaN`"],
    );
    table_refused(
        "1R",
        &file(|i, r| {
            if i == 7 {
                r[4] = f64::INFINITY
            }
        }),
        &["qw is `inf`"],
    );
    table_refused(
        "1R",
        &file(|i, r| {
            if i == 7 {
                r[4..].fill(0.0)
            }
        }),
        &["row 8", "length zero"],
    );
    table_refused(
        "1R",
        &file(|i, r| {
            if i == 7 {
                r[4] *= 3.0;
                r[7] *= 3.0
            }
        }),
        &["row 8", "length 3"],
    );
    table_refused(
        "1R",
        &file(|i, r| {
            if i == 36 {
                r[0] = 355.0
            }
        }),
        &["a period is 360"],
    );
    table_refused(
        "1R1T",
        &file(|i, r| {
            if i == 36 {
                r[3] = 1.0
            }
        }),
        &["does not close", "1.0000 mm"],
    );
    table_refused(
        "1R1T",
        &file(|i, r| {
            if i == 9 {
                r[3] = 8.0
            }
        }),
        &["row 9 to", "jump between rows", "8.00 mm"],
    );
    table_refused(
        "1R",
        &file(|i, r| {
            if i == 5 {
                r.swap(4, 7)
            }
        }),
        &["jump between rows", "row 6"],
    );
    table_refused(
        "3R",
        &file(|_, r| r[3] = 0.5),
        &["translates by 0.5000 mm", "3R does not translate"],
    );
    table_refused("1R", &file(|_, r| r[1] = 0.5), &["translates by 0.5000 mm"]);
    table_refused(
        "1R",
        "phi,x,y,z,qw,qx,qy,qz\n",
        &["line 1", "the columns are `phi,"],
    );
    table_refused(
        "1R",
        &file(|_, _| {}).replace(",0,0,0,", ",0,0,"),
        &["has 7 values, 8 are needed"],
    );
    table_refused(
        "1R",
        &file(|_, _| {}).replace(",0,0,0,", ",0,zero,0,"),
        &["y is `zero`"],
    );
    let none = with("1R", "kind = \"table\"\nfile = \"nowhere.csv\"", "");
    refused(&none, &["nowhere.csv"]);
    refused(&with("1R", "kind = \"table\"", ""), &["motion", "rows"]);
    refused(
        &with("1R", "kind = \"table\"\nfile = 3", ""),
        &["motion.file", "path of a CSV"],
    );
}

#[test]
fn bad_keyframes_and_paths() {
    let keyframes = |list: &str| {
        with(
            "3R",
            &format!("kind = \"keyframes\"\nkeyframes = [{list}]"),
            "",
        )
    };
    refused(
        &keyframes("{ phi_deg = 0 }, { phi_deg = 90 }"),
        &["has 2 keyframes, at least 3"],
    );
    refused(
        &keyframes("{ phi_deg = 0 }, { phi_deg = 120 }, { phi_deg = 100 }"),
        &["motion.keyframes[3]", "does not increase"],
    );
    refused(
        &keyframes("{ phi_deg = 0 }, { phi_deg = 120 }, { phi_deg = 360 }"),
        &["motion.keyframes[3]", "less than one period"],
    );
    refused(
        &keyframes(
            "{ phi_deg = 0 }, { phi_deg = 120, quaternion = [0, 0, 0, 0] }, { phi_deg = 240 }",
        ),
        &["motion.keyframes[2]", "length zero"],
    );
    refused(
        &keyframes("{ phi_deg = 0 }, { phi_deg = 120, position = [0, 0, 1] }, { phi_deg = 240 }"),
        &["3R does not translate"],
    );
    let circle = |class: &str, more: &str, point: fn(f64) -> [f64; 3]| {
        let points: Vec<String> = (0..12)
            .map(|i| format!("{:?}", point(f64::from(i) * std::f64::consts::TAU / 12.0)))
            .collect();
        let motion = format!("kind = \"path\"\n{more}\npoints = [{}]", points.join(", "));
        with(class, &motion, "")
    };
    refused(
        &circle("3R", "", |a| [4.0 * a.cos(), 4.0 * a.sin(), 30.0 + a.sin()]),
        &["off the sphere around O", "motion.points["],
    );
    refused(
        &circle("3R", "radius_mm = 3", |a| [a.cos(), a.sin(), 30.0]),
        &["takes the radius from the points"],
    );
    refused(
        &circle("3R1T", "", |a| [a.cos(), a.sin(), 30.0]),
        &["motion.radius_mm", "missing"],
    );
    refused(
        &circle("1R1T", "", |a| [3.0 * a.cos(), a.sin(), 0.0]),
        &["cylinder around z"],
    );
    refused(
        &circle("1R", "own_turn = \"phi\"", |a| [a.cos(), -a.sin(), 0.0]),
        &["motion.own_turn"],
    );
    refused(
        &with("3R", "kind = \"path\"\npoints = [[1, 2, 3]]", ""),
        &["1 points, at least 6"],
    );
    let backwards = error(
        &circle("1R", "", |a| [a.cos(), a.sin(), 0.0]),
        Path::new("."),
    );
    assert_eq!(backwards.exit_code(), 3);
    contains(&backwards.to_string(), &["+1 turns"]);
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
