//! Material presets: the few constants that contact stress and dynamics need.

use serde::{Deserialize, Serialize};

/// Preset of a gear's material; typical values of printed or machined parts, not of a data sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Material {
    /// Polylactide, FDM.
    #[default]
    #[serde(rename = "PLA")]
    Pla,
    /// PETG, FDM.
    #[serde(rename = "PETG")]
    Petg,
    /// Standard photopolymer resin, SLA.
    #[serde(rename = "SLA")]
    SlaResin,
    /// Polyamide 12, SLS.
    #[serde(rename = "PA12")]
    Pa12,
    /// Quenched and tempered steel.
    #[serde(rename = "steel")]
    Steel,
}

impl Material {
    /// All presets.
    pub const ALL: [Material; 5] = [
        Material::Pla,
        Material::Petg,
        Material::SlaResin,
        Material::Pa12,
        Material::Steel,
    ];

    /// Young's modulus, MPa.
    pub fn young_modulus(self) -> f64 {
        match self {
            Material::Pla => 3300.0,
            Material::Petg => 2100.0,
            Material::SlaResin => 2800.0,
            Material::Pa12 => 1700.0,
            Material::Steel => 210_000.0,
        }
    }

    /// Poisson's ratio.
    pub fn poisson_ratio(self) -> f64 {
        match self {
            Material::Pla => 0.36,
            Material::Petg => 0.38,
            Material::SlaResin => 0.36,
            Material::Pa12 => 0.40,
            Material::Steel => 0.30,
        }
    }

    /// Density of the solid material, kg/m³; prints with infill weigh less.
    pub fn density(self) -> f64 {
        match self {
            Material::Pla => 1240.0,
            Material::Petg => 1270.0,
            Material::SlaResin => 1150.0,
            Material::Pa12 => 1010.0,
            Material::Steel => 7850.0,
        }
    }

    /// Yield strength in tension or compression, whichever is lower, MPa.
    pub fn yield_strength(self) -> f64 {
        match self {
            Material::Pla => 50.0,
            Material::Petg => 45.0,
            Material::SlaResin => 55.0,
            Material::Pa12 => 45.0,
            Material::Steel => 600.0,
        }
    }

    /// Strength in tension across printed layers as a share of [`Material::yield_strength`].
    ///
    /// FDM: 20 to 50 % are usual for parts as printed (reviews of layer bonding in material extrusion, such as
    /// Goh et al. 2020, "Process–structure–properties in polymer additive manufacturing via material
    /// extrusion"); PETG bonds better than PLA. Resin and machined steel are alike in every direction; sintered
    /// PA12 loses 10 to 20 % (EOS data sheet of PA 2200).
    pub fn strength_across_layers(self) -> f64 {
        match self {
            Material::Pla => 0.4,
            Material::Petg => 0.5,
            Material::Pa12 => 0.85,
            Material::SlaResin | Material::Steel => 1.0,
        }
    }

    /// Largest Hertz pressure without yield below the surface, MPa: 1.6 times the yield strength
    /// (round contact, Poisson's ratio 0.3; a little more for larger ratios).
    pub fn allowed_pressure(self) -> f64 {
        1.6 * self.yield_strength()
    }
}

impl std::fmt::Display for Material {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Material::Pla => "PLA",
            Material::Petg => "PETG",
            Material::SlaResin => "SLA",
            Material::Pa12 => "PA12",
            Material::Steel => "steel",
        })
    }
}
