//! Designs without an optimiser: helical teeth that roll on the pitch line of a uniform motion.
#![allow(dead_code)] // every test file uses its own part of this

use mpcgear::design::{Contact, Design, FORMAT, Section, Station, SubGearPair, ToothPair};
use mpcgear::export::Source;
use mpcgear::motion::{Class, Motion, MotionFile, MotionSource};
use mpcgear::settings::{Settings, ToothCount};
use mpcgear::solid::Solids;
use mpcgear::solid::recipe::Recipe;
use nalgebra::Vector3;

/// One band: middle height, axial travel along a tooth, turning side.
pub type Band = (f64, f64, f64);

/// Pressure angle of the synthetic teeth, rad.
const PRESSURE_ANGLE: f64 = 0.5;

/// Uniform design with the usual bands of a class.
pub fn uniform(class: Class) -> (Design, Motion) {
    let source = MotionSource::Uniform {};
    let motion = Motion::new(class, &source).expect("uniform motion fits every class");
    let design = with_motion((class, Settings::default()), source, &motion);
    (design, motion)
}

/// The same with twice as many teeth on the driver, as far apart as usual.
pub fn unequal(class: Class) -> (Design, Motion) {
    let source = MotionSource::Uniform {};
    let motion = Motion::new(class, &source).expect("uniform motion fits every class");
    let mut settings = Settings::default();
    settings.gear.driver_teeth = ToothCount::Fixed(2 * settings.gear.teeth);
    settings.gear.center_distance_mm = 37.5;
    let mut design = with_motion((class, settings), source, &motion);
    design.name = format!("synthetic {class} unequal");
    (design, motion)
}

/// The uniform design of `class` under that name, with its solids as exports take it, handed to `use_it`.
pub fn with_source<T>(class: Class, name: &str, use_it: impl FnOnce(&Source) -> T) -> T {
    let (mut design, motion) = uniform(class);
    design.name = name.into();
    let solids = Solids::build(&design, &motion).expect("builds");
    use_it(&Source {
        design: &design,
        motion: &motion,
        solids: Some(&solids),
    })
}

/// The usual bands under the motion of one of the examples. Where it tilts or slides the teeth are
/// not conjugate: only their places and sizes are those of real ones.
pub fn example(name: &str) -> (Design, Motion) {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/{name}.toml"));
    let (file, motion) = MotionFile::read(&path).expect("examples are sound");
    let design = with_motion((file.class, Settings::default()), file.source, &motion);
    (design, motion)
}

fn with_motion(
    (class, settings): (Class, Settings),
    source: MotionSource,
    motion: &Motion,
) -> Design {
    let bands: &[Band] = match class {
        Class::R1 => &[(0.0, 7.0, 1.0), (11.0, -7.0, 1.0)],
        Class::R1T1 => &[(0.0, 7.0, 1.0), (11.0, -7.0, 1.0), (22.0, 7.0, -1.0)],
        Class::R3 => &[
            (14.0, 7.0, 1.0),
            (25.0, -7.0, 1.0),
            (-14.0, -7.0, -1.0),
            (-25.0, 7.0, -1.0),
        ],
        Class::R3T1 => &[
            (14.0, 7.0, 1.0),
            (25.0, -7.0, 1.0),
            (36.0, 7.0, -1.0),
            (-14.0, -7.0, -1.0),
            (-25.0, 7.0, -1.0),
        ],
    };
    let gear = &settings.gear;
    let section = Section::of(&settings);
    let sub_gear_pairs = bands
        .iter()
        .map(|&band| SubGearPair {
            flank_radius: None,
            parameters: Vec::new(),
            teeth: (0..gear.teeth)
                .map(|j| tooth(motion, &settings, band, j))
                .collect(),
        })
        .collect();
    Design {
        format: FORMAT,
        generator: "test".into(),
        name: format!("synthetic {class}"),
        class,
        settings,
        motion: source,
        sub_gear_pairs,
        section,
        recipe: Recipe::default(),
        closure: Vec::new(),
        problems: Vec::new(),
    }
}

fn tooth(motion: &Motion, settings: &Settings, (z0, travel, side): Band, j: usize) -> ToothPair {
    let gear = &settings.gear;
    let pitch = std::f64::consts::TAU / gear.teeth as f64;
    let (middle, length) = ((j as f64 + 0.5) * pitch, gear.contact_ratio * pitch);
    let rise = travel / length;
    let stations = (0..=24)
        .map(|i| {
            let u = f64::from(i) / 24.0 - 0.5;
            let phi = middle + u * length;
            let p = Vector3::new(
                -gear.drive().follower_pitch_radius(1.0),
                0.0,
                z0 + travel * u,
            );
            let driver = gear.drive().state(phi);
            let follower = motion.state(phi);
            let velocity = Vector3::new(0.0, 0.0, rise);
            let across = side * Vector3::x().cross(&(velocity - follower.velocity(p)));
            let n = PRESSURE_ANGLE.sin() * Vector3::x() + PRESSURE_ANGLE.cos() * across.normalize();
            let contact = Contact {
                phi,
                p,
                n,
                v: velocity,
            };
            Station::new(contact, &driver, &follower)
        })
        .collect();
    ToothPair {
        phi_start: middle - 0.5 * length,
        phi_end: middle + 0.5 * length,
        control_points: Vec::new(),
        fit_error: 0.0,
        flare: Default::default(),
        stations,
    }
}
