//! The MuJoCo model: well-formed, with the joints of its class and every tooth where its flank is.

mod synthetic;

use mpcgear::export::format::{Format, render};
use mpcgear::motion::Class;

/// The model of the synthetic design of `class`, and the design.
fn model(class: Class, name: &str) -> (String, mpcgear::design::Design) {
    synthetic::with_source(class, name, |source| {
        let files = render(source, Format::Mjcf, None).expect("renders");
        assert_eq!(files.len(), 1);
        let text = String::from_utf8(files[0].bytes.clone()).expect("text");
        let error = render(source, Format::Mjcf, Some("driver")).expect_err("needs both gears");
        assert_eq!(error.exit_code(), 2);
        (text, source.design.clone())
    })
}

/// The elements `name` of `text`, each as the text of its attributes.
fn elements<'a>(text: &'a str, name: &str) -> Vec<&'a str> {
    let head = format!("<{name} ");
    text.split(&head)
        .skip(1)
        .map(|rest| rest.split('>').next().expect("text"))
        .collect()
}

fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
    let head = format!(" {name}=\"");
    let padded = element.find(&head).map(|at| at + head.len());
    let start = padded.or_else(|| element.starts_with(&head[1..]).then(|| head.len() - 1));
    let start = start.unwrap_or_else(|| panic!("no {name} in {element}"));
    element[start..].split('"').next().expect("text")
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace()
        .map(|x| x.parse().expect("a number"))
        .collect()
}

/// Every element that is opened is closed in order, and comments have no `--`.
fn well_formed(text: &str) {
    let (head, body) = text.split_once("-->").expect("a head comment");
    let head = head.strip_prefix("<!--").expect("a head comment");
    assert!(!head.contains("--"), "{head}");
    let mut open = Vec::new();
    for tag in body.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').expect("a closed tag");
        if let Some(comment) = tag.strip_prefix("!--") {
            let comment = comment.strip_suffix("--").expect("an ended comment");
            assert!(!comment.contains("--"), "{comment}");
            continue;
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().expect("a name"));
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn the_follower_has_the_joints_of_its_class() {
    for (class, expected) in [
        (Class::R1, vec!["hinge"]),
        (Class::R1T1, vec!["slide", "hinge"]),
        (Class::R3, vec!["ball"]),
        (Class::R3T1, vec!["slide", "ball"]),
    ] {
        let (text, _) = model(class, "a < b & \"c\" --");
        well_formed(&text);
        let joints = elements(&text, "joint");
        let kinds: Vec<&str> = joints.iter().map(|j| attribute(j, "type")).collect();
        assert_eq!(kinds[0], "hinge", "the driver's");
        assert_eq!(kinds[1..], expected, "{class}");
        for joint in joints.iter().filter(|j| j.contains("axis=")) {
            assert_eq!(numbers(attribute(joint, "axis")), [0.0, 0.0, 1.0]);
        }
    }
}

#[test]
fn capsules_run_along_the_centres_of_the_flank_circles() {
    let (text, design) = model(Class::R1, "gear");
    let radius = design.section.bead_radius();
    assert!(text.contains(&format!("type=\"capsule\" size=\"{:.9}\"", 1e-3 * radius)));
    let teeth: usize = design.sub_gear_pairs.iter().map(|p| p.teeth.len()).sum();
    let capsules = elements(&text, "geom class=\"driver_tooth\"");
    assert_eq!(capsules.len(), 16 * teeth);
    assert_eq!(
        elements(&text, "geom class=\"follower_tooth\"").len(),
        16 * teeth
    );
    // The first capsule of a tooth begins, and its last ends, a flank radius and half the clearance
    // behind the contact, seen from the driver's axis.
    let depth = radius + 0.5 * design.section.clearance;
    let station = |tooth: usize, last: bool| {
        let stations = &design.sub_gear_pairs[1].teeth[tooth].stations;
        let s = &stations[if last { stations.len() - 1 } else { 0 }];
        let axis = [-design.settings.gear.center_distance_mm, 0.0, 0.0];
        [0, 1, 2].map(|i| 1e-3 * (s.p1[i] + depth * s.n1[i] - axis[i]))
    };
    for tooth in [0, 4] {
        for (piece, last) in [(1, false), (16, true)] {
            let name = format!("driver_2_{}_{piece}", tooth + 1);
            let capsule = capsules.iter().find(|c| attribute(c, "name") == name);
            let ends = numbers(attribute(capsule.expect("is there"), "fromto"));
            let end = if last { &ends[3..] } else { &ends[..3] };
            for (a, b) in end.iter().zip(station(tooth, last)) {
                assert!((a - b).abs() < 2e-9, "{name}: {a} {b}");
            }
        }
    }
}

#[test]
fn load_and_target_motion_are_in_kilograms_and_metres() {
    let (text, design) = model(Class::R3T1, "gear");
    let payload = elements(&text, "geom name=\"payload\"")[0];
    assert_eq!(attribute(payload, "mass"), "0.1");
    assert_eq!(numbers(attribute(payload, "pos")), [0.0, 0.0, 0.06]);
    let friction = format!("friction=\"{} 0 0\"", design.settings.load.friction);
    assert!(text.contains(&friction));
    let target = elements(&text, "numeric name=\"target\"")[0];
    let rows = numbers(attribute(target, "data"));
    assert_eq!(rows.len(), 361 * 7);
    assert_eq!(attribute(target, "size"), "2527");
    // The synthetic motion turns by −φ about z.
    let half = 30f64.to_radians();
    assert!((rows[60 * 7 + 3] - half.cos()).abs() < 1e-8);
    assert!((rows[60 * 7 + 6] + half.sin()).abs() < 1e-8);
}
