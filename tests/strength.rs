//! Elements, stiffness and stress of teeth against theory, finer grids and CalculiX.

mod known;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use approx::assert_relative_eq;
use known::{Helical, design, motion, revolute, spherical};
use mpcgear::design::{Design, Gear, SubGearPair};
use mpcgear::load::Material;
use mpcgear::motion::Class;
use mpcgear::strength::elastic_body::{ElasticBody, Forces, Grid};
use mpcgear::strength::elements::{self, Elasticity};
use mpcgear::strength::tooth::{self, FINENESS};
use mpcgear::strength::tooth_grid::{Tooth, ToothGrid};
use mpcgear::strength::{Hub, ToothStrength};
use nalgebra::{Matrix3, Vector3};

const GEARS: [Gear; 2] = [Gear::Driver, Gear::Follower];

/// Forces of a traction (MPa) on the upper end along the first axis of a grid of `counts` bricks of `size` (mm).
fn pulled(grid: &Grid, counts: [usize; 3], size: [f64; 3], traction: Vector3<f64>) -> Forces {
    let mut forces = Forces::new();
    let area = size[1] * size[2];
    for (element, cell) in grid.cells.iter().enumerate() {
        if cell[0] + 1 == counts[0] {
            for (node, place) in grid.elements[element].iter().zip(elements::PLACES) {
                // Of a face with eight nodes: corners −1/12, middles of edges 1/3.
                let share = match place {
                    [1, b, c] if b != 0 && c != 0 => -1.0 / 12.0,
                    [1, ..] => 1.0 / 3.0,
                    _ => continue,
                };
                forces.push((*node, share * area * traction));
            }
        }
    }
    forces
}

#[test]
fn constant_stress_is_exact_in_distorted_elements() {
    let counts = [3, 2, 3];
    let mut grid = Grid::new(
        counts,
        |_| true,
        |half| {
            let x = Vector3::from(half.map(|h| 0.5 * h as f64));
            // Two corners inside are moved; edges stay straight.
            let moved = |at: Vector3<f64>, by: Vector3<f64>| {
                by * (x - at)
                    .iter()
                    .map(|d| (1.0 - d.abs()).max(0.0))
                    .product::<f64>()
            };
            x + moved(Vector3::new(1.0, 1.0, 1.0), Vector3::new(0.2, -0.15, 0.1))
                + moved(Vector3::new(2.0, 1.0, 2.0), Vector3::new(-0.1, 0.2, 0.15))
        },
    );
    for (fixed, half) in grid.fixed.iter_mut().zip(&grid.halves) {
        *fixed = half.map(|h| h == 0);
    }
    let forces = pulled(&grid, counts, [1.0; 3], Vector3::new(10.0, 0.0, 0.0));
    let body = ElasticBody::new(&grid, Elasticity::new(3300.0, 0.36)).expect("held");
    let moved = &body.solve(&[forces]).expect("solved")[0];
    let expected = Matrix3::from_diagonal(&Vector3::new(10.0, 0.0, 0.0));
    for element in 0..grid.elements.len() {
        for stress in body.stresses(element, moved) {
            assert!((stress - expected).norm() < 1e-9, "{stress}");
        }
    }
    for (node, u) in grid.nodes.iter().zip(moved) {
        let expected = node.component_mul(&Vector3::new(1.0, -0.36, -0.36)) * 10.0 / 3300.0;
        assert!((u - expected).norm() < 1e-11);
    }
}

