//! FreeCAD files of synthetic designs, judged by running FreeCAD.

mod synthetic;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use mpcgear::design::{Design, file};
use mpcgear::export::freecad::{self, Built, Headless};
use mpcgear::motion::{Class, Motion};
use mpcgear::solid::assembly::PrintPiece;
use mpcgear::solid::{Solids, section};

const BINARY: &str = env!("CARGO_BIN_EXE_mpcgear");
const DATE: &str = "2026-01-01";

/// Teeth per band of the tests' designs: enough to have neighbours, few enough for a quick FreeCAD.
const TEETH: usize = 2;

/// A synthetic design with its recipe, and its solids.
fn built(class: Class, teeth: usize) -> (Design, Solids) {
    built_with(class, teeth, |_| {})
}

/// The same of a design that is changed first.
fn built_with(class: Class, teeth: usize, change: impl FnOnce(&mut Design)) -> (Design, Solids) {
    let (mut design, motion) = synthetic::uniform(class);
    change(&mut design);
    with_teeth((design, motion), teeth)
}

fn with_teeth((mut design, motion): (Design, Motion), teeth: usize) -> (Design, Solids) {
    for pair in &mut design.sub_gear_pairs {
        pair.teeth.truncate(teeth);
    }
    let solids = Solids::build(&design, &motion).expect("builds");
    design.recipe = solids.recipe.clone();
    (design, solids)
}

/// Whether `program` runs; without it the test is skipped, unless MPCGEAR_REQUIRE_CAD=1.
fn is_here(program: &str, arguments: &[&str], name: &str) -> bool {
    let ran = Command::new(program).args(arguments).output();
    let found = ran.is_ok_and(|output| output.status.success());
    let required = std::env::var("MPCGEAR_REQUIRE_CAD").is_ok_and(|v| v == "1");
    assert!(found || !required, "{name} is not installed");
    if !found {
        eprintln!("skipped: {name} is not installed");
    }
    found
}

fn freecad_is_here() -> bool {
    is_here("freecadcmd", &["-c", "import os; os._exit(0)"], "FreeCAD")
}

/// A script of these tests.
fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/freecad_scripts")
        .join(name)
}

/// Runs the macro of a class and compares every part's volume with the embedded kernel's mesh.
fn macro_agrees_with_the_mesh(class: Class) {
    if freecad_is_here() {
        agree(class, built(class, TEETH));
    }
}

#[test]
fn a_driver_with_more_teeth_agrees_with_the_mesh() {
    if freecad_is_here() {
        agree(Class::R1, with_teeth(synthetic::unequal(Class::R1), TEETH));
    }
}

fn agree(class: Class, (design, solids): (Design, Solids)) {
    let folder = tempfile::tempdir().expect("folder");
    let headless = Headless {
        program: Path::new("freecadcmd"),
        folder: folder.path(),
        thorough: true,
    };
    let made = freecad::run(&design, DATE, &headless).expect("runs");
    assert_eq!(made.volumes.len(), solids.bodies.len());
    for body in &solids.bodies {
        let (_, volume) = made
            .volumes
            .iter()
            .find(|(name, _)| *name == body.name)
            .expect("part");
        let mesh = body.mesh.volume();
        let off = (volume - mesh).abs() / mesh;
        eprintln!(
            "{class} {}: FreeCAD {volume:.2}, mesh {mesh:.2}, {:.3} %",
            body.name,
            100.0 * off
        );
        assert!(
            off < 0.003,
            "{}: {volume} in FreeCAD, {mesh} as mesh",
            body.name
        );
    }
    another_kernel_reads_the_step(&design, &solids, &made);
}

/// Reads the STEP file with build123d: the same named parts, one valid solid each, in mm, in colours of
/// their own, below a root with the design's name; beside them the pieces to print.
fn another_kernel_reads_the_step(design: &Design, solids: &Solids, made: &Built) {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/python/bin/python3");
    let python = std::env::var("MPCGEAR_PYTHON").unwrap_or_else(|_| own.display().to_string());
    if !is_here(&python, &["-c", "import build123d"], "build123d") {
        return;
    }
    let output = Command::new(python)
        .arg(script("read_step.py"))
        .arg(&made.step)
        .output()
        .expect("starts");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut lines = text.lines();
    // build123d writes names with underscores.
    let root = design.name.replace(' ', "_");
    assert_eq!(lines.next(), Some(root.as_str()), "name of the root");
    let read: Vec<Vec<&str>> = lines.map(|l| l.split('\t').collect()).collect();
    let bodies = made
        .volumes
        .iter()
        .map(|(name, v)| (root.as_str(), name, *v, 1e-4));
    let split = |p: &&PrintPiece| solids.pieces.iter().filter(|q| q.body == p.body).count() > 1;
    let pieces = solids.pieces.iter().filter(split);
    let pieces = pieces.map(|p| ("pieces_to_print", &p.name, p.mesh.volume(), 0.006));
    let expected: Vec<_> = bodies.chain(pieces).collect();
    assert_eq!(read.len(), expected.len(), "{text}");
    for (assembly, name, volume, within) in expected {
        let found = read.iter().find(|row| row[..2] == [assembly, name]);
        let row = found.unwrap_or_else(|| panic!("{name} is missing: {text}"));
        assert_eq!(row[2..4], ["1", "True"], "{name}: one valid solid");
        let seen: f64 = row[4].parse().expect("volume");
        assert!(
            (seen - volume).abs() < within * volume,
            "{name}: {seen} instead of {volume}"
        );
    }
    let of_bodies = read.iter().filter(|row| row[0] == root);
    let colours: HashSet<&[&str]> = of_bodies.map(|row| &row[5..]).collect();
    assert_eq!(colours.len(), made.volumes.len(), "{text}");
}

