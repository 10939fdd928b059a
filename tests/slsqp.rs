//! The guarded solver on problems with known answers, and on programs that misbehave.

use mpcgear::search::slsqp::{Evaluation, Limits, Program, Start, StopReason, minimise};

/// A program made of two closures: value with gradient, constraints with Jacobian rows.
struct Case<F, C> {
    variables: usize,
    constraints: usize,
    objective: F,
    constrain: C,
}

impl<F, C> Program for Case<F, C>
where
    F: Fn(&[f64]) -> (f64, Vec<f64>),
    C: Fn(&[f64]) -> Vec<(f64, Vec<f64>)>,
{
    fn variables(&self) -> usize {
        self.variables
    }

    fn constraints(&self) -> usize {
        self.constraints
    }

    fn evaluate(&self, x: &[f64], at: &mut Evaluation) {
        (at.value, at.gradient) = (self.objective)(x);
        let rows = (self.constrain)(x);
        for (i, (value, row)) in rows.into_iter().enumerate() {
            at.constraints[i] = value;
            at.jacobian[i * self.variables..(i + 1) * self.variables].copy_from_slice(&row);
        }
    }
}

fn free(x: &[f64]) -> Start {
    Start {
        x: x.to_vec(),
        lower: vec![f64::NEG_INFINITY; x.len()],
        upper: vec![f64::INFINITY; x.len()],
    }
}

fn none(_: &[f64]) -> Vec<(f64, Vec<f64>)> {
    Vec::new()
}

fn bowl(x: &[f64]) -> (f64, Vec<f64>) {
    (
        x.iter().map(|v| v * v).sum(),
        x.iter().map(|v| 2.0 * v).collect(),
    )
}

#[test]
fn hock_schittkowski_71() {
    // Its equality Σx² = 40 binds from above at the optimum, so Σx² ≤ 40 has the same one.
    let case = Case {
        variables: 4,
        constraints: 2,
        objective: |x: &[f64]| {
            let s = x[0] + x[1] + x[2];
            let g = vec![x[3] * (s + x[0]), x[0] * x[3], x[0] * x[3] + 1.0, x[0] * s];
            (x[0] * x[3] * s + x[2], g)
        },
        constrain: |x: &[f64]| {
            let product = x[0] * x[1] * x[2] * x[3];
            vec![
                (25.0 - product, x.iter().map(|v| -product / v).collect()),
                (bowl(x).0 - 40.0, bowl(x).1),
            ]
        },
    };
    let start = Start {
        x: vec![1.0, 5.0, 5.0, 1.0],
        lower: vec![1.0; 4],
        upper: vec![5.0; 4],
    };
    let report = minimise(&case, &start, &Limits::default());
    assert_eq!(report.stop, StopReason::Converged);
    assert!((report.value - 17.014_017_3).abs() < 1e-6, "{report:?}");
    assert!(report.worst_violation <= 1e-7);
    let known = [1.0, 4.742_999_63, 3.821_149_98, 1.379_408_29];
    assert!(
        report
            .best
            .iter()
            .zip(known)
            .all(|(a, b)| (a - b).abs() < 1e-5),
        "{report:?}"
    );
}

fn rosenbrock(x: &[f64]) -> (f64, Vec<f64>) {
    let d = x[1] - x[0] * x[0];
    let value = 100.0 * d * d + (1.0 - x[0]).powi(2);
    (
        value,
        vec![-400.0 * d * x[0] - 2.0 * (1.0 - x[0]), 200.0 * d],
    )
}

#[test]
fn rosenbrock_free_and_in_a_disc() {
    let case = Case {
        variables: 2,
        constraints: 0,
        objective: rosenbrock,
        constrain: none,
    };
    let report = minimise(&case, &free(&[-1.2, 1.0]), &Limits::default());
    assert!(
        report.best.iter().all(|x| (x - 1.0).abs() < 1e-5),
        "{report:?}"
    );

    let case = Case {
        variables: 2,
        constraints: 1,
        objective: rosenbrock,
        constrain: |x: &[f64]| vec![(bowl(x).0 - 1.0, bowl(x).1)],
    };
    let report = minimise(&case, &free(&[-0.5, 0.5]), &Limits::default());
    assert!((report.best[0] - 0.786_415).abs() < 1e-4, "{report:?}");
    assert!((report.best[1] - 0.617_698).abs() < 1e-4 && report.worst_violation <= 1e-7);
}

