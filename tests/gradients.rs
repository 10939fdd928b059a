//! Every energy and constraint of the published formulation against central differences.

use std::path::Path;

use mpcgear::contact::Grid;
use mpcgear::contact::paper_band::{BandModel, BandStart, Energies};
use mpcgear::motion::{Motion, MotionFile};
use mpcgear::settings::Settings;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const START: BandStart = BandStart {
    side: 1.0,
    z_start: 5.0,
    travel: 9.0,
    offset: 0.7,
};
const STEP: f64 = 1e-5;

/// One motion a class with rotation only, with rotation and lift, and the plainest of all.
fn motions() -> impl Iterator<Item = Motion> {
    ["uniform_1r", "trefoil", "wobble_lift_3r1t"]
        .into_iter()
        .map(|name| {
            let path = format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR"));
            MotionFile::read(Path::new(&path)).expect("example").1
        })
}

/// Models of both sides with random points around their starts.
fn cases(mut check: impl FnMut(BandModel, Vec<f64>)) {
    let mut settings = Settings::default();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for motion in motions() {
        for (side, control) in [(1.0, (4, 4)), (-1.0, (5, 4)), (1.0, (6, 3))] {
            settings.gear.locus_control_points = control.0;
            settings.gear.normal_control_points = control.1;
            let start = BandStart {
                side,
                travel: side * START.travel,
                ..START
            };
            let grid = Grid::new(&motion, &settings.gear, 16);
            let model = BandModel::new(&grid, &settings, &start, 2);
            let [mut x, ..] = model.start(&settings, &start);
            // Up to 0.5 mm and 0.2 rad: nothing is at an extremum, no tooth degenerates.
            x.iter_mut().for_each(|v| *v += rng.random_range(-0.2..0.2));
            check(model, x);
        }
    }
}

/// Largest |analytic − central difference| relative to the largest derivative, over all variables.
fn mismatch(x: &[f64], gradient: &[f64], value: impl Fn(&[f64]) -> f64) -> f64 {
    let largest = gradient.iter().fold(0.0, |a: f64, g| a.max(g.abs()));
    assert!(largest > 1e-9, "gradient vanishes: nothing is tested");
    let mut y = x.to_vec();
    let mut worst: f64 = 0.0;
    for k in 0..x.len() {
        y[k] = x[k] + STEP;
        let up = value(&y);
        y[k] = x[k] - STEP;
        let down = value(&y);
        y[k] = x[k];
        let error = (gradient[k] - (up - down) / (2.0 * STEP)).abs() / largest;
        assert!(error.is_finite());
        worst = worst.max(error);
    }
    worst
}

fn check_energy(weights: Energies) {
    cases(|mut model, x| {
        model.weights = weights;
        let mut gradient = vec![0.0; x.len()];
        let value = model.objective(&x, &mut gradient);
        assert!(value > 0.0, "{value}");
        let worst = mismatch(&x, &gradient, |y| {
            model.objective(y, &mut vec![0.0; y.len()])
        });
        assert!(worst < 1e-7, "{weights:?}: {worst:e}");
    });
}

#[test]
fn e_norm() {
    check_energy(Energies {
        norm: 120.0,
        ..Energies::default()
    });
}

#[test]
fn e_tang() {
    check_energy(Energies {
        tang: 1.0,
        ..Energies::default()
    });
}

#[test]
fn e_plan() {
    check_energy(Energies {
        plan: 1.0,
        ..Energies::default()
    });
}

#[test]
fn e_circ() {
    check_energy(Energies {
        circ: 1.0,
        ..Energies::default()
    });
}

#[test]
fn e_para() {
    check_energy(Energies {
        para: 1.0,
        ..Energies::default()
    });
}

#[test]
fn whole_objective() {
    check_energy(Energies {
        norm: 120.0,
        tang: 1.0,
        plan: 1.0,
        circ: 1.0,
        para: 1.0,
    });
}

#[test]
fn c_spac_and_c_widt() {
    cases(|model, x| {
        let (n, m) = (x.len(), model.constraints());
        let constrain = |y: &[f64]| {
            let (mut values, mut jacobian) = (vec![0.0; m], vec![0.0; m * n]);
            model.constrain(y, &mut values, &mut jacobian);
            (values, jacobian)
        };
        let (values, jacobian) = constrain(&x);
        assert!(values.iter().all(|v| v.is_finite()));
        for i in [0, 4, 9, 10, 13, 19, 20, 21] {
            let worst = mismatch(&x, &jacobian[i * n..(i + 1) * n], |y| constrain(y).0[i]);
            assert!(worst < 1e-7, "constraint {i}: {worst:e}");
        }
    });
}