#[test]
fn macro_of_1r_agrees_with_the_mesh() {
    macro_agrees_with_the_mesh(Class::R1);
}

#[test]
fn macro_of_flat_flanks_agrees_with_the_mesh() {
    if !freecad_is_here() {
        return;
    }
    agree(Class::R1, built_with(Class::R1, TEETH, flatten));
}

fn flatten(design: &mut Design) {
    for (pair, radius) in design.sub_gear_pairs.iter_mut().zip([2.5, 6.0]) {
        pair.flank_radius = Some(radius);
    }
}

#[test]
fn sketches_of_the_teeth_follow_every_parameter() {
    if !freecad_is_here() {
        return;
    }
    type Change = fn(&mut Design, f64);
    let radius = |k: usize| {
        [
            |d: &mut Design, x| d.sub_gear_pairs[0].flank_radius = Some(x),
            |d: &mut Design, x| d.sub_gear_pairs[1].flank_radius = Some(x),
        ][k]
    };
    let edits: [(&str, f64, Change); 8] = [
        ("clearance", 0.3, |d, x| d.section.clearance = x),
        ("thickness", 1.6, |d, x| d.section.thickness = x),
        ("tip", 0.6, |d, x| d.section.tip = x),
        ("root", 0.5, |d, x| d.section.root = x),
        ("rib", 0.9, |d, x| d.section.rib = x),
        ("flank_radius_1", 1.2, radius(0)),
        ("flank_radius_2", 3.0, radius(1)),
        ("flank_radius_2", 1.0, radius(1)),
    ];
    let (design, _) = built_with(Class::R1, 1, flatten);
    let expected = edits.map(|(alias, value, change)| {
        let mut changed = design.clone();
        change(&mut changed, value);
        let outlines = changed.sub_gear_pairs.iter().map(|pair| {
            let outline = section::polygon(&changed.section_of(pair), 4000);
            let corners = outline.iter().zip(outline.iter().cycle().skip(1));
            let area: f64 = corners
                .map(|(a, b)| 0.5 * (a[0] * b[1] - b[0] * a[1]))
                .sum();
            let high = outline.iter().map(|c| c[1]).fold(f64::MIN, f64::max);
            let low = outline.iter().map(|c| c[1]).fold(f64::MAX, f64::min);
            (area, (high, low))
        });
        let (areas, ends): (Vec<f64>, Vec<(f64, f64)>) = outlines.unzip();
        let (highs, lows): (Vec<f64>, Vec<f64>) = ends.into_iter().unzip();
        serde_json::json!([alias, value, areas, highs, lows])
    });
    let expected = serde_json::Value::from(expected.to_vec()).to_string();
    run_script("sections.py", &design, &[("MPCGEAR_EXPECTED", &expected)]);
}

#[test]
fn macro_of_1r1t_agrees_with_the_mesh() {
    macro_agrees_with_the_mesh(Class::R1T1);
}

#[test]
fn macro_of_3r_agrees_with_the_mesh() {
    macro_agrees_with_the_mesh(Class::R3);
}

#[test]
fn macro_of_3r1t_agrees_with_the_mesh() {
    macro_agrees_with_the_mesh(Class::R3T1);
}

/// Runs a script of these tests with the add-on on a design of `class`.
fn script_succeeds(name: &str, class: Class, teeth: usize) {
    if freecad_is_here() {
        run_script(name, &built(class, teeth).0, &[]);
    }
}

/// Links the add-on into FreeCAD's folder of add-ons below a home, as its README says.
fn install_addon(home: &Path) {
    let addons = home.join(".local/share/FreeCAD/Mod");
    std::fs::create_dir_all(&addons).expect("folder");
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("cad/freecad");
    std::os::unix::fs::symlink(own, addons.join("mpcgear")).expect("link");
}

