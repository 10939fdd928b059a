//! `all_poses.csv`: where driver and follower are over a whole cycle, for other programs.

use nalgebra::UnitQuaternion;

use super::Source;
use crate::motion::Pose;
use crate::{Error, Result};

/// Phases of a period of the motion; a degree apart where it is a whole turn.
const STEPS: usize = 360;

/// The columns: phase, angle of the driver, then position and quaternion of each gear's frame in Σ.
const COLUMNS: [&str; 16] = [
    "phase_deg",
    "driver_angle_deg",
    "driver_x_mm",
    "driver_y_mm",
    "driver_z_mm",
    "driver_qw",
    "driver_qx",
    "driver_qy",
    "driver_qz",
    "follower_x_mm",
    "follower_y_mm",
    "follower_z_mm",
    "follower_qw",
    "follower_qx",
    "follower_qy",
    "follower_qz",
];

/// A row per degree of phase over one turn of the driver or one way through its range, nine decimals. The
/// driver's frame is Σ at φ = 0, turned about the driver's axis; quaternions keep their sign from row to row.
///
/// # Errors
/// [`Error::Internal`] when the encoder fails.
pub fn csv(source: &Source) -> Result<Vec<u8>> {
    let fail = |e: String| Error::Internal(format!("all_poses.csv: {e}"));
    let drive = source.design.settings.gear.drive();
    let cycle = source.motion.cycle();
    let periods = if cycle.wraps() { drive.copies() } else { 1 };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = writer.write_record(COLUMNS);
    header.map_err(|e| fail(e.to_string()))?;
    let mut last = [UnitQuaternion::identity(); 2];
    for i in 0..=STEPS * periods {
        let phi = cycle.start() + cycle.length() * i as f64 / STEPS as f64;
        let poses = [drive.state(phi).pose, source.motion.state(phi).pose];
        let mut row = vec![phi.to_degrees(), (phi * drive.rate()).to_degrees()];
        for (pose, last) in poses.iter().zip(&mut last) {
            *last = on_side(pose, last);
            row.extend(pose.translation.iter());
            row.extend([last.w, last.i, last.j, last.k]);
        }
        // No negative zero.
        let row = row
            .iter()
            .map(|x| format!("{:.9}", (x * 1e9).round() / 1e9 + 0.0));
        writer.write_record(row).map_err(|e| fail(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| fail(e.to_string()))
}

/// The rotation as the quaternion on the side of the one before.
fn on_side(pose: &Pose, before: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let q = pose.quaternion();
    match q.coords.dot(&before.coords) < 0.0 {
        true => UnitQuaternion::new_unchecked(-q.into_inner()),
        false => q,
    }
}
