//! Bands of the published formulation: what they reach, and that they say so themselves.

use std::ops::ControlFlow;
use std::path::Path;

use mpcgear::contact::{BandStart, Contact, PaperBand};
use mpcgear::motion::{Drive, Motion, MotionFile};
use mpcgear::search::paper_search;
use mpcgear::search::slsqp::{Limits, Report, StopReason};
use mpcgear::settings::Settings;
use nalgebra::Vector3;

fn example(name: &str) -> Motion {
    let path = format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    MotionFile::read(Path::new(&path)).expect("example").1
}

fn solve(name: &str, start: BandStart, evaluations: u32) -> Report<PaperBand> {
    let limits = Limits {
        evaluations,
        ..Limits::default()
    };
    PaperBand::solve(&example(name), &Settings::default(), &start, &limits).expect("solvable")
}

fn contacts(band: &PaperBand) -> impl Iterator<Item = &Contact> {
    band.teeth.iter().flat_map(|t| &t.trace)
}

/// |n·v_rel| and |n·T²| from the motion alone: ṗ by differences of the stations.
fn residuals(motion: &Motion, trace: &[Contact], i: usize) -> (f64, f64) {
    let c = &trace[i];
    let (driver, follower) = (Drive::new(25.0, 1).state(c.phi), motion.state(c.phi));
    let rolling = c.n.dot(&(follower.velocity(c.p) - driver.velocity(c.p)));
    let tangent =
        c.n.dot(&(slope(trace, i, |c| c.p) - follower.velocity(c.p)));
    (rolling.abs(), tangent.abs())
}

/// Derivative by φ at station `i`, five-point rule.
fn slope(trace: &[Contact], i: usize, of: fn(&Contact) -> Vector3<f64>) -> Vector3<f64> {
    let at = |k: usize| of(&trace[k]);
    let h = trace[1].phi - trace[0].phi;
    (8.0 * (at(i + 1) - at(i - 1)) - (at(i + 2) - at(i - 2))) / (12.0 * h)
}

const RIGHT: BandStart = BandStart {
    side: 1.0,
    z_start: -5.0,
    travel: 9.0,
    offset: 1.5,
};