#[test]
fn a_clamped_beam_and_a_clamped_plate_bend_as_timoshenko_says() {
    let (young, poisson) = (3300.0, 0.36);
    let (length, thickness, width) = (12.0, 1.4, 2.0);
    let counts = [6, 1, 2];
    let size = [length / 6.0, thickness, 0.5 * width];
    for plate in [false, true] {
        let mut grid = Grid::new(
            counts,
            |_| true,
            |half| Vector3::from_fn(|i, _| 0.5 * half[i] as f64 * size[i]),
        );
        for (fixed, half) in grid.fixed.iter_mut().zip(&grid.halves) {
            // The clamped end may become thinner, as in beam theory; a wide plate cannot shrink across.
            let clamped = half[0] == 0;
            *fixed = [
                clamped,
                clamped && half[1] == 1,
                clamped && half[2] == 2 || plate,
            ];
        }
        let force = 4.0;
        let traction = Vector3::new(0.0, force / (thickness * width), 0.0);
        let forces = pulled(&grid, counts, size, traction);
        let body = ElasticBody::new(&grid, Elasticity::new(young, poisson)).expect("held");
        let moved = &body.solve(std::slice::from_ref(&forces)).expect("solved")[0];
        let end: f64 = forces
            .iter()
            .map(|(node, f)| f.dot(&moved[*node]))
            .sum::<f64>()
            / force;

        let inertia = width * thickness.powi(3) / 12.0;
        let stiffer = if plate { 1.0 - poisson * poisson } else { 1.0 };
        let shear = young / (2.0 * (1.0 + poisson));
        let bending = force * length.powi(3) * stiffer / (3.0 * young * inertia);
        let shearing = 1.2 * force * length / (shear * thickness * width);
        assert_relative_eq!(end, bending + shearing, max_relative = 0.02);

        // Stress at the surface in the middle of the third element.
        let element = grid
            .cells
            .iter()
            .position(|c| *c == [2, 0, 0])
            .expect("there");
        let stresses = body.stresses(element, moved);
        let surface = elements::between_points(&stresses, [0.0, 1.0, 1.0]);
        let lever = length - 2.5 * size[0];
        assert_relative_eq!(
            surface.m11,
            -force * lever * 0.5 * thickness / inertia,
            max_relative = 0.02
        );
    }
}

/// Designs of three kinds: helical, spherical, and helical with flat flanks and a steeper helix.
fn designs() -> [Design; 3] {
    let m = motion(Class::R1);
    let steep = |side: f64, z0: f64| Helical {
        alpha: 0.3,
        side,
        z0,
        travel: 9.0,
    };
    let bands = [steep(1.0, 8.0), steep(-1.0, 22.0)].map(|band| SubGearPair {
        flank_radius: Some(3.0),
        ..band.band(&m)
    });
    [revolute(), spherical(), design(Class::R1, bands.into())]
}

/// A tooth of both gears of every design.
fn teeth() -> Vec<Tooth> {
    let of = |design: &Design, (k, j): (usize, usize)| {
        let pair = &design.sub_gear_pairs[k];
        GEARS.map(|gear| {
            let hub = Hub::of(design, gear);
            Tooth::new(&pair.teeth[j], gear, design.section_of(pair), hub).expect("a tooth")
        })
    };
    let chosen = [(0, 0), (1, 3), (1, 7)];
    let designs = designs();
    designs
        .iter()
        .zip(chosen)
        .flat_map(|(design, tooth)| of(design, tooth))
        .collect()
}

#[test]
fn finer_grids_say_the_same() {
    for tooth in &teeth() {
        let [coarse, fine] = [FINENESS, 2 * FINENESS]
            .map(|fineness| ToothStrength::of(tooth, Material::Steel, fineness).expect("elements"));
        for (one, other) in coarse.responses.iter().zip(&fine.responses) {
            assert_relative_eq!(one.compliance, other.compliance, max_relative = 0.05);
            assert_relative_eq!(one.stress, other.stress, max_relative = 0.15);
        }
    }
}

/// Whether CalculiX is there; where `MPCGEAR_REQUIRE_CAD=1` it has to be.
fn calculix_is_here() -> bool {
    let found = Command::new("ccx").arg("-v").output().is_ok();
    let required = std::env::var("MPCGEAR_REQUIRE_CAD").is_ok_and(|v| v == "1");
    assert!(found || !required, "CalculiX is not installed");
    if !found {
        eprintln!("skipped: CalculiX is not installed");
    }
    found
}