#[test]
fn infeasible_program_reports_its_violation() {
    // x ≥ 1 and x ≤ −1 cannot both hold; the least violation is 1.
    let case = Case {
        variables: 1,
        constraints: 2,
        objective: bowl,
        constrain: |x: &[f64]| vec![(1.0 - x[0], vec![-1.0]), (x[0] + 1.0, vec![1.0])],
    };
    let report = minimise(&case, &free(&[3.0]), &Limits::default());
    assert!(report.worst_violation >= 1.0 - 1e-9, "{report:?}");
    // The start violates by 4. Between −1 and 1 the two violations add up to 2, which is as far as
    // a merit function that adds them can get.
    assert!(report.worst_violation <= 2.0 + 1e-6, "{report:?}");
}

#[test]
fn nan_beyond_a_wall_is_backed_off_from() {
    // ln x is NaN for x < 0, where the first full step lands.
    let case = Case {
        variables: 1,
        constraints: 0,
        objective: |x: &[f64]| (x[0] - 0.01 * x[0].ln(), vec![1.0 - 0.01 / x[0]]),
        constrain: none,
    };
    let report = minimise(&case, &free(&[2.0]), &Limits::default());
    assert!((report.best[0] - 0.01).abs() < 1e-4, "{report:?}");
    assert!(report.value.is_finite());
}

#[test]
fn nan_and_panic_at_the_start_have_their_names() {
    let case = Case {
        variables: 1,
        constraints: 0,
        objective: |_: &[f64]| (f64::NAN, vec![0.0]),
        constrain: none,
    };
    let report = minimise(&case, &free(&[0.0]), &Limits::default());
    assert_eq!(
        (report.stop, report.evaluations),
        (StopReason::NotFinite, 1)
    );
    assert!(report.value.is_nan() && report.worst_violation.is_nan());
    let report = minimise(&case, &free(&[f64::INFINITY]), &Limits::default());
    assert_eq!(
        (report.stop, report.evaluations),
        (StopReason::NotFinite, 0)
    );

    // Not finite in the gradient alone counts too.
    let case = Case {
        variables: 1,
        constraints: 0,
        objective: |_: &[f64]| (0.0, vec![f64::INFINITY]),
        constrain: none,
    };
    assert_eq!(
        minimise(&case, &free(&[0.0]), &Limits::default()).stop,
        StopReason::NotFinite
    );
}

#[test]
fn panic_on_the_way_keeps_the_best_so_far() {
    let case = Case {
        variables: 2,
        constraints: 0,
        objective: |x: &[f64]| {
            let (value, gradient) = rosenbrock(x);
            assert!(value > 3.0, "on purpose");
            (value, gradient)
        },
        constrain: none,
    };
    let report = minimise(&case, &free(&[-1.2, 1.0]), &Limits::default());
    assert_eq!(report.stop, StopReason::Panicked);
    assert!(
        report.value > 3.0 && report.value <= 24.2 + 1e-9,
        "{report:?}"
    );
}

#[test]
fn limits_stop_and_the_result_is_never_worse_than_the_start() {
    let case = Case {
        variables: 2,
        constraints: 0,
        objective: rosenbrock,
        constrain: none,
    };
    for evaluations in [1, 2, 5, 10] {
        let limits = Limits {
            evaluations,
            ..Limits::default()
        };
        let report = minimise(&case, &free(&[-1.2, 1.0]), &limits);
        assert_eq!(report.stop, StopReason::Evaluations);
        assert!(report.evaluations <= evaluations as usize + 1, "{report:?}");
        assert!(report.value <= 24.2 + 1e-9);
    }
}

#[test]
fn same_start_same_bits_on_every_thread() {
    let run = || {
        let case = Case {
            variables: 2,
            constraints: 0,
            objective: rosenbrock,
            constrain: none,
        };
        minimise(&case, &free(&[-1.2, 1.0]), &Limits::default())
    };
    let alone = run();
    let together: Vec<_> = std::thread::scope(|s| {
        let handles: Vec<_> = (0..4).map(|_| s.spawn(run)).collect();
        handles
            .into_iter()
            .map(|h| h.join().expect("no panic"))
            .collect()
    });
    assert!(together.iter().all(|r| *r == alone));
}

#[test]
fn start_outside_the_bounds_is_moved_into_them() {
    let case = Case {
        variables: 1,
        constraints: 0,
        objective: bowl,
        constrain: none,
    };
    let start = Start {
        x: vec![9.0],
        lower: vec![1.0],
        upper: vec![2.0],
    };
    let report = minimise(&case, &start, &Limits::default());
    assert!((report.best[0] - 1.0).abs() < 1e-9, "{report:?}");
}
