//! Motions that are none, or not of their class, or not a gear's.

use std::path::Path;

use crate::{contains, error, refused, rows, table, table_refused, with};

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
    for name in ["phi", "pi", "deg", "sin", "e"] {
        formula(
            "1R",
            &format!("constants = {{ {name} = \"1\" }}"),
            &[
                &format!("motion.constants.{name}"),
                "meaning in formulas already",
            ],
        );
    }
    let long = ["cos(phi)"; 1500].join("+");
    let axis = format!("axis = [\"{long}\", \"0\", \"1\"]\n");
    let long =
        format!("{axis}translation = [\"{long}\", \"{long}\", \"{long}\"]\nown_turn = \"{long}\"");
    let more = ["sin(phi)"; 2000].join("+");
    let constants = format!("constants = {{ a = \"{more}\", b = \"{more}\" }}\n");
    formula(
        "3R",
        &(constants + &long),
        &["formulas have 1", "allowed 100000"],
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
