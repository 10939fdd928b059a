//! `design.json` as input: what is no design is refused by every command, with its field.

mod known;

use std::path::Path;

use mpcgear::Error;
use mpcgear::design::{Design, Station, Stored, file, is_name};
use mpcgear::export::Source;
use mpcgear::export::format::{self, Format};
use mpcgear::motion::Class;
use mpcgear::solid::Solids;
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
use serde_json::{Value, json};

/// A sound design with its recipe.
fn revolute() -> Design {
    let mut design = known::revolute();
    design.sub_gear_pairs[0].flank_radius = Some(1.5);
    design.recipe = Solids::build(&design, &known::motion(Class::R1))
        .expect("builds")
        .recipe;
    design
}

/// The same as it stands in the file.
fn sound() -> Value {
    let text = file::text(&revolute()).expect("text");
    serde_json::from_str(&text).expect("json")
}

/// `design` as the first format had it: every station in all three frames, no velocities.
fn first_format(design: &Design) -> Value {
    let mut value = serde_json::to_value(design).expect("json");
    value["format"] = json!(1);
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        for (j, tooth) in pair.teeth.iter().enumerate() {
            let rows = tooth.stations.iter().map(|s| {
                json!({"phi": s.phi, "p": s.p, "n": s.n, "p1": s.p1, "n1": s.n1, "t1": s.t1,
                    "p2": s.p2, "n2": s.n2, "t2": s.t2})
            });
            value["sub_gear_pairs"][k]["teeth"][j]["stations"] = rows.collect();
        }
    }
    value
}

#[test]
fn a_design_is_the_same_after_it_was_written_and_read() {
    let mut design = revolute();
    design.closure[3].q = f64::NEG_INFINITY;
    let text = file::text(&design).expect("text");
    let read = Stored::parse(text.as_bytes(), Path::new("design.json")).expect("reads");
    assert_eq!(read.design, design);
}

/// What README.md tells other programs: the gears' frames from p, n, v and `poses` alone.
#[test]
fn other_programs_find_the_gears_frames_in_the_file() {
    let design = known::spherical();
    let text = file::text(&design).expect("text");
    let json: Value = serde_json::from_str(&text).expect("json");
    let numbers = |value: &Value| -> Vec<f64> {
        let list = value.as_array().expect("a list").iter();
        list.map(|x| x.as_f64().expect("a number")).collect()
    };
    let axis = Vector3::new(-known::L, 0.0, 0.0);
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        for (j, tooth) in pair.teeth.iter().enumerate() {
            for (i, s) in tooth.stations.iter().enumerate() {
                let kept = &json["sub_gear_pairs"][k]["teeth"][j]["stations"][i];
                let [p, n, v] = ["p", "n", "v"].map(|name| Vector3::from_vec(numbers(&kept[name])));
                let pose = numbers(&json["poses"][j][i]);
                assert_eq!((kept["phi"].as_f64(), pose[0]), (Some(s.phi), s.phi));
                let driver = Rotation3::from_axis_angle(&Vector3::z_axis(), s.phi).inverse();
                let follower = Quaternion::new(pose[7], pose[4], pose[5], pose[6]);
                let follower = UnitQuaternion::from_quaternion(follower).inverse();
                let slide = v - Vector3::z().cross(&(p - axis));
                let c = Vector3::from_column_slice(&pose[1..4]);
                for (found, is) in [
                    (driver * (p - axis) + axis, s.p1),
                    (-(driver * n), s.n1),
                    ((driver * slide).normalize(), s.t1),
                    (follower * (p - c), s.p2),
                    (follower * n, s.n2),
                ] {
                    assert!((found - Vector3::from(is)).norm() < 1e-10, "{found} {is:?}");
                }
            }
        }
    }
}

