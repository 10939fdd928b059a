//! The three things that a design's time goes into, one by one: tracing a band, measuring Q, proving
//! that the meshes stay apart.

#![allow(clippy::print_stdout)] // a table for people

use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use mpcgear::closure::{Wrench, measure};
use mpcgear::motion::{Motion, MotionFile};
use mpcgear::search;
use mpcgear::search::candidates::{Candidate, Workshop};
use mpcgear::solid::Solids;
use mpcgear::synthesis::{self, Bands};
use mpcgear::verify::{self, Mechanism, ProofSettings};

fn example(name: &str) -> (MotionFile, Motion) {
    let path = format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    MotionFile::read(Path::new(&path)).expect("examples are sound")
}

/// Prints the median time of `runs` runs of `work`.
fn bench<T>(name: &str, runs: usize, mut work: impl FnMut() -> T) {
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let started = Instant::now();
            black_box(work());
            started.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("| {name} | {:.4} |", 1e3 * times[runs / 2]);
}

fn search_steps() {
    let (file, motion) = example("trefoil");
    let workshop = Workshop::new(&motion, &file.settings);
    let mut usable: Vec<Candidate> = Vec::new();
    for first in (0..).step_by(256).take_while(|first| *first < 8192) {
        usable.extend(workshop.sample(1, first, 256).0);
        if usable.len() >= 4 {
            break;
        }
    }
    let law = usable.first().expect("a usable band").law.clone();
    bench("trace a band of 10 teeth (trefoil)", 300, || {
        workshop.trace(black_box(law.clone()))
    });
    let band = workshop.trace(law).expect("usable");
    bench("collision model of a band (trefoil)", 100, || {
        workshop.finish(black_box(&band))
    });
    let four: Vec<Wrench> = usable.iter().take(4).map(|band| band.wrenches[0]).collect();
    bench("Q of 4 contacts in 3 dimensions, 1000 times", 300, || {
        for _ in 0..1000 {
            black_box(measure(black_box(&four), 3));
        }
    });
}

fn proof() {
    let (mut file, motion) = example("uniform_1r");
    file.settings.search.effort = 0.05;
    let found = search::run(&motion, &file.settings, &mut |_| ControlFlow::Continue(()));
    let bands = found.expect("1R is feasible").choices.swap_remove(0).0;
    let design = synthesis::design(&file, &motion, &Bands::Exact(bands)).expect("traced");
    let solids = Solids::build(&design, &motion).expect("built");
    let mechanism = Mechanism {
        motion: &motion,
        center_distance: file.settings.gear.center_distance_mm,
    };
    let settings = ProofSettings {
        escape_phases: 1,
        directions: 1,
        ..ProofSettings::default()
    };
    bench(
        "proof that nothing meets over a turn (uniform_1r)",
        3,
        || {
            verify::prove(
                &solids.bodies,
                &mechanism,
                (&settings, &design.closure),
                &mut |_, _| ControlFlow::Continue(()),
            )
        },
    );
}

fn main() {
    println!("| what | median, ms |\n|---|---|");
    search_steps();
    proof();
}
