//! The `[load]` table of a motion file.

use serde::{Deserialize, Serialize};

use super::Material;

/// What the mechanism has to carry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Load {
    /// Mass on the end-effector, g. Default 100.
    pub mass_g: f64,
    /// What the mechanism has to carry by the limits of force, pressure and patch, g: a design that does
    /// not is infeasible. Default 0, no demand.
    pub payload_at_least_g: f64,
    /// Its centre, and where extra forces act, in the follower frame, mm. Default (0, 0, 60).
    pub point_mm: [f64; 3],
    /// Direction of gravity in Σ, any length but zero. Default (0, 0, −1).
    pub gravity: [f64; 3],
    /// Further force and torque on the follower over φ, in Σ; periodic, linear between rows. Default none.
    pub extra: Vec<ExtraLoad>,
    /// How many times the force that the largest payload brings contacts and roots bear: by pressure, patch and
    /// root stress. Default 1.5.
    pub safety: f64,
    /// Largest force one contact may carry, N. Default 50.
    pub force_limit_n: f64,
    /// Coulomb friction coefficient of the flanks. Default 0.2.
    pub friction: f64,
    /// Material of the driver. Default "PLA".
    pub driver_material: Material,
    /// Material of the follower. Default "PLA".
    pub follower_material: Material,
    /// Largest error of the centre distance, mm. Default 0.1.
    pub center_distance_error_mm: f64,
    /// Largest tilt of the driver axis, deg. Default 0.2.
    pub axis_tilt_error_deg: f64,
    /// Largest error of scale of either printed gear (shrinkage), percent. Default 0.2.
    pub scale_error_percent: f64,
}

/// One row of the table of extra loads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExtraLoad {
    /// Driver angle, deg, within one period.
    pub phi_deg: f64,
    /// Force at the load point, Σ, N.
    pub force_n: [f64; 3],
    /// Torque, Σ, N·mm.
    pub torque_nmm: [f64; 3],
}

impl Default for Load {
    fn default() -> Self {
        let needs = crate::settings::Profile::default().allowances();
        Load {
            mass_g: 100.0,
            payload_at_least_g: 0.0,
            point_mm: [0.0, 0.0, 60.0],
            gravity: [0.0, 0.0, -1.0],
            extra: Vec::new(),
            safety: 1.5,
            force_limit_n: 50.0,
            friction: 0.2,
            driver_material: Material::Pla,
            follower_material: Material::Pla,
            center_distance_error_mm: needs.center_distance_error_mm,
            axis_tilt_error_deg: needs.axis_tilt_error_deg,
            scale_error_percent: needs.scale_error_percent,
        }
    }
}

/// Farthest place of the load, mm.
const FARTHEST_MM: f64 = 50_000.0;

/// Most rows of extra loads.
const MAX_EXTRA: usize = 3600;

impl Load {
    /// Largest Hertz pressure that the weaker of both materials bears, MPa.
    pub fn pressure_allowed(&self) -> f64 {
        let of = |material: super::Material| material.allowed_pressure();
        of(self.driver_material).min(of(self.follower_material))
    }

    /// Everything that is wrong with the table, one entry per field; empty when it can be used.
    pub fn problems(&self) -> Vec<crate::Problem> {
        let mut problems = Vec::new();
        let mut demand = |holds: bool, field: &str, what: String| {
            if !holds {
                problems.push(crate::Problem::new(format!("load.{field}"), what, ""));
            }
        };
        for (field, value, most) in [
            ("mass_g", self.mass_g, 1e6),
            ("payload_at_least_g", self.payload_at_least_g, 1e6),
            ("force_limit_n", self.force_limit_n, 1e6),
            ("friction", self.friction, 10.0),
            (
                "center_distance_error_mm",
                self.center_distance_error_mm,
                10.0,
            ),
            ("axis_tilt_error_deg", self.axis_tilt_error_deg, 45.0),
            ("scale_error_percent", self.scale_error_percent, 50.0),
        ] {
            let what = format!("is {value}, allowed 0 to {most}");
            demand((0.0..=most).contains(&value), field, what);
        }
        demand(
            self.force_limit_n != 0.0,
            "force_limit_n",
            "is 0, must be larger".into(),
        );
        demand(
            (1.0..=10.0).contains(&self.safety),
            "safety",
            format!("is {}, allowed 1 to 10", self.safety),
        );
        let within = |most: f64| move |x: &f64| x.abs() <= most;
        demand(
            self.point_mm.iter().all(within(FARTHEST_MM)),
            "point_mm",
            format!("must be three numbers of at most {FARTHEST_MM}"),
        );
        let g = self.gravity;
        demand(
            g.iter().all(within(1e6)) && g.iter().any(|x| x.abs() > 1e-6),
            "gravity",
            "must be a direction: three numbers of at most 1000000, not all zero".into(),
        );
        let rows = self.extra.len();
        demand(
            rows <= MAX_EXTRA,
            "extra",
            format!("has {rows} rows, allowed {MAX_EXTRA}"),
        );
        for (i, row) in self.extra.iter().enumerate().take(MAX_EXTRA) {
            let bounded =
                row.force_n.iter().all(within(1e6)) && row.torque_nmm.iter().all(within(1e9));
            demand(
                bounded && (0.0..=360.0).contains(&row.phi_deg),
                &format!("extra[{i}]"),
                "must have forces up to 1000000 N, torques up to 1e9 N·mm, phi_deg from 0 to 360"
                    .into(),
            );
        }
        demand(
            self.extra.windows(2).all(|w| w[0].phi_deg < w[1].phi_deg),
            "extra",
            "must have increasing phi_deg".into(),
        );
        problems
    }
}
