//! Every parameter of the scripts, one by one: it changes what it names as much as it should, and
//! only that. The judge of the recipe's parameters is the embedded kernel, of the options arithmetic.

mod openscad_run;
mod synthetic;

use std::cell::RefCell;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use mpcgear::design::{Design, Section};
use mpcgear::export::{Source, format};
use mpcgear::motion::{Class, Motion};
use mpcgear::solid::{Mesh, Solids};
use openscad_run::{Run, installed};

/// Teeth per band: enough to see what the section's parameters do.
const TEETH: usize = 1;

/// Values of a parameter in OpenSCAD's words.
type Values<'a> = &'a [(&'a str, &'a str)];

/// Scripts of a small design, and what they were made from.
struct Bench {
    design: Design,
    motion: Motion,
    solids: Solids,
    folder: PathBuf,
    /// Bodies by the values that they were rendered with: the plain ones are needed again and again.
    seen: RefCell<HashMap<String, Mesh>>,
}

impl Bench {
    /// A bench of its own for each test, which is known by `name`.
    fn new(class: Class, name: &str) -> Bench {
        let (mut design, motion) = synthetic::uniform(class);
        for pair in &mut design.sub_gear_pairs {
            pair.teeth.truncate(TEETH);
        }
        let solids = Solids::build(&design, &motion).expect("builds");
        design.recipe = solids.recipe.clone();
        let source = Source {
            design: &design,
            motion: &motion,
            solids: Some(&solids),
        };
        let files = format::render(&source, format::Format::OpenScad, None).expect("renders");
        let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("parameters-{name}"));
        std::fs::create_dir_all(&out).expect("writable");
        for file in &files {
            std::fs::write(out.join(&file.path), &file.bytes).expect("writable");
        }
        Bench {
            design,
            motion,
            solids,
            folder: out,
            seen: RefCell::default(),
        }
    }

    fn run(&self, body: &str, values: Values) -> Run {
        let run = Run::new(&self.folder.join(format!("{body}.scad")));
        // The finest teeth, which are those of the embedded kernel.
        let run = match self.has(body, "quality") {
            true => run.set("quality", "\"fine\""),
            false => run,
        };
        values
            .iter()
            .fold(run, |run, (name, value)| run.set(name, value))
    }

    /// The one closed body that a script makes of these values.
    fn mesh(&self, body: &str, values: Values) -> Mesh {
        let label: Vec<String> = values.iter().map(|(n, v)| format!("{n}-{v}")).collect();
        let label = label.join("-").replace(['"', '.'], "_");
        let key = format!("{body} {label}");
        if let Some(mesh) = self.seen.borrow().get(&key) {
            return mesh.clone();
        }
        let mesh = self.run(body, values).stl(&label).one_closed_body();
        self.seen.borrow_mut().insert(key, mesh.clone());
        mesh
    }

    fn volume(&self, body: &str, values: Values) -> f64 {
        self.mesh(body, values).volume()
    }

    /// What OpenSCAD says against these values.
    fn refusal(&self, body: &str, values: Values) -> String {
        self.run(body, values).stl("refused").refusal()
    }

    fn has(&self, body: &str, parameter: &str) -> bool {
        let script = self.folder.join(format!("{body}.scad"));
        let text = std::fs::read_to_string(script).expect("a script");
        text.lines()
            .any(|line| line.starts_with(&format!("{parameter} = ")))
    }

    /// The embedded kernel's bodies of a changed design.
    fn rebuilt(&self, change: impl FnOnce(&mut Design)) -> Solids {
        let mut design = self.design.clone();
        change(&mut design);
        Solids::build(&design, &self.motion).expect("builds")
    }

    /// OpenSCAD and the embedded kernel change every body that has the parameter alike; the others
    /// do not change in the kernel, and have no such parameter in their scripts.
    fn agrees(&self, name: &str, value: f64, changed: &Solids) {
        let mut seen = false;
        for (old, new) in self.solids.bodies.iter().zip(&changed.bodies) {
            if !self.has(&old.name, name) {
                assert_eq!(old.mesh, new.mesh, "{name} also changes the {}", old.name);
                continue;
            }
            let mesh = self.mesh(&old.name, &[(name, &value.to_string())]);
            let plain = self.mesh(&old.name, &[]);
            let change = new.mesh.volume() - old.mesh.volume();
            let found = mesh.volume() - plain.volume();
            assert!(
                (found - change).abs() < 0.02 * change.abs() + 0.05,
                "{name} = {value}: the {} changes by {found:.3} mm³ instead of {change:.3}",
                old.name
            );
            let moved = box_change(&old.mesh, &new.mesh);
            let found = box_change(&plain, &mesh);
            for (found, moved) in found.iter().zip(moved) {
                assert!(
                    (found - moved).abs() < 2e-3,
                    "{name} = {value}: a face of the {}'s box moves by {found:.4}, not {moved:.4}",
                    old.name
                );
            }
            // Holes that only move leave volume and box as they are.
            seen |= old.mesh != new.mesh && plain != mesh;
        }
        let of_pieces = self.agrees_in_pieces(name, value, changed);
        assert!(seen || of_pieces, "{name} = {value} changes nothing");
    }

    /// The same for pieces whose bodies do not show the parameter; whether there are any.
    fn agrees_in_pieces(&self, name: &str, value: f64, changed: &Solids) -> bool {
        let mut seen = false;
        for (old, new) in self.solids.pieces.iter().zip(&changed.pieces) {
            let body = |solids: &Solids| {
                let found = solids.bodies.iter().find(|b| b.name == old.body);
                found.expect("a body").mesh.clone()
            };
            let change = new.mesh.volume() - old.mesh.volume();
            if change.abs() < 0.02 || body(&self.solids) != body(changed) {
                continue;
            }
            let (piece, value) = (format!("\"{}\"", old.name), value.to_string());
            let whole = ("piece", piece.as_str());
            let found =
                self.volume(&old.body, &[whole, (name, &value)]) - self.volume(&old.body, &[whole]);
            assert!(
                (found - change).abs() < 0.02 * change.abs() + 0.05,
                "{name} = {value}: {} changes by {found:.3} mm³ instead of {change:.3}",
                old.name
            );
            seen = true;
        }
        seen
    }

    /// Every free parameter of the recipe, halfway to the farther end of its range.
    fn recipe_parameters_agree(&self, groups: &[&str]) {
        let parameters = &self.design.recipe.parameters;
        for (i, p) in parameters.iter().enumerate() {
            if p.min >= p.max || !groups.contains(&p.group.as_str()) {
                continue;
            }
            let bodies = &self.solids.bodies;
            if !bodies.iter().any(|body| self.has(&body.name, &p.name)) {
                continue;
            }
            let end = match p.max - p.value > p.value - p.min {
                true => p.max,
                false => p.min,
            };
            let value = (5e3 * (p.value + end)).round() / 1e4;
            let changed = self.rebuilt(|d| d.recipe.parameters[i].value = value);
            eprintln!("{} = {value}", p.name);
            self.agrees(&p.name, value, &changed);
        }
    }

    fn section_agrees(&self, name: &str, value: f64, change: impl FnOnce(&mut Section)) {
        let changed = self.rebuilt(|d| change(&mut d.section));
        self.agrees(name, value, &changed);
    }
}

