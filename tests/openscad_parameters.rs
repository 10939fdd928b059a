//! Every parameter of the scripts that the recipe and the section know, one by one: it changes what it
//! names as much as it should, and only that. The judge is the embedded kernel.

mod openscad_bench;
mod openscad_run;
mod synthetic;

use mpcgear::motion::Class;
use openscad_bench::{Bench, box_change, close};
use openscad_run::{Run, installed};

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
    bench.flank_agrees(0, 0.7);
    bench.section_agrees("tooth_tip", 0.6, |s| s.tip = 0.6);
    bench.section_agrees("tooth_root", 0.3, |s| s.root = 0.3);
    bench.section_agrees("clearance", 0.3, |s| s.clearance = 0.3);
    bench.section_agrees("rib_thickness", 1.0, |s| s.rib = 1.0);
}

#[test]
fn every_parameter_of_a_flat_section_changes_the_teeth() {
    if !installed() {
        return;
    }
    let bench = Bench::with(Class::R1, "flat", |design| {
        let radii = [2.5, 6.0];
        for (pair, radius) in design.sub_gear_pairs.iter_mut().zip(radii) {
            pair.flank_radius = Some(radius);
        }
    });
    for (body, made) in ["driver", "follower"].iter().zip(&bench.solids.bodies) {
        close(
            bench.volume(body, &[]) / made.mesh.volume(),
            1.0,
            1e-4,
            body,
        );
    }
    bench.flank_agrees(0, 1.3);
    bench.flank_agrees(1, 3.0);
    bench.flank_agrees(1, 0.9);
    bench.section_agrees("tooth_thickness", 1.4, |s| s.thickness = 1.4);
    bench.section_agrees("tooth_tip", 0.5, |s| s.tip = 0.5);
    bench.section_agrees("tooth_root", 0.3, |s| s.root = 0.3);
    bench.section_agrees("clearance", 0.3, |s| s.clearance = 0.3);
    bench.section_agrees("rib_thickness", 1.0, |s| s.rib = 1.0);
}
