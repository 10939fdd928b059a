//! How a mechanism is made, and the gaps and errors that go with it: one table for the motion file, the
//! pieces to print and the sets of OpenSCAD's Customizer.

use serde::{Deserialize, Serialize};

use super::{Fit, Settings};

/// A way of making the parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Profile {
    /// None in particular: what suits most printers.
    #[default]
    #[serde(rename = "any")]
    Any,
    /// Filament from a 0.4 mm nozzle.
    #[serde(rename = "fdm_0.4")]
    Fdm04,
    /// Filament from a 0.6 mm nozzle.
    #[serde(rename = "fdm_0.6")]
    Fdm06,
    /// Resin cured by light.
    #[serde(rename = "sla")]
    Sla,
    /// Powder sintered by a laser.
    #[serde(rename = "sls")]
    Sls,
    /// Machined or sintered metal, ground or lapped where it runs.
    #[serde(rename = "metal")]
    Metal,
}

/// What a way of making needs: gaps that are left, and errors that are expected. Values of practice for
/// machines that are set up well (outlines of filament prints lie 0.07 ± 0.02 mm off); measure your own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowances {
    /// Gap between flanks, mm.
    pub clearance_mm: f64,
    /// Radial gap of journals, pin and ball, mm.
    pub joint_play_mm: f64,
    /// Gap between printed pieces that are screwed together, mm.
    pub piece_fit_mm: f64,
    /// How far the first layers are drawn in, mm.
    pub elephant_foot_mm: f64,
    /// How far a made surface may lie outside its place, mm.
    pub surface_error_mm: f64,
    /// Radial gap of a bore on its shaft, mm.
    pub bore_fit_mm: f64,
    /// Radial gap around a bought bearing, mm.
    pub bearing_fit_mm: f64,
    /// Largest error of the centre distance, mm.
    pub center_distance_error_mm: f64,
    /// Largest tilt of the driver axis, deg.
    pub axis_tilt_error_deg: f64,
    /// Largest error of a gear's scale, percent.
    pub scale_error_percent: f64,
}

impl Profile {
    /// All of them.
    pub const ALL: [Profile; 6] = [
        Profile::Any,
        Profile::Fdm04,
        Profile::Fdm06,
        Profile::Sla,
        Profile::Sls,
        Profile::Metal,
    ];

    /// Its name in a motion file.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Any => "any",
            Profile::Fdm04 => "fdm_0.4",
            Profile::Fdm06 => "fdm_0.6",
            Profile::Sla => "sla",
            Profile::Sls => "sls",
            Profile::Metal => "metal",
        }
    }

    /// What it needs.
    pub fn allowances(self) -> Allowances {
        let usual = Allowances {
            clearance_mm: 0.1,
            joint_play_mm: 0.15,
            piece_fit_mm: 0.1,
            elephant_foot_mm: 0.0,
            surface_error_mm: 0.03,
            bore_fit_mm: 0.1,
            bearing_fit_mm: 0.05,
            center_distance_error_mm: 0.1,
            axis_tilt_error_deg: 0.2,
            scale_error_percent: 0.2,
        };
        match self {
            Profile::Any => usual,
            Profile::Fdm04 => Allowances {
                clearance_mm: 0.15,
                joint_play_mm: 0.2,
                piece_fit_mm: 0.15,
                elephant_foot_mm: 0.2,
                bore_fit_mm: 0.15,
                bearing_fit_mm: 0.1,
                ..usual
            },
            Profile::Fdm06 => Allowances {
                clearance_mm: 0.18,
                joint_play_mm: 0.3,
                piece_fit_mm: 0.2,
                elephant_foot_mm: 0.3,
                surface_error_mm: 0.04,
                bore_fit_mm: 0.2,
                bearing_fit_mm: 0.15,
                center_distance_error_mm: 0.12,
                axis_tilt_error_deg: 0.25,
                scale_error_percent: 0.25,
            },
            Profile::Sla => Allowances {
                joint_play_mm: 0.08,
                piece_fit_mm: 0.05,
                surface_error_mm: 0.015,
                bore_fit_mm: 0.05,
                center_distance_error_mm: 0.05,
                axis_tilt_error_deg: 0.1,
                scale_error_percent: 0.15,
                ..usual
            },
            Profile::Sls => Allowances {
                clearance_mm: 0.15,
                joint_play_mm: 0.25,
                piece_fit_mm: 0.2,
                bore_fit_mm: 0.15,
                bearing_fit_mm: 0.1,
                ..usual
            },
            Profile::Metal => Allowances {
                clearance_mm: 0.06,
                joint_play_mm: 0.05,
                piece_fit_mm: 0.03,
                surface_error_mm: 0.003,
                bore_fit_mm: 0.02,
                bearing_fit_mm: 0.02,
                center_distance_error_mm: 0.03,
                axis_tilt_error_deg: 0.05,
                scale_error_percent: 0.02,
                ..usual
            },
        }
    }
}

impl Settings {
    /// Gaps and errors that were not `given` (by section and field) become what the profile needs.
    pub(super) fn follow_profile(&mut self, given: impl Fn(&str, &str) -> bool) {
        let needs = self.fit.profile.allowances();
        let Fit {
            clearance_mm,
            joint_play_mm,
            piece_fit_mm,
            elephant_foot_mm,
            surface_error_mm: surface,
            ..
        } = &mut self.fit;
        let load = &mut self.load;
        let (distance, tilt, scale) = (
            &mut load.center_distance_error_mm,
            &mut load.axis_tilt_error_deg,
            &mut load.scale_error_percent,
        );
        for (section, key, field, value) in [
            ("fit", "clearance_mm", clearance_mm, needs.clearance_mm),
            ("fit", "joint_play_mm", joint_play_mm, needs.joint_play_mm),
            ("fit", "surface_error_mm", surface, needs.surface_error_mm),
            ("fit", "piece_fit_mm", piece_fit_mm, needs.piece_fit_mm),
            (
                "fit",
                "elephant_foot_mm",
                elephant_foot_mm,
                needs.elephant_foot_mm,
            ),
            (
                "load",
                "center_distance_error_mm",
                distance,
                needs.center_distance_error_mm,
            ),
            (
                "load",
                "axis_tilt_error_deg",
                tilt,
                needs.axis_tilt_error_deg,
            ),
            (
                "load",
                "scale_error_percent",
                scale,
                needs.scale_error_percent,
            ),
        ] {
            if !given(section, key) {
                *field = value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_sets_what_is_not_given() {
        for profile in Profile::ALL {
            let named = serde_json::to_string(&profile).unwrap();
            assert_eq!(named, format!("\"{}\"", profile.name()));
            let needs = profile.allowances();
            let mut settings = Settings::default();
            settings.fit.profile = profile;
            settings.fit.joint_play_mm = 0.123;
            settings.follow(|_, key| key == "joint_play_mm");
            assert_eq!(settings.fit.joint_play_mm, 0.123);
            assert_eq!(settings.fit.clearance_mm, needs.clearance_mm);
            assert_eq!(settings.fit.elephant_foot_mm, needs.elephant_foot_mm);
            assert_eq!(settings.load.scale_error_percent, needs.scale_error_percent);
        }
    }

    #[test]
    fn without_a_profile_the_defaults_stay() {
        let mut settings = Settings::default();
        settings.follow(|_, _| false);
        assert_eq!(settings, Settings::default());
    }
}