/// How far the six faces of the bounding box move.
fn box_change(old: &Mesh, new: &Mesh) -> [f64; 6] {
    let ((a, b), (c, d)) = (old.bounds(), new.bounds());
    let (low, high) = (c - a, d - b);
    [low.x, low.y, low.z, high.x, high.y, high.z]
}

/// Area of the regular polygon that stands for a circle with 24 or 48 corners.
fn disc(radius: f64) -> f64 {
    let n = if radius < 2.5 { 24.0 } else { 48.0 };
    0.5 * n * radius * radius * (TAU / n).sin()
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() < tolerance,
        "{what}: {found:.3} instead of {expected:.3}"
    );
}

#[test]
fn every_parameter_of_1r_changes_what_it_names() {
    if installed() {
        let bench = Bench::new(Class::R1, "1r");
        bench.recipe_parameters_agree(&["Fit", "Hub", "Support", "Joint"]);
    }
}

#[test]
fn every_parameter_of_the_joint_of_3r1t_changes_what_it_names() {
    if installed() {
        Bench::new(Class::R3T1, "3r1t").recipe_parameters_agree(&["Joint"]);
    }
}

#[test]
fn every_parameter_of_the_joint_of_3r_changes_what_it_names() {
    if installed() {
        Bench::new(Class::R3, "3r").recipe_parameters_agree(&["Joint"]);
    }
}

