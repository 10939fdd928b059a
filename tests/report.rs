//! The report as a browser shows it.

mod synthetic;

use std::path::PathBuf;

use mpcgear::design::Design;
use mpcgear::export::report::{self, Claim, FileLink, Moves, Part, ReportInput};
use mpcgear::load::sensitivity::sensitivity;
use mpcgear::load::{Load, Sampling, analyse};
use synthetic::{meshes, motion, revolute, spherical};

fn scratch(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Writes the report of `design` with everything in it.
fn full_report(mut design: Design, name: &str) -> PathBuf {
    design.settings.load = Load {
        mass_g: 200.0,
        point_mm: [18.0, 0.0, 58.0],
        gravity: [0.2, 0.0, -1.0],
        ..Load::default()
    };
    let motion = motion(design.class);
    let sampling = Sampling::default();
    let load = analyse(&design, &motion, &design.settings.load, sampling).unwrap();
    let few = Sampling {
        count: 40,
        ..sampling
    };
    let errors = sensitivity(&design, &motion, &design.settings.load, few).unwrap();
    let bodies = meshes::bodies(&design, &motion);
    let moves = [Moves::Driver, Moves::Follower, Moves::Fixed];
    let parts: Vec<Part> = bodies
        .iter()
        .zip(moves)
        .map(|((label, mesh), moves)| Part { label, moves, mesh })
        .collect();
    let claim = |name: &str, meaning: &str, figure: &str| Claim {
        name: name.into(),
        meaning: meaning.into(),
        figure: figure.into(),
        limit: "0 mm³".into(),
        place: "φ = 12.0°".into(),
        holds: true,
    };
    let path = scratch(name);
    report::write(
        &ReportInput {
            design: &design,
            motion: &motion,
            sampling,
            parts: &parts,
            claims: &[
                claim("no overlap", "No two parts ever share space.", "0 mm³"),
                claim(
                    "no escape",
                    "The follower cannot be moved with the motor held.",
                    "0 of 2304",
                ),
            ],
            load: Some(&load),
            sensitivity: Some(&errors),
            files: &[FileLink {
                path: "print/driver.stl".into(),
                note: "print upright".into(),
                group: "Print".into(),
            }],
            motion_file: "name = \"<b>bold</b>\"\n",
        },
        &path,
    )
    .unwrap();
    path
}

#[test]
fn the_report_is_one_small_file_without_links_to_the_network() {
    let path = full_report(revolute(), "revolute.html");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.len() < 10_000_000, "{} bytes", text.len());
    for link in ["src=\"http", "href=\"http", "url(http", "@import", "fetch("] {
        assert!(!text.contains(link), "{link}");
    }
    assert!(text.contains("&lt;b&gt;bold"), "the user's text is escaped");
    let _ = full_report(spherical(), "spherical.html");
}