/// A job of CalculiX: `kind` of elements, one step per case of forces; prints displacements and stresses.
fn job(grid: &Grid, kind: &str, material: Material, cases: &[Forces]) -> String {
    let mut text = String::from("*NODE, NSET=ALL\n");
    for (i, x) in grid.nodes.iter().enumerate() {
        writeln!(text, "{}, {:.12e}, {:.12e}, {:.12e}", i + 1, x.x, x.y, x.z).expect("text");
    }
    writeln!(text, "*ELEMENT, TYPE={kind}, ELSET=BODY").expect("text");
    for (i, nodes) in grid.elements.iter().enumerate() {
        let nodes: Vec<String> = nodes.iter().map(|n| (n + 1).to_string()).collect();
        let (first, rest) = nodes.split_at(10);
        writeln!(
            text,
            "{}, {},\n{}",
            i + 1,
            first.join(", "),
            rest.join(", ")
        )
        .expect("text");
    }
    text.push_str("*BOUNDARY\n");
    for (i, fixed) in grid.fixed.iter().enumerate() {
        if fixed[0] {
            writeln!(text, "{}, 1, 3", i + 1).expect("text");
        }
    }
    writeln!(
        text,
        "*MATERIAL, NAME=M\n*ELASTIC\n{}, {}\n*SOLID SECTION, ELSET=BODY, MATERIAL=M",
        material.young_modulus(),
        material.poisson_ratio()
    )
    .expect("text");
    for forces in cases {
        text.push_str("*STEP\n*STATIC\n*CLOAD, OP=NEW\n");
        // Forces at a node that several elements share add up.
        let mut sums = std::collections::BTreeMap::new();
        for (node, force) in forces {
            *sums.entry(node).or_insert_with(Vector3::zeros) += force;
        }
        for (node, force) in sums {
            for axis in 0..3 {
                writeln!(text, "{}, {}, {:.12e}", node + 1, axis + 1, force[axis]).expect("text");
            }
        }
        text.push_str("*NODE PRINT, NSET=ALL\nU\n*EL PRINT, ELSET=BODY\nS\n*END STEP\n");
    }
    text
}

/// Lines of numbers.
type Rows = Vec<Vec<f64>>;

/// Numbers that CalculiX prints for a case: three of every node and six of every integration point.
fn solved(folder: &Path, job: &str, cases: usize) -> Vec<[Rows; 2]> {
    std::fs::write(folder.join("tooth.inp"), job).expect("written");
    let mut run = Command::new("ccx");
    let output = run
        .arg("tooth")
        .current_dir(folder)
        .env("OMP_NUM_THREADS", "1")
        .output();
    let output = output.expect("CalculiX runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
    let text = std::fs::read_to_string(folder.join("tooth.dat")).expect("results");
    let mut blocks: Vec<Rows> = Vec::new();
    for line in text.lines() {
        if line.contains("displacements") || line.contains("stresses") {
            blocks.push(Vec::new());
        } else if let Some(block) = blocks.last_mut() {
            let numbers: Vec<f64> = line
                .split_whitespace()
                .filter_map(|w| w.parse().ok())
                .collect();
            if numbers.len() >= 4 {
                block.push(numbers);
            }
        }
    }
    assert_eq!(blocks.len(), 2 * cases);
    let mut blocks = blocks.into_iter();
    std::iter::from_fn(|| Some([blocks.next()?, blocks.next()?])).collect()
}

#[test]
fn calculix_says_the_same_of_six_teeth() {
    if !calculix_is_here() {
        return;
    }
    let material = Material::Steel;
    let folder = tempfile::tempdir().expect("folder");
    for (i, tooth) in teeth().iter().enumerate() {
        let own = ToothStrength::of(tooth, material, FINENESS).expect("elements");
        let cut = ToothGrid::new(tooth, 2 * FINENESS).expect("elements");
        let shares = [0.0, 0.5, 1.0];
        let cases = shares.map(|share| tooth::forces(tooth, &cut, share));
        let full = solved(folder.path(), &job(&cut.grid, "C3D20", material, &cases), 3);
        let reduced = solved(
            folder.path(),
            &job(&cut.grid, "C3D20R", material, &cases),
            3,
        );
        for (case, forces) in cases.iter().enumerate() {
            let own = own.at(shares[case]);
            let moved = |node: usize| {
                let row = &full[case][0][node];
                Vector3::new(row[1], row[2], row[3])
            };
            let compliance: f64 = forces.iter().map(|(node, f)| f.dot(&moved(*node))).sum();
            let stresses = &reduced[case][1];
            let stress = cut.hottest(|element| {
                std::array::from_fn(|point| {
                    let s = &stresses[elements::POINTS * element + point][2..];
                    Matrix3::new(s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2])
                })
            });
            let stress = stress.map(|s| tooth::equivalent(&s)).fold(0.0, f64::max);
            eprintln!(
                "tooth {i} at {}: stiffness {:.1} N/mm, CalculiX {:.1}; stress {:.3} MPa/N, CalculiX {stress:.3}",
                shares[case],
                1.0 / own.compliance,
                1.0 / compliance,
                own.stress
            );
            assert_relative_eq!(own.compliance, compliance, max_relative = 0.1);
            assert_relative_eq!(own.stress, stress, max_relative = 0.15);
        }
    }
}
