//! `curves.csv`: every contact station in Σ and in the frames of both gears, for other programs.

use crate::design::Design;
use crate::{Error, Result};

/// Column names: sub-gear pair k and tooth j from 1, φ in rad, then the vectors of a station by axis.
fn header() -> Vec<String> {
    let vectors = ["p", "n", "p1", "n1", "t1", "p2", "n2", "t2"];
    let axes = |v: &'static str| ["x", "y", "z"].map(|axis| format!("{v}_{axis}"));
    let columns = ["pair", "tooth", "phi"].map(String::from);
    let vectors = vectors.into_iter().flat_map(axes);
    columns.into_iter().chain(vectors).collect()
}

/// One row per station, mm and rad, twelve decimals.
///
/// # Errors
/// [`Error::Internal`] when the encoder fails.
pub fn csv(design: &Design) -> Result<Vec<u8>> {
    let fail = |e: String| Error::Internal(format!("curves.csv: {e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut write = |row: Vec<String>| writer.write_record(row).map_err(|e| fail(e.to_string()));
    write(header())?;
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        for (j, tooth) in pair.teeth.iter().enumerate() {
            for s in &tooth.stations {
                let mut row = vec![(k + 1).to_string(), (j + 1).to_string()];
                let vectors = [s.p, s.n, s.p1, s.n1, s.t1, s.p2, s.n2, s.t2];
                let numbers = [s.phi].into_iter().chain(vectors.into_iter().flatten());
                row.extend(numbers.map(|x| format!("{x:.12}")));
                write(row)?;
            }
        }
    }
    writer.into_inner().map_err(|e| fail(e.to_string()))
}
