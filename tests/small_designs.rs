//! One small seeded design a class: as good as it was, sound on the meshes, and the same bytes whatever
//! the number of threads.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use mpcgear::design::{ClosureSample, Design, file};
use mpcgear::motion::{Motion, MotionFile};
use mpcgear::search;
use mpcgear::solid::Solids;
use mpcgear::solid::kernel::Solid;
use mpcgear::synthesis::{self, Bands};

/// Phases at which driver and follower are tried for overlap.
const PHASES: i32 = 12;

/// A motion of `class`, with little search.
fn motion_file(class: &str, motion: &str, effort: f64) -> (MotionFile, Motion) {
    let text = format!(
        "name = \"small\"\nclass = \"{class}\"\n[motion]\nkind = \"formula\"\n{motion}\n\
         [search]\neffort = {effort}\nseed = 3\n"
    );
    MotionFile::parse(&text, Path::new("small.toml"), Path::new(".")).expect("a motion")
}

/// The best choice of bands, searched on `threads` threads.
fn designed(file: &MotionFile, motion: &Motion, threads: usize) -> Design {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads").install(|| {
        let found = search::run(motion, &file.settings, &mut |_| ControlFlow::Continue(()));
        let (bands, _) = found.expect("bands").choices.remove(0);
        synthesis::design(file, motion, &Bands::Exact(bands)).expect("a design")
    })
}

/// The hold (min Q, where units mix min Q*) at least `floor` with K = N + 1, three runs alike, conjugate, and sound where it is checked.
fn holds((class, motion, effort): (&str, &str, f64), pairs: usize, floor: f64) {
    let (given, motion) = motion_file(class, motion, effort);
    let design = designed(&given, &motion, 1);
    let text = file::text(&design).expect("text");
    for threads in [2, 1] {
        let again = file::text(&designed(&given, &motion, threads)).expect("text");
        assert!(text == again, "{threads} threads give another design");
    }
    assert!(text.len() <= 2_500_000, "{} bytes", text.len());
    let hold = |s: &ClosureSample| if class.contains('T') { s.q_star } else { s.q };
    let held = design.closure.iter().map(hold);
    let held = held.fold(f64::INFINITY, f64::min);
    assert!(held >= floor, "the hold is {held}, was {floor}");
    assert_eq!(design.sub_gear_pairs.len(), pairs);
    let residual = synthesis::conjugation_residual(&design, &motion);
    assert!(residual < 1e-9, "{residual}");
    let solids = Solids::build(&design, &motion).expect("solids");
    // The kernel's own booleans, not the program's proof, at phases that no grid of its has.
    let [driver, follower] = &solids.bodies[..2] else {
        panic!("two gears");
    };
    for i in 0..PHASES {
        let phi = TAU * (f64::from(i) + 0.371) / f64::from(PHASES);
        let solid = |body| Solid::new(&solids.placed(body, &design, &motion, phi), "gear");
        let (driver, follower) = (
            solid(driver).expect("solid"),
            solid(follower).expect("solid"),
        );
        let shared = driver.intersection(&follower).mesh().volume();
        assert!(shared < 1e-6, "{shared} mm³ shared at φ = {phi}");
    }
}

#[test]
fn revolute() {
    holds(("1R", "own_turn = \"-phi + 0.1*sin(phi)\"", 0.03), 2, 6.0);
}

#[test]
fn cylindrical() {
    let motion = "own_turn = \"-phi\"\ntranslation = [\"0\", \"0\", \"1.5*sin(phi)\"]";
    holds(("1R1T", motion, 0.05), 3, 0.15);
}

#[test]
fn spherical() {
    let motion = "own_turn = \"-phi\"\naxis = [\"0.06*sin(phi)\", \"0.06*cos(phi)\", \"1\"]";
    holds(("3R", motion, 0.03), 4, 3.5);
}

#[test]
fn spherical_and_sliding() {
    let motion = "own_turn = \"-phi\"\naxis = [\"0.05*sin(phi)\", \"0.05*cos(phi)\", \"1\"]\n\
                  translation = [\"0\", \"0\", \"0.8*sin(phi)\"]";
    holds(("3R1T", motion, 0.03), 5, 0.1);
}