fn run_script(name: &str, design: &Design, variables: &[(&str, &str)]) {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("design.json");
    std::fs::write(&path, file::text(design).expect("json")).expect("written");
    install_addon(folder.path());
    let mut freecad = Command::new("freecadcmd");
    freecad
        .arg(script(name))
        .env("MPCGEAR_DESIGN", &path)
        .envs(variables.iter().copied())
        .env("HOME", folder.path());
    succeeds(&mut freecad);
}

/// Runs a script, which tells what failed.
fn succeeds(freecad: &mut Command) {
    let output = freecad.output().expect("starts");
    assert!(
        output.status.success(),
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn addon_has_what_its_manager_asks_for() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let addon = root.join("cad/freecad");
    let text = std::fs::read_to_string(addon.join("package.xml")).expect("package.xml");
    let value = |tag: &str| -> Vec<String> {
        let (open, close) = (format!("<{tag}"), format!("</{tag}>"));
        let parts = text.split(&open).skip(1);
        let inner = parts.filter_map(|part| part.split_once('>')?.1.split_once(&close));
        inner.map(|(value, _)| value.to_string()).collect()
    };
    assert_eq!(value("version"), [env!("CARGO_PKG_VERSION")]);
    assert_eq!(value("freecadmin"), ["0.20.0"; 2]);
    for icon in value("icon") {
        assert!(addon.join(&icon).is_file(), "{icon}");
    }
    assert!(text.contains(r#"<url type="repository" branch="#), "{text}");
    for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
        assert!(text.contains(&format!(r#"<license file="{license}">"#)));
        let read = |folder: &Path| std::fs::read(folder.join(license)).expect(license);
        assert!(read(root) == read(&addon), "{license} is not the project's");
    }
}

#[test]
fn addon_opens_edits_drives_and_checks() {
    script_succeeds("addon.py", Class::R1, TEETH);
}

#[test]
fn what_is_built_on_a_hub_survives_changes() {
    script_succeeds("modelling.py", Class::R3, 1);
}

#[test]
fn every_option_changes_what_it_names() {
    script_succeeds("options.py", Class::R3, 1);
}

#[test]
fn a_motion_becomes_a_gear_and_a_redesign_keeps_what_was_built() {
    if freecad_is_here() {
        let design = built(Class::R1, 1).0;
        run_script("new_gear.py", &design, &[("MPCGEAR_BINARY", BINARY)]);
    }
}

#[test]
fn the_window_lives_while_a_gear_is_designed() {
    if !freecad_is_here() || !is_here("xvfb-run", &["-a", "true"], "xvfb") {
        return;
    }
    let home = tempfile::tempdir().expect("folder");
    install_addon(home.path());
    let mut freecad = Command::new("xvfb-run");
    freecad
        .args(["-a", "-s", "-screen 0 1600x1200x24", "freecad"])
        .arg(script("new_gear_window.py"))
        .env("MPCGEAR_BINARY", BINARY)
        .env("QTWEBENGINE_DISABLE_SANDBOX", "1")
        .env("LIBGL_ALWAYS_SOFTWARE", "1")
        .env("HOME", home.path());
    succeeds(&mut freecad);
}

#[test]
fn failure_is_reported_and_leaves_nothing() {
    if !freecad_is_here() {
        return;
    }
    let (mut design, _) = built(Class::R1, 1);
    let parameters = &mut design.recipe.parameters;
    for parameter in parameters
        .iter_mut()
        .filter(|p| p.name == "driver_hub_radius")
    {
        parameter.value = -1.0;
    }
    let folder = tempfile::tempdir().expect("folder");
    let headless = Headless {
        program: Path::new("freecadcmd"),
        folder: folder.path(),
        thorough: false,
    };
    let error = freecad::run(&design, DATE, &headless).expect_err("a negative radius fails");
    assert!(error.to_string().contains("Driver drum"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 0);
}

#[test]
fn macro_is_the_same_every_time_and_carries_its_header() {
    let (design, _) = built(Class::R1, 1);
    let text = freecad::macro_text(&design, DATE).expect("renders");
    assert_eq!(text, freecad::macro_text(&design, DATE).expect("renders"));
    let head: Vec<&str> = text.lines().take(16).collect();
    for field in [
        "Name", "Comment", "Author", "Date", "Version", "License", "Web", "Wiki", "Icon",
    ] {
        let found = head
            .iter()
            .any(|l| l.starts_with(&format!("__{field}__ = \"")));
        assert!(found, "__{field}__ is missing");
    }
    assert_eq!(freecad::stem(&design), "Synthetic1R");
}

#[test]
fn design_without_recipe_is_refused() {
    let (mut design, _) = built(Class::R1, 1);
    design.recipe.bodies.clear();
    assert!(freecad::macro_text(&design, DATE).is_err());
}
