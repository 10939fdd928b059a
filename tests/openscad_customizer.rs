//! The one file for sites that customise: small, plain, alone, and the same parts as the files of their own.

mod openscad_bench;
mod openscad_run;
mod synthetic;

use mpcgear::export::{Source, format};
use mpcgear::motion::Class;
use mpcgear::solid::Mesh;
use openscad_bench::{Bench, close};
use openscad_run::{Run, installed, manifold};

/// What sites take, bytes.
const LARGEST: usize = 400_000;

/// The customiser file of a design of that name.
fn text_of(class: Class, name: &str) -> String {
    let render = |source: &Source| format::render(source, format::Format::OpenScad, None);
    let files = synthetic::with_source(class, name, render).expect("renders");
    let file = files
        .into_iter()
        .find(|f| f.path.ends_with("customizer.scad"));
    String::from_utf8(file.expect("a customiser file").bytes).expect("text")
}

#[test]
fn it_is_small_plain_and_needs_no_other_file() {
    for class in Class::ALL {
        let text = text_of(class, "Trèfle à quatre 葉 */ [x]");
        assert!(text.len() <= LARGEST, "{class}: {} bytes", text.len());
        assert!(text.is_ascii(), "{class}");
        let needs = |line: &&str| line.starts_with("include") || line.starts_with("use");
        assert_eq!(text.lines().find(needs), None, "{class}");
        // Parameters end at the first brace, which no string may hold.
        let parameters = text.split("/* [Hidden] */").next().expect("text");
        assert!(!parameters.contains('{'), "{class}");
        for body in ["driver", "follower", "support"] {
            assert!(
                parameters.contains(&format!("{body}_color = \"#")),
                "{class}"
            );
        }
        let plates = if class == Class::R3T1 { 4 } else { 3 };
        for plate in 1..=plates {
            assert!(text.contains(&format!("module mw_plate_{plate}() {{")));
        }
        assert!(!text.contains(&format!("mw_plate_{}", plates + 1)));
        assert!(text.contains("module mw_assembly_view() {"));
    }
}

/// The parts of the one file and of the files of their own, made by OpenSCAD, are the same.
fn agrees(bench: &Bench, command: Option<&[String]>) {
    let run = |file: &str| {
        let script = bench.folder.join(file);
        command.map_or_else(|| Run::new(&script), |command| Run::with(command, &script))
    };
    let same = |a: &Mesh, b: &Mesh, what: &str| {
        close(a.volume() / b.volume(), 1.0, 1e-6, what);
        let ((low, high), (from, to)) = (a.bounds(), b.bounds());
        assert!((low - from).norm() + (high - to).norm() < 1e-3, "{what}");
    };
    for body in &bench.solids.bodies {
        let name = &body.name;
        let alone = run(&format!("{name}.scad")).stl("alone").one_closed_body();
        let part = run("customizer.scad").set("part", &format!("\"{name}\""));
        let part = part.stl(name).one_closed_body();
        same(&part, &alone, name);
        close(part.volume() / body.mesh.volume(), 1.0, 5e-3, name);
    }
    for piece in &bench.solids.pieces {
        let name = &piece.name;
        let part = run("customizer.scad")
            .set("part", &format!("\"{name}\""))
            .set("layout", "\"print\"");
        let part = part.stl(name).one_closed_body();
        close(part.bounds().0.z, 0.0, 1e-4, name);
        close(part.volume() / piece.mesh.volume(), 1.0, 5e-3, name);
    }
}

#[test]
fn its_parts_are_those_of_the_other_files() {
    if installed() {
        agrees(&Bench::new(Class::R1, "customizer"), None);
    }
}

#[test]
fn its_parts_are_those_of_the_other_files_with_manifold() {
    let Some(command) = manifold() else {
        return;
    };
    for class in Class::ALL {
        agrees(
            &Bench::new(class, &format!("customizer-{class}")),
            Some(&command),
        );
    }
}

#[test]
fn plates_hold_every_piece_beside_the_others() {
    let Some(command) = manifold() else {
        return;
    };
    for class in Class::ALL {
        let bench = Bench::new(class, &format!("plates-{class}"));
        for (i, body) in bench.solids.bodies.iter().enumerate() {
            let script = bench.folder.join(format!("plate-{}.scad", i + 1));
            let text = format!("use <customizer.scad>\nmw_plate_{}();\n", i + 1);
            std::fs::write(&script, text).expect("writable");
            let pieces = bench.solids.pieces.iter().filter(|p| p.body == body.name);
            let (count, volume) = pieces.fold((0, 0.0), |(n, v), p| (n + 1, v + p.mesh.volume()));
            let plate = Run::with(&command, &script)
                .stl("plate")
                .closed_bodies(count);
            // Pieces that met would be fewer, or have less volume.
            close(plate.volume() / volume, 1.0, 5e-3, &body.name);
            close(plate.bounds().0.z, 0.0, 1e-4, &body.name);
            let size = plate.bounds().1 - plate.bounds().0;
            assert!(
                size.x < 180.0 && size.y < 180.0,
                "{class} {}: {size}",
                body.name
            );
        }
    }
}

#[test]
fn the_whole_mechanism_turns_by_the_angle_and_any_number_of_turns() {
    let Some(command) = manifold() else {
        return;
    };
    let bench = Bench::new(Class::R3, "turns");
    let whole = |angle: &str| {
        let run = Run::with(&command, &bench.folder.join("customizer.scad"));
        let run = run.set("quality", "\"draft\"").set("angle", angle);
        run.stl("whole").closed_bodies(3)
    };
    let (there, back, on) = (whole("100"), whole("-260"), whole("0"));
    assert_eq!(there, back);
    close(there.volume() / on.volume(), 1.0, 1e-4, "turned bodies");
    assert_ne!(there, on);
}
