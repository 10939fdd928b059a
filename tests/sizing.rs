//! The size that carries a payload, and demands of one.

use std::ops::ControlFlow;
use std::path::Path;

use mpcgear::motion::{Motion, MotionFile};
use mpcgear::pipeline;
use mpcgear::sizing::{self, Demand};
use mpcgear::verify::PAYLOAD;

/// A follower that turns uniformly under a weight which loads its teeth, searched with little effort.
fn turning(more: &str) -> (MotionFile, Motion) {
    let text = format!(
        "class = \"1R\"\n[motion]\nkind = \"formula\"\nown_turn = \"-phi\"\n\
         [search]\neffort = 0.1\n[load]\ngravity = [1.0, 0.0, -1.0]\npoint_mm = [30.0, 0.0, 60.0]\n{more}"
    );
    MotionFile::parse(&text, Path::new("my.toml"), Path::new(".")).expect("a motion")
}

/// Payload and whether the claim about it holds.
fn carried(more: &str) -> (f64, bool, Vec<String>) {
    let (file, motion) = turning(more);
    let outcome = pipeline::run(&file, &motion, &mut |_| ControlFlow::Continue(()));
    let outcome = outcome.expect("a design");
    let check = outcome.check.expect("proved");
    let claim = check.claims.iter().find(|c| c.name == PAYLOAD);
    let claim = claim.expect("the claim");
    let problems = outcome.design.problems;
    assert_eq!(claim.holds, problems.is_empty(), "{problems:?}");
    (claim.value.expect("limited"), claim.holds, outcome.remarks)
}

#[test]
fn a_payload_is_demanded_and_an_overload_is_told() {
    let (payload_g, holds, remarks) = carried("");
    assert!(
        holds && payload_g > 100.0 && remarks.is_empty(),
        "{payload_g} g, {remarks:?}"
    );
    let too_much = 20.0 * payload_g;
    let (_, holds, _) = carried(&format!("payload_at_least_g = {too_much}"));
    assert!(
        !holds,
        "{too_much} g are carried by a gear for {payload_g} g"
    );
    let (_, holds, remarks) = carried(&format!("mass_g = {too_much}"));
    assert!(holds, "nothing is demanded");
    assert!(
        remarks.iter().any(|r| r.starts_with("overloaded")),
        "{remarks:?}"
    );
}

#[test]
fn the_smallest_size_is_proved_and_the_next_smaller_is_not_enough() {
    let (file, motion) = turning("");
    let given = file.settings.gear.center_distance_mm;
    let base = carried("").0;
    let demand = Demand {
        payload_g: 2.0 * base,
        deflection_mm: None,
    };
    let found = sizing::smallest(&file, &motion, demand, &mut |_| ControlFlow::Continue(()));
    let found = found.expect("no defect");
    let size = found.center_distance_mm.expect("a size that carries it");
    assert!(size != given, "{found:?}");
    let of = |size: f64| found.tried.iter().find(|t| t.center_distance_mm == size);
    let smallest = of(size).expect("tried");
    assert_eq!(smallest.problems.as_deref(), Some(&[][..]));
    assert!(smallest.payload_g.expect("limited") >= demand.payload_g);
    let smaller = found.tried.iter().filter(|t| t.center_distance_mm < size);
    let nearest = smaller.max_by(|a, b| a.center_distance_mm.total_cmp(&b.center_distance_mm));
    let nearest = nearest.expect("a smaller size was tried");
    assert!(
        !nearest.is_enough || nearest.problems.is_some(),
        "{nearest:?}"
    );
    assert!(size - nearest.center_distance_mm <= 0.03 * size + 1.0);
}

#[test]
fn a_break_ends_the_search_for_a_size() {
    let (file, motion) = turning("");
    let demand = Demand {
        payload_g: 100.0,
        deflection_mm: None,
    };
    let stopped = sizing::smallest(&file, &motion, demand, &mut |_| ControlFlow::Break(()));
    let stopped = stopped.expect("what there is");
    assert!(stopped.stopped && stopped.center_distance_mm.is_none());
}