#[test]
fn quality_refines_the_teeth_and_nothing_else() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R1, "quality");
    for body in ["driver", "follower"] {
        let made = ["draft", "normal", "fine"].map(|quality| {
            let script = bench.folder.join(format!("{body}.scad"));
            let run = Run::new(&script).set("quality", &format!("\"{quality}\""));
            run.stl(quality).one_closed_body()
        });
        let [draft, normal, fine] = &made;
        assert!(draft.triangles.len() < normal.triangles.len());
        assert!(normal.triangles.len() < fine.triangles.len());
        for rough in [draft, normal] {
            close(rough.volume() / fine.volume(), 1.0, 5e-3, body);
            for moved in box_change(fine, rough) {
                close(moved, 0.0, 0.1, body);
            }
        }
    }
    assert!(!bench.has("support", "quality"), "a support has no teeth");
}

#[test]
fn every_parameter_of_the_section_changes_the_teeth() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R1, "section");
    bench.section_agrees("tooth_thickness", 1.6, |s| s.thickness = 1.6);
    bench.section_agrees("flank_radius", 0.7, |s| s.flank_radius = 0.7);
    bench.section_agrees("tooth_tip", 0.6, |s| s.tip = 0.6);
    bench.section_agrees("tooth_root", 0.3, |s| s.root = 0.3);
    bench.section_agrees("clearance", 0.3, |s| s.clearance = 0.3);
    bench.section_agrees("rib_thickness", 1.0, |s| s.rib = 1.0);
}

#[test]
fn spokes_taper_have_fillets_and_webs() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R3T1, "spokes");
    for gear in ["driver", "follower"] {
        let plain = bench.volume(gear, &[]);
        let tapered = bench.volume(gear, &[("spokes", "\"tapered\"")]);
        assert!(tapered > plain + 0.2, "{gear}: {tapered} after {plain}");
        let slim: Values = &[("spokes", "\"tapered\""), ("rib_foot_thickness", "1.5")];
        let slim = bench.volume(gear, slim);
        assert!(plain < slim && slim < tapered, "{gear}: {slim}");
        let fillet = bench.volume(gear, &[("rib_fillet", "0.2")]);
        assert!(fillet > plain + 0.1, "{gear}: {fillet} after {plain}");

        // A disc per sub-gear pair around a smaller hub, less what ribs and teeth fill already.
        let hub = format!("{gear}_hub_radius");
        let web = format!("{gear}_web_radius");
        let range = bench
            .design
            .recipe
            .parameters
            .iter()
            .find(|p| p.name == hub);
        let range = range.expect("a hub");
        let (inner, outer) = (range.min, range.min + 0.6 * (range.max - range.min));
        let (small, large) = (inner.to_string(), outer.to_string());
        let values = [
            (hub.as_str(), small.as_str()),
            ("spokes", "\"webbed\""),
            (web.as_str(), large.as_str()),
            ("spoke_web_thickness", "2"),
        ];
        let bare = bench.volume(gear, &values[..1]);
        let webbed = bench.volume(gear, &values);
        let bands = bench.design.sub_gear_pairs.len() as f64;
        let full = bands * 2.0 * PI * (outer * outer - inner * inner);
        let share = (webbed - bare) / full;
        assert!((0.75..1.0).contains(&share), "{gear}: {share} of the discs");
        let said = bench.refusal(gear, &[("spokes", "\"webbed\"")]);
        assert!(said.contains(&hub) && said.contains(&web), "{said}");
    }
}

