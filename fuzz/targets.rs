//! What is done with hostile input, one function a target; each says whether the input was accepted.
//! They are driven by libFuzzer (`fuzz_targets`), by the tests and by `benches/hostile.rs`.

use std::path::Path;

use mpcgear::design::Stored;
use mpcgear::export::stl;
use mpcgear::load::{self, Sampling};
use mpcgear::motion::{Class, Formula, Motion, MotionFile, MotionSource, Path as Curve, Table};
use mpcgear::verify::mesh;
use mpcgear::{Error, Result};

/// Longest message that may come of any input, bytes.
const LONGEST_MESSAGE: usize = 60_000;

/// What is done with an input; whether it was accepted.
pub type Target = fn(&[u8]) -> bool;

/// Every target with its name.
pub const ALL: [(&str, Target); 5] = [
    ("motion", motion),
    ("formula", formula),
    ("csv", csv),
    ("design", design),
    ("stl", stl),
];

/// Bad input is told as such, in a bounded message, and is never a defect of ours.
fn accepted<T>(result: Result<T>) -> Option<T> {
    match result {
        Ok(value) => Some(value),
        Err(error) => {
            assert!(!matches!(error, Error::Internal(_)), "{error}");
            assert!(error.to_string().len() < LONGEST_MESSAGE);
            None
        }
    }
}

/// A motion moves: its states are finite all around.
fn walk(motion: &Motion) {
    for i in 0..8 {
        let state = motion.state(f64::from(i));
        assert!(state.omega.iter().all(|x| x.is_finite()));
        assert!(state.pose.rotation.iter().all(|x| x.is_finite()));
    }
}

/// A motion file; files that it refers to do not exist.
pub fn motion(data: &[u8]) -> bool {
    let text = String::from_utf8_lossy(data);
    let read = MotionFile::parse(&text, Path::new("my.toml"), Path::new("no/such/folder"));
    accepted(read).map(|(_, motion)| walk(&motion)).is_some()
}

/// A formula, as a rotation and as a constant.
pub fn formula(data: &[u8]) -> bool {
    let text = String::from_utf8_lossy(data).into_owned();
    let mut formula = Formula {
        rotation: Some([text.clone(), "a".into(), "0".into()]),
        ..Formula::default()
    };
    formula.constants.insert("a".into(), "0.1".into());
    let read = Motion::new(Class::R3, &MotionSource::Formula(formula.clone()));
    let varies = accepted(read).map(|motion| walk(&motion)).is_some();
    formula.rotation = None;
    formula.constants.insert("b".into(), text);
    varies | accepted(Motion::new(Class::R3, &MotionSource::Formula(formula))).is_some()
}

/// A table of poses, and one of points.
pub fn csv(data: &[u8]) -> bool {
    let text = String::from_utf8_lossy(data);
    let table = accepted(Table::from_csv(&text, "poses.csv"));
    let table = table.and_then(|t| accepted(Motion::new(Class::R3T1, &MotionSource::Table(t))));
    let curve = accepted(Curve::from_csv(&text, "points.csv"));
    let curve = curve.and_then(|c| accepted(Motion::new(Class::R3, &MotionSource::Path(c))));
    let motions = [table, curve];
    motions.iter().flatten().for_each(walk);
    motions.iter().any(Option::is_some)
}

/// A `design.json`, and what it has to bear.
pub fn design(data: &[u8]) -> bool {
    let Some(stored) = accepted(Stored::parse(data, Path::new("design.json"))) else {
        return false;
    };
    if let Some((design, motion, _)) = accepted(stored.with_motion()) {
        let few = Sampling {
            count: 2,
            ..Sampling::default()
        };
        accepted(load::analyse(&design, &motion, &design.settings.load, few));
    }
    true
}

/// An STL file, and what is wrong with its mesh.
pub fn stl(data: &[u8]) -> bool {
    let read = accepted(stl::parse(data.to_vec(), Path::new("part.stl")));
    read.map(|mesh| mesh::problems("part", &mesh)).is_some()
}
