//! Laws that any tooth pair and any set of contacts obey, tried on random ones against what they mean:
//! differences of the curves and surfaces themselves, all directions, booleans of the meshes.

use std::f64::consts::TAU;
use std::path::Path;

use mpcgear::closure::{Wrench, measure};
use mpcgear::contact::{Contact, Grid, Node, ToothLaw, Trace, trace};
use mpcgear::design::Gear;
use mpcgear::motion::{Motion, MotionFile};
use mpcgear::search::candidates::Workshop;
use mpcgear::settings::Settings;
use mpcgear::solid::Solids;
use mpcgear::solid::kernel::Solid;
use mpcgear::synthesis::{self, Bands, Flanks};
use nalgebra::{DMatrix, DVector, Matrix2, Vector3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Integration steps a tooth.
const STEPS: usize = 200;

fn example(name: &str) -> (MotionFile, Motion) {
    let path = format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    MotionFile::read(Path::new(&path)).expect("example")
}

/// Random teeth on one motion a class, each with the nodes of its contacts; those without a cusp.
fn teeth(count: usize, mut check: impl FnMut(&[&Node], &Trace)) {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for name in [
        "quick_return_1r",
        "stroke_1r1t",
        "trefoil",
        "wobble_lift_3r1t",
    ] {
        let motion = example(name).1;
        let grid = Grid::new(&motion, &Settings::default().gear, STEPS);
        let mut found = 0;
        for _ in 0..50 * count {
            let j = rng.random_range(0..grid.teeth.len());
            let mut sign = || if rng.random::<bool>() { 1.0 } else { -1.0 };
            let (side, way) = (sign(), sign());
            let law = ToothLaw {
                alpha: rng.random_range(0.2..1.0),
                beta: rng.random_range(-0.6..0.6),
                alpha_change: rng.random_range(-0.4..0.4),
                beta_change: rng.random_range(-0.4..0.4),
                side,
                z: rng.random_range(-20.0..20.0),
                travel: way * rng.random_range(5.0..11.0),
                offset: rng.random_range(-1.5..1.5),
            };
            let Some(tooth) = trace(&grid, j, &law) else {
                continue;
            };
            if tooth.iter().any(|c| c.t1.norm().min(c.t2.norm()) < 1.5) {
                continue;
            }
            let nodes: Vec<&Node> = grid.teeth[j].iter().step_by(2).collect();
            check(&nodes, &tooth);
            found += 1;
            if found == count {
                break;
            }
        }
        assert_eq!(found, count, "{name}: too few teeth to try");
    }
}

/// Point, normal into the material and unit tangent of contact `k`'s place on `gear`, where that is
/// when contact `i` is made.
fn carried(
    gear: Gear,
    nodes: &[&Node],
    tooth: &Trace,
    (k, i): (usize, usize),
) -> [Vector3<f64>; 3] {
    let c: &Contact = &tooth[k];
    let (there, here, m, t) = match gear {
        Gear::Driver => (nodes[k].driver.pose, nodes[i].driver.pose, -c.n, c.t1),
        Gear::Follower => (nodes[k].follower.pose, nodes[i].follower.pose, c.n, c.t2),
    };
    let turn = here.rotation * there.rotation.transpose();
    [
        here.apply(there.inverse_apply(c.p)),
        turn * m,
        (turn * t).normalize(),
    ]
}

#[test]
fn teeth_are_conjugate_to_round_off() {
    teeth(25, |nodes, tooth| {
        for i in 3..tooth.len() - 3 {
            let (c, node) = (&tooth[i], nodes[i]);
            let (v1, v2) = (node.driver.velocity(c.p), node.follower.velocity(c.p));
            let at = |k: usize| tooth[k].p;
            let rate = (45.0 * (at(i + 1) - at(i - 1)) - 9.0 * (at(i + 2) - at(i - 2))
                + (at(i + 3) - at(i - 3)))
                / (60.0 * (tooth[i + 1].phi - c.phi));
            assert!((c.n.norm() - 1.0).abs() < 1e-12);
            assert!(c.n.dot(&(v2 - v1)).abs() < 1e-9, "sliding along the normal");
            // What the construction says of the curves is what their points do.
            for (said, v) in [(c.t1, v1), (c.t2, v2)] {
                assert!((said - (rate - v)).norm() < 1e-6, "{said} {}", rate - v);
                assert!(c.n.dot(&(rate - v)).abs() < 1e-7, "normal along the curve");
            }
        }
    });
}

/// ½ g δφ² is how far the two contact curves are apart along n beside the contact.
#[test]
fn the_gap_is_the_second_difference_of_the_curves() {
    teeth(25, |nodes, tooth| {
        for i in (10..tooth.len() - 10).step_by(9) {
            let n = tooth[i].n;
            let apart = |k: usize| {
                let on = |gear| carried(gear, nodes, tooth, (k, i))[0];
                n.dot(&(on(Gear::Follower) - on(Gear::Driver)))
            };
            let delta = tooth[i + 2].phi - tooth[i].phi;
            let both = |m: usize| apart(i + 2 * m) + apart(i - 2 * m);
            let second = (270.0 * both(1) - 27.0 * both(2) + 2.0 * both(3) - 490.0 * apart(i))
                / (180.0 * delta * delta);
            let g = tooth[i].gap;
            assert!((second - g).abs() < 1e-5 * (1.0 + g.abs()), "{second} {g}");
        }
    });
}

/// Second derivatives of a bead's surface over the tangent plane of contact `i`, from its points.
fn hessian(gear: Gear, nodes: &[&Node], (tooth, i, radius): (&Trace, usize, f64)) -> Matrix2<f64> {
    let c = &tooth[i];
    let e1 = c.t1.normalize();
    let e2 = c.n.cross(&e1);
    let (mut rows, mut heights) = (Vec::new(), Vec::new());
    for step in -4_i32..=4 {
        let k = (i as i32 + 2 * step) as usize;
        let [q, m, t] = carried(gear, nodes, tooth, (k, i));
        let b = t.cross(&m);
        for turn in -4..=4 {
            let (sin, cos) = (0.05 * f64::from(turn)).sin_cos();
            let x = q + radius * (m - m * cos - b * sin) - c.p;
            let (u, v) = (x.dot(&e1), x.dot(&e2));
            // All monomials up to degree 5.
            let powers = (0..=5).flat_map(|d| (0..=d).map(move |j| (d - j, j)));
            rows.extend(powers.map(|(a, b)| u.powi(a) * v.powi(b)));
            heights.push(x.dot(&c.n));
        }
    }
    let count = heights.len();
    let fit = DMatrix::from_row_slice(count, rows.len() / count, &rows).svd(true, true);
    let all = fit
        .solve(&DVector::from_vec(heights), 1e-14)
        .expect("solved");
    // u², uv, v² are numbers 3, 4 and 5.
    Matrix2::new(2.0 * all[3], all[4], all[4], 2.0 * all[5])
}

#[test]
fn the_induced_curvature_is_that_of_the_surfaces() {
    let radius = 0.9;
    teeth(12, |nodes, tooth| {
        for i in (20..tooth.len() - 20).step_by(32) {
            let of = |gear| hessian(gear, nodes, (tooth, i, radius));
            let parting = of(Gear::Follower) - of(Gear::Driver);
            let least = parting.symmetric_eigenvalues().min();
            let said = tooth[i].induced_curvature(radius);
            assert!((least - said).abs() < 2e-3, "{least} {said}");
        }
    });
}

/// Directions that leave no direction farther away than `spacing`, rad.
fn directions(dof: usize) -> (Vec<Wrench>, f64) {
    match dof {
        1 => (vec![[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]], 0.0),
        2 => {
            let count = 720;
            let turn = |i: i32| TAU * f64::from(i) / f64::from(count);
            let all = (0..count).map(|i| [turn(i).cos(), turn(i).sin(), 0.0, 0.0]);
            (all.collect(), TAU / f64::from(count))
        }
        _ => {
            // A grid on the faces of a cube, seen from its middle.
            let cells = 24_i32;
            let at = |i: i32| f64::from(i) / f64::from(cells);
            let mut all = Vec::new();
            for face in 0..3 {
                for (i, j) in (-cells..=cells).flat_map(|i| (-cells..=cells).map(move |j| (i, j))) {
                    for side in [1.0, -1.0] {
                        let mut d = [0.0; 4];
                        d[face] = side;
                        d[(face + 1) % 3] = at(i);
                        d[(face + 2) % 3] = at(j);
                        let norm = d.iter().map(|x| x * x).sum::<f64>().sqrt();
                        all.push(d.map(|x| x / norm));
                    }
                }
            }
            (all, 2f64.sqrt() / f64::from(cells))
        }
    }
}

fn norm(w: &Wrench) -> f64 {
    w.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// `points` as wrenches of R^`dof`.
fn within(points: &[[f64; 4]], dof: usize) -> Vec<Wrench> {
    let cut = |p: &[f64; 4]| std::array::from_fn(|i| if i < dof { p[i] } else { 0.0 });
    points.iter().map(cut).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Q is the smallest push-back over all directions: the directions tried bound it from above, and
    /// from below up to their spacing.
    #[test]
    fn q_is_what_all_directions_say(
        points in prop::collection::vec(prop::array::uniform4(-3.0f64..3.0), 5..8),
        dof in 1usize..4,
    ) {
        let wrenches = within(&points, dof);
        let q = measure(&wrenches, dof);
        let (all, spacing) = directions(dof);
        let push = |d: &Wrench| {
            let along = |w: &Wrench| w.iter().zip(d).map(|(a, b)| a * b).sum::<f64>();
            wrenches.iter().map(along).fold(f64::NEG_INFINITY, f64::max)
        };
        let least = all.iter().map(push).fold(f64::INFINITY, f64::min);
        let slack = spacing * wrenches.iter().map(norm).fold(0.0, f64::max);
        if q > 0.0 {
            prop_assert!(q <= least + 1e-12 && least <= q + slack, "{} {}", q, least);
        } else {
            prop_assert!(least <= slack, "{} {}", q, least);
        }
    }

    /// Q of a closed set changes by no more than its contacts do.
    #[test]
    fn q_is_lipschitz_in_the_wrenches(
        points in prop::collection::vec(prop::array::uniform4(-3.0f64..3.0), 5..8),
        moves in prop::collection::vec(prop::array::uniform4(-0.1f64..0.1), 8),
        dof in 1usize..5,
    ) {
        let before = within(&points, dof);
        let shifted: Vec<[f64; 4]> = points
            .iter()
            .zip(&moves)
            .map(|(p, m)| std::array::from_fn(|i| p[i] + m[i]))
            .collect();
        let after = within(&shifted, dof);
        let (q, moved) = (measure(&before, dof), measure(&after, dof));
        let largest = within(&moves, dof).iter().map(norm).fold(0.0, f64::max);
        if q > 0.0 {
            prop_assert!(moved >= q - largest - 1e-9, "{} {} {}", q, moved, largest);
        }
        if moved > 0.0 {
            prop_assert!(q >= moved - largest - 1e-9, "{} {} {}", q, moved, largest);
        }
    }
}

/// Bands that the search calls compatible do not overlap as solids.
#[test]
fn compatible_bands_do_not_overlap() {
    for name in ["quick_return_1r", "trefoil"] {
        let (file, motion) = example(name);
        let workshop = Workshop::new(&motion, &file.settings);
        let mut candidates = Vec::new();
        for batch in 0..40 {
            candidates.extend(workshop.sample(5, (64 * batch, 64), &[]).0);
            if candidates.len() > 12 {
                break;
            }
        }
        let pairs = (0..candidates.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        let pairs: Vec<(usize, usize)> = pairs
            .filter(|&(a, b)| {
                let [a, b] = [a, b].map(|i| &candidates[i].swept);
                workshop.scene.compatible(a, b)
            })
            .take(2)
            .collect();
        assert_eq!(pairs.len(), 2, "{name}: too few pairs to try");
        for (a, b) in pairs {
            let bands = [a, b].map(|i| candidates[i].law.clone()).to_vec();
            let design = synthesis::design(&file, &motion, &Bands::Exact(bands), Flanks::Flat)
                .expect("design");
            let solids = Solids::build(&design, &motion).expect("solids");
            for i in 0..12 {
                let phi = TAU * (f64::from(i) + 0.29) / 12.0;
                let gear = |k: usize| {
                    let mesh = solids.placed(&solids.bodies[k], &design, &motion, phi);
                    Solid::new(&mesh, "gear").expect("a solid")
                };
                let shared = gear(0).intersection(&gear(1)).volume();
                assert!(shared < 1e-6, "{name}: {shared} mm³ at φ = {phi}");
            }
        }
    }
}