#[test]
fn bores_of_the_driver_are_as_large_as_they_say() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R1, "bores");
    let plain = bench.volume("driver", &[]);
    let removed = |values: Values| plain - bench.volume("driver", values);
    // Bore 3 mm, 0.1 mm of gap all around, 10 mm deep.
    let (radius, depth) = (1.6, 10.0);
    let round = depth * disc(radius);
    close(removed(&[("bore", "\"round\"")]), round, 0.2, "round");
    let d_shape = |radius: f64, flat: f64| {
        let angle = ((radius - flat) / radius).acos();
        let segment = radius * radius * (angle - angle.sin() * angle.cos());
        depth * (disc(radius) - segment)
    };
    let d = d_shape(radius, 0.5);
    close(removed(&[("bore", "\"d_shape\"")]), d, 0.6, "D");
    let hexagon = depth * 2.0 * 3f64.sqrt() * radius * radius;
    close(removed(&[("bore", "\"hexagon\"")]), hexagon, 0.2, "hexagon");
    let teeth = 25.0;
    let spline = depth * teeth * radius * 0.93 * radius * (PI / teeth).sin();
    close(removed(&[("bore", "\"spline\"")]), spline, 0.2, "spline");

    let with = |name: &'static str, value: &'static str, kind: &'static str| {
        removed(&[("bore", kind), (name, value)])
    };
    close(
        with("bore_diameter", "4", "\"round\""),
        depth * disc(2.1),
        0.2,
        "diameter",
    );
    close(
        with("bore_depth", "6", "\"round\""),
        6.0 * disc(1.6),
        0.2,
        "depth",
    );
    close(
        with("bore_fit", "0.3", "\"round\""),
        depth * disc(1.8),
        0.2,
        "fit",
    );
    let coarse = depth * 8.0 * radius * 0.93 * radius * (PI / 8.0).sin();
    close(
        with("bore_teeth", "8", "\"spline\""),
        coarse,
        0.2,
        "serrations",
    );
    let shallow = d_shape(radius, 0.3);
    close(
        with("bore_flat", "0.3", "\"d_shape\""),
        shallow,
        0.6,
        "flat",
    );
    let nema = d_shape(2.6, 0.5);
    close(
        removed(&[("bore_preset", "\"nema17\"")]),
        nema,
        0.6,
        "NEMA 17",
    );

    for (values, words) in [
        ([("bore", "\"round\""), ("bore_diameter", "7")], "leaves"),
        (
            [("bore", "\"round\""), ("bore_diameter", "50")],
            "out of range: 1 to 40",
        ),
        (
            [("bore", "\"oval\""), ("bore_diameter", "5")],
            "must be one of",
        ),
        ([("bore", "\"round\""), ("keyway", "true")], "6 to 44 mm"),
        (
            [("bore", "\"round\""), ("set_screw", "\"M3\"")],
            "no room for the nut",
        ),
    ] {
        let said = bench.refusal("driver", &values);
        assert!(said.contains(words), "{values:?}: {said}");
    }
}

#[test]
fn the_mount_carries_a_boss_with_bore_keyway_and_set_screw() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R3T1, "boss");
    let plain = bench.mesh("follower", &[]);
    let boss: Values = &[("boss_height", "10"), ("boss_radius", "7.5")];
    let with_boss = bench.mesh("follower", boss);
    close(box_change(&plain, &with_boss)[5], 10.0, 1e-3, "height");
    let with = |more: Values| with_boss.volume() - bench.volume("follower", &[boss, more].concat());
    let bore: Values = &[("boss_bore", "\"round\""), ("boss_bore_diameter", "8")];
    close(with(bore), 10.0 * disc(4.1), 0.3, "bore of the boss");
    // DIN 6885: 2 mm wide for shafts up to 8 mm, 1 mm deep in the hub.
    let keyed = with(&[bore, &[("boss_keyway", "true")]].concat()) - with(bore);
    assert!((2.0 * 10.0..2.3 * 10.0).contains(&keyed), "keyway: {keyed}");
    let narrow: Values = &[("boss_bore", "\"round\"")];
    let screw = with(&[narrow, &[("boss_set_screw", "\"M3\"")]].concat()) - with(narrow);
    // At least the pocket of the nut, 5.9 × 2.8 mm and half the boss high.
    assert!(screw > 5.9 * 2.8 * 5.0, "set screw: {screw}");
    for (values, words) in [
        (bore, "needs a boss"),
        (
            &[("boss_radius", "15"), ("boss_height", "5")] as Values,
            "mount_radius",
        ),
    ] {
        let said = bench.refusal("follower", values);
        assert!(said.contains(words), "{values:?}: {said}");
    }
}