#[test]
fn curves_have_every_station_in_all_frames() {
    let design = revolute();
    let motion = known::motion(Class::R1);
    let solids = Solids::build(&design, &motion).expect("builds");
    let source = Source {
        design: &design,
        motion: &motion,
        solids: Some(&solids),
    };
    let files = format::render(&source, Format::Curves, None).expect("csv");
    let rows: Vec<Vec<f64>> = csv::Reader::from_reader(files[0].bytes.as_slice())
        .deserialize()
        .map(|row| row.expect("a row of numbers"))
        .collect();
    assert_eq!(rows.len(), 2 * 10 * 25);
    let (row, s) = (&rows[260], &design.sub_gear_pairs[1].teeth[0].stations[10]);
    assert_eq!((row[0], row[1]), (2.0, 1.0));
    let vectors = [s.p, s.n, s.p1, s.n1, s.t1, s.p2, s.n2, s.t2];
    for (found, is) in row[3..].iter().zip(vectors.iter().flatten()) {
        assert!((found - is).abs() < 1e-12, "{found} {is}");
    }
}

#[test]
fn the_first_format_is_still_read() {
    let design = revolute();
    let text = first_format(&design).to_string();
    let read = Stored::parse(text.as_bytes(), Path::new("design.json")).expect("reads");
    let stations = |d: &Design| -> Vec<Station> {
        let teeth = d.sub_gear_pairs.iter().flat_map(|pair| &pair.teeth);
        teeth.flat_map(|t| t.stations.clone()).collect()
    };
    for (old, new) in stations(&read.design).iter().zip(stations(&design)) {
        assert_eq!(Station { v: new.v, ..*old }, new);
        for (a, b) in old.v.iter().zip(new.v) {
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }
    assert_eq!(read.design.recipe, design.recipe);
    let again = file::text(&read.design).expect("text");
    assert!(Stored::parse(again.as_bytes(), Path::new("design.json")).is_ok());
}

#[test]
fn a_station_needs_its_speed_and_format_1_its_places_on_the_gears() {
    let stations = "/sub_gear_pairs/0/teeth/2/stations/3";
    let mut second = sound();
    second
        .pointer_mut(stations)
        .and_then(Value::as_object_mut)
        .expect("a station")
        .remove("v");
    assert!(refusal(second.to_string().as_bytes()).contains("teeth[2].stations[3].v"));
    let mut first = first_format(&revolute());
    first
        .pointer_mut(stations)
        .and_then(Value::as_object_mut)
        .expect("a station")
        .remove("t2");
    assert!(refusal(first.to_string().as_bytes()).contains("teeth[2].stations[3].t2"));
    // The driver's own speed: the contact does not move over the driver.
    let mut still = sound();
    let place = still.pointer_mut(stations).expect("a station");
    let [x, y] = [0, 1].map(|i| place["p"][i].as_f64().expect("a number"));
    place["v"] = json!([-y, x + known::L, 0.0]);
    assert!(refusal(still.to_string().as_bytes()).contains("stands still"));
}

/// All problems of the design as one text; panics when it is accepted.
fn refusal(bytes: &[u8]) -> String {
    let error = Stored::parse(bytes, Path::new("some/design.json")).expect_err("refused");
    assert!(matches!(error, Error::Input { .. }), "{error:?}");
    assert_eq!(error.exit_code(), 2);
    error.to_string()
}

#[test]
fn every_value_out_of_range_is_named_with_what_is_allowed() {
    let base = sound();
    assert!(Stored::parse(base.to_string().as_bytes(), Path::new("d")).is_ok());
    let feature = base["recipe"]["bodies"][0]["features"][0].clone();
    let prism = |sides: u64| {
        json!({"name": "nut", "operation": "cut", "shape": {"prism": {"base": ["0", "0", "0"],
            "axis": [0.0, 0.0, 1.0], "length": "1", "width": "2", "sides": sides}}})
    };
    let ball = |radius: &str| {
        json!({"name": "ball", "operation": "add",
            "shape": {"ball": {"center": ["0", "0", "0"], "radius": radius}}})
    };
    let support = "/recipe/bodies/2";
    let of = |rest: &str| format!("{support}{rest}");
    let tooth = "/sub_gear_pairs/1/teeth/3";
    let cases: Vec<(String, Value, &[&str])> = vec![
        ("/format".into(), json!(7), &["format: is 7"]),
        (
            "/settings/hub/mount_holes".into(),
            json!(1_000_000_000),
            &["hub.mount_holes", "allowed 0 to 24"],
        ),
        (
            "/settings/gear/teeth".into(),
            json!(1_000_000_000_000_000_000_u64),
            &["gear.teeth", "allowed 3 to 60"],
        ),
        (
            "/settings/gear/teeth".into(),
            json!(-1),
            &["settings.gear.teeth", "invalid value"],
        ),
        (
            "/settings/gear/teeth".into(),
            json!(9),
            &["sub_gear_pairs[0]: has 10 teeth"],
        ),
        ("/class".into(), json!("4R"), &["class: unknown variant"]),
        ("/name".into(), json!("\u{1b}[2J"), &["name:", "control"]),
        (
            "/section/flank_radius".into(),
            json!(1e9),
            &["section.flank_radius", "allowed 0 to 25"],
        ),
        (
            "/sub_gear_pairs/0/flank_radius".into(),
            json!(1e9),
            &["sub_gear_pairs[0].flank_radius", "allowed 0 to 25"],
        ),
        (
            "/closure".into(),
            json!(vec![
                json!({"phi": 0, "q": 1, "q_star": 1, "eta": 1});
                70_000
            ]),
            &["closure: has 70000 entries"],
        ),
        (
            tooth.to_string() + "/stations",
            json!([]),
            &["sub_gear_pairs[1].teeth[3].stations: are 0, allowed 5 to 1001"],
        ),
        (
            tooth.to_string() + "/stations/4/n/0",
            json!(7.0),
            &["length of sub_gear_pairs[1].teeth[3].stations[4].n"],
        ),
        (
            tooth.to_string() + "/stations/4/p/0",
            json!(1e300),
            &["stations[4]", "allowed -50000 to 50000"],
        ),
        (
            tooth.to_string() + "/stations/4/phi",
            json!(9.0),
            &["phi that do not increase"],
        ),
        (
            "/recipe/bodies/0/features/0".into(),
            prism(4_000_000_000),
            &["features[0].sides: is 4000000000, allowed 3 to 360"],
        ),
        (
            "/recipe/bodies/0/features/0".into(),
            prism(0),
            &["sides: is 0"],
        ),
        (
            "/recipe/bodies/0/features/0".into(),
            ball("1e9"),
            &["radius", "has `e`"],
        ),
        (
            "/recipe/bodies/0/features/0".into(),
            ball("0 - 1"),
            &["radius: is -1"],
        ),
        (
            "/recipe/bodies/0/features/0".into(),
            ball("missing"),
            &["names `missing`"],
        ),
        (
            "/recipe/bodies/0/features/0".into(),
            ball(&("1+".repeat(100_000) + "1")),
            &["radius", "allowed 1000"],
        ),
        (
            "/recipe/bodies/0/features/0".into(),
            ball(&"(".repeat(900)),
            &["nested deeper"],
        ),
        (
            "/recipe/bodies/0/features/0/name".into(),
            json!("a*/ echo(1); /*"),
            &["features[0].name", "letters"],
        ),
        (
            "/recipe/bodies/0/features".into(),
            json!(vec![feature; 2000]),
            &["recipe.bodies[0].features: has 2000 entries, allowed 200"],
        ),
        (
            "/recipe/bodies/0/name".into(),
            json!("../victim"),
            &["recipe.bodies[0].name", "../victim"],
        ),
        (
            "/recipe/bodies/1/name".into(),
            json!("driver"),
            &["recipe.bodies[1].name", "once"],
        ),
        (
            of("/pieces/0/name"),
            json!("../victim"),
            &["name of a piece", "../victim"],
        ),
        (
            of("/pieces/0/name"),
            json!("/etc/passwd"),
            &["name of a piece"],
        ),
        (of("/pieces/0/name"), json!(""), &["name of a piece"]),
        (
            of("/pieces/0/name"),
            json!("x".repeat(65)),
            &["name of a piece"],
        ),
        (
            of("/pieces/0/name"),
            base["recipe"]["bodies"][2]["pieces"][1]["name"].clone(),
            &["each name once"],
        ),
        (
            of("/pieces/0/up"),
            json!([0.0, 0.0, 0.0]),
            &["pieces[0].up"],
        ),
        (
            "/recipe/parameters/3/name".into(),
            json!("a b"),
            &["recipe.parameters[3].name"],
        ),
        (
            "/recipe/parameters/3/group".into(),
            json!("*/ echo(1); /*"),
            &["recipe.parameters[3].group"],
        ),
        (
            "/recipe/parameters/3/value".into(),
            json!(1e7),
            &["recipe.parameters[3].value"],
        ),
        (
            "/motion".into(),
            json!({"kind": "spiral"}),
            &["motion", "spiral"],
        ),
    ];
    for (place, value, wanted) in cases {
        let mut design = base.clone();
        *design.pointer_mut(&place).expect("a place") = value;
        let text = refusal(design.to_string().as_bytes());
        for part in wanted {
            assert!(text.contains(part), "{place}: {text}");
        }
        assert!(
            text.len() < 10_000,
            "{place}: {} bytes of message",
            text.len()
        );
    }
}

#[test]
fn all_problems_are_told_at_once_and_the_rest_counted() {
    let mut design = sound();
    for field in ["mount_radius_mm", "shaft_end_mm"] {
        design["settings"]["hub"][field] = json!(-5);
    }
    for station in design["sub_gear_pairs"][0]["teeth"][0]["stations"]
        .as_array_mut()
        .expect("stations")
    {
        station["n"] = json!([0.0, 0.0, 0.0]);
    }
    let text = refusal(design.to_string().as_bytes());
    for part in [
        "hub.mount_radius_mm: is -5",
        "hub.shaft_end_mm: is -5",
        "stations[0].n",
        "… and 8 more",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn what_is_no_json_of_ours_is_refused() {
    let deep = "[".repeat(100_000);
    let text = sound().to_string();
    for bytes in [
        b"".as_slice(),
        b"{}",
        b"[1, 2]",
        b"\xff\xfe",
        deep.as_bytes(),
        &text.as_bytes()[..text.len() / 2],
    ] {
        refusal(bytes);
    }
}

#[test]
fn names_that_become_paths_are_a_whitelist() {
    for good in ["driver", "socket_cap", "piece-2", &"x".repeat(64)] {
        assert!(is_name(good), "{good}");
    }
    for bad in [
        "",
        ".",
        "..",
        "a/b",
        "a\\b",
        "A",
        "a b",
        "ä",
        "a\n",
        "con.",
        &"x".repeat(65),
    ] {
        assert!(!is_name(bad), "{bad:?}");
    }
}

/// Every command that takes a design, on the file `name` in `folder`: exit code 2 and `wanted`.
fn all_commands_refuse(folder: &Path, name: &str, wanted: &str) {
    for arguments in [
        &["check", name][..],
        &["load", name],
        &["export", name, "--to", "3mf", "-o", "out"],
        &["report", name],
        &["compare", name, name, "-o", "out.html"],
        &["stats", name],
    ] {
        let output = assert_cmd::Command::new(env!("CARGO_BIN_EXE_mpcgear"))
            .current_dir(folder)
            .args(arguments)
            .timeout(std::time::Duration::from_secs(60))
            .output()
            .expect("runs");
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(text.contains(wanted), "{arguments:?}: {text}");
    }
    let left: Vec<_> = std::fs::read_dir(folder).expect("a folder").collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn every_command_reads_a_design_in_the_same_way() {
    let with = |change: &dyn Fn(&mut Value)| {
        let folder = tempfile::tempdir().expect("a folder");
        let mut design = sound();
        change(&mut design);
        std::fs::write(folder.path().join("design.json"), design.to_string()).expect("written");
        folder
    };
    let other = with(&|d| d["format"] = json!(99));
    all_commands_refuse(other.path(), "design.json", "format: is 99");
    let holes = with(&|d| d["settings"]["hub"]["mount_holes"] = json!(1_000_000_000));
    all_commands_refuse(holes.path(), "design.json", "hub.mount_holes");
    let large = with(&|_| ());
    let file = std::fs::File::options()
        .write(true)
        .open(large.path().join("design.json"));
    file.expect("opens").set_len(201_000_000).expect("grows");
    all_commands_refuse(large.path(), "design.json", "200 MB");
    #[cfg(unix)]
    {
        let pipe = tempfile::tempdir().expect("a folder");
        let made = std::process::Command::new("mkfifo")
            .arg(pipe.path().join("design.json"))
            .status();
        assert!(made.expect("mkfifo runs").success());
        all_commands_refuse(pipe.path(), "design.json", "regular file");
    }
}