#[test]
fn uniform_motion_finds_pure_rolling_on_the_pitch_line() {
    for side in [1.0, -1.0] {
        let start = BandStart {
            side,
            travel: 9.0 * side,
            ..RIGHT
        };
        let report = solve("uniform_1r", start, 400);
        let band = &report.best;
        assert_eq!(report.stop, StopReason::Converged);
        assert!(report.worst_violation <= 1e-7);
        // The penalty alone leaves about 1e-6, the Gauss-Newton finish almost nothing.
        assert!(band.residual_max() <= 1e-8, "{:e}", band.residual_max());
        for c in contacts(band) {
            // It started 1.5 mm beside the line.
            assert!((c.p.x + 12.5).abs() < 1e-3 && c.p.y.abs() < 1e-3, "{}", c.p);
            assert!(c.n.x > 0.0 && side * c.n.y > 0.0 && c.gap > 1.0);
            assert!((c.n.norm() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn trefoil_leaves_a_residual_and_says_so() {
    let motion = example("trefoil");
    let report = solve("trefoil", RIGHT, 200);
    let band = &report.best;
    assert!(report.worst_violation <= 1e-7 && report.evaluations <= 201);
    // The penalty cannot do better than this, and must not do worse.
    assert!(
        (1e-6..0.1).contains(&band.residual_max()),
        "{:e}",
        band.residual_max()
    );
    assert!(band.residual_tangent < 1e-12);
    // The residuals it reports are at least those seen from outside, and not much more.
    let mut worst: f64 = 0.0;
    for tooth in &band.teeth {
        assert_eq!(tooth.trace.len(), 33);
        for i in 2..31 {
            let (rolling, tangent) = residuals(&motion, &tooth.trace, i);
            assert!(tangent < 1e-9, "{tangent:e}");
            worst = worst.max(rolling);
        }
    }
    assert!(worst <= band.residual_rolling * (1.0 + 1e-9));
    let ends = band
        .teeth
        .iter()
        .flat_map(|t| [0, 1, 31, 32].map(|i| t.trace[i]));
    for c in ends {
        let (driver, follower) = (Drive::new(25.0, 1).state(c.phi), motion.state(c.phi));
        let rolling = c.n.dot(&(follower.velocity(c.p) - driver.velocity(c.p)));
        worst = worst.max(rolling.abs());
    }
    assert!(worst > 0.5 * band.residual_rolling);
}

#[test]
fn second_order_gap_agrees_with_differences_of_the_normal() {
    let motion = example("trefoil");
    let report = solve("trefoil", RIGHT, 60);
    for tooth in &report.best.teeth {
        for i in 4..29 {
            let c = &tooth.trace[i];
            let (driver, follower) = (Drive::new(25.0, 1).state(c.phi), motion.state(c.phi));
            let n_rate = slope(&tooth.trace, i, |c| c.n);
            let v_rel = follower.velocity(c.p) - driver.velocity(c.p);
            let gap = (n_rate - driver.omega.cross(&c.n)).dot(&v_rel)
                - c.n.dot(&(follower.omega - driver.omega).cross(&c.t2));
            assert!(
                (gap - c.gap).abs() < 1e-3 * (1.0 + gap.abs()),
                "{gap} {}",
                c.gap
            );
        }
    }
}

#[test]
fn teeth_keep_their_distance_and_their_width() {
    // Short and flat: without C_spac neighbouring teeth would touch.
    let start = BandStart {
        travel: 2.0,
        ..RIGHT
    };
    let report = solve("uniform_1r", start, 300);
    assert!(report.worst_violation <= 1e-7, "{}", report.worst_violation);
    let motion = example("uniform_1r");
    let axis = |j: usize| -> Vec<Vector3<f64>> {
        let trace = &report.best.teeth[j].trace;
        let bead = |c: &Contact| motion.state(c.phi).pose.inverse_apply(c.p + 0.9 * c.n);
        trace.iter().map(bead).collect()
    };
    for j in 0..10 {
        let (a, b) = (axis(j), axis((j + 1) % 10));
        let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a - b).norm()));
        let distance = pairs.fold(f64::INFINITY, f64::min);
        assert!(distance > 2.1, "thickness 1.8 and gap 0.3: {distance}");
        let trace = &report.best.teeth[j].trace;
        assert!(
            trace[32].p.z - trace[0].p.z > 1.45,
            "three quarters of the travel"
        );
    }
}

#[test]
fn degenerate_start_is_named() {
    let settings = Settings::default();
    let motion = example("uniform_1r");
    for bad in [f64::NAN, f64::INFINITY] {
        let start = BandStart {
            travel: bad,
            ..RIGHT
        };
        let error = PaperBand::solve(&motion, &settings, &start, &Limits::default());
        let error = error.expect_err("not finite");
        assert_eq!(error.exit_code(), 3, "{error}");
    }
}

#[test]
fn a_search_finds_bands_that_conjugate_and_close() {
    let mut settings = Settings::default();
    settings.search.effort = 0.3;
    let run = || {
        let motion = example("uniform_1r");
        paper_search::run(&motion, &settings, &mut |_| ControlFlow::Continue(())).expect("feasible")
    };
    let (found, again) = (run(), run());
    let (bands, q) = &found.choices[0];
    assert_eq!(bands.len(), 2);
    // Half of what the exact search finds, far above the threshold of closure.
    assert!(*q > 3.0, "{q}");
    for (band, same) in bands.iter().zip(&again.choices[0].0) {
        assert!(band.residual_max() <= 1e-8, "{:e}", band.residual_max());
        let points = |band: &PaperBand| -> Vec<Vector3<f64>> {
            band.teeth
                .iter()
                .flat_map(|t| t.control_points.clone())
                .collect()
        };
        assert_eq!(points(band), points(same), "the same twice");
    }
}

#[test]
fn a_search_that_is_stopped_at_once_says_so() {
    let motion = example("uniform_1r");
    let stop = paper_search::run(&motion, &Settings::default(), &mut |_| {
        ControlFlow::Break(())
    });
    assert_eq!(stop.expect_err("nothing found yet").exit_code(), 130);
}