#[test]
fn the_support_has_feet_bearings_and_pieces() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R3, "support");
    let plain = bench.mesh("support", &[]);
    let feet = bench.mesh("support", &[("feet_height", "5"), ("feet_radius", "3")]);
    close(box_change(&plain, &feet)[2], -5.0, 1e-3, "feet");
    let added = feet.volume() - plain.volume();
    close(added, 4.0 * 5.0 * disc(3.0), 0.5, "feet");

    // Without a seat the eye grows by what the seat takes out again, twice.
    let room: Values = &[("journal_radius", "2.5"), ("bearing_wall", "3.9")];
    let eye = bench.volume("support", room);
    let seat: Values = &[("bearing", "\"MR105\""), ("bearing_fit", "0.1")];
    let seated = bench.volume("support", &[room, seat].concat());
    let seats = 2.0 * 4.0 * (disc(5.1) - disc(2.65));
    close(eye - seated, seats, 0.5, "seats of MR105");
    let said = bench.refusal("support", seat);
    assert!(said.contains("needs journal_radius = 2.5"), "{said}");

    for piece in bench.solids.pieces.iter().filter(|p| p.body == "support") {
        let name = format!("\"{}\"", piece.name);
        let values: Values = &[("piece", &name), ("layout", "\"print\"")];
        let printed = bench.mesh("support", values);
        close(printed.bounds().0.z, 0.0, 1e-4, "the bed");
        let share = printed.volume() / piece.mesh.volume();
        close(share, 1.0, 1e-3, &piece.name);
        let size = printed.bounds().1 - printed.bounds().0;
        let wanted = piece.mesh.bounds().1 - piece.mesh.bounds().0;
        close(size.z, wanted.z, 1e-3, &piece.name);
    }
}

#[test]
fn printing_lays_parts_down_and_pulls_their_feet_in() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R1, "print");
    let lying: Values = &[("layout", "\"print\"")];
    for body in ["driver", "follower"] {
        let (plain, flat) = (bench.mesh(body, &[]), bench.mesh(body, lying));
        close(flat.bounds().0.z, 0.0, 1e-4, "the bed");
        close(flat.volume(), plain.volume(), 0.05, body);
        let foot = bench.mesh(body, &[lying, &[("elephant_foot", "0.3")]].concat());
        close(box_change(&flat, &foot)[2], 0.0, 1e-4, "the bed");
        let lost = flat.volume() - foot.volume();
        // The outline of the lower journal (radius 4) or of the drum, 0.3 wide and high.
        assert!((1.0..20.0).contains(&lost), "{body}: {lost} mm³ of foot");
    }
}

#[test]
fn every_parameter_set_works_on_every_part() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R1, "sets");
    let sets = bench.folder.join("parameters.json");
    let text = std::fs::read_to_string(&sets).expect("sets");
    let page: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let names = page["parameterSets"].as_object().expect("sets");
    for name in ["draft", "sla", "fdm_0.4", "motor_nema17", "bearings_mr105"] {
        assert!(names.contains_key(name), "{name} is missing");
    }
    for (name, values) in names {
        assert!(
            values
                .as_object()
                .expect("values")
                .values()
                .all(|v| v.is_string())
        );
        for body in &bench.solids.bodies {
            let script = bench.folder.join(format!("{}.scad", body.name));
            let run = Run::new(&script).set_of(&sets, name);
            run.stl(&format!("set-{name}")).one_closed_body();
        }
    }
}
