//! The cross section of a bead as one curved quadrangle that stands on the rib.

use nalgebra::Vector2;

use crate::design::Section;
use crate::solid::section;

/// Corners of a full circle in the outline that is filled.
const SEGMENTS: u32 = 48;

/// A quadrangle in section coordinates (n, b), mm: below a chord as wide as the rib, the other three sides
/// share the outline above it. Filled by transfinite interpolation (Coons).
#[derive(Debug)]
pub struct Bead {
    /// The outline from the chord's first end over the top to its other end.
    path: Vec<Vector2<f64>>,
    /// Length of the outline up to each corner of the path.
    lengths: Vec<f64>,
}

impl Bead {
    /// The bead that stands on a rib from `centre` along `down` (unit), `half` as thick to either side.
    pub fn new(
        section: &Section,
        (centre, down): (Vector2<f64>, Vector2<f64>),
        half: f64,
    ) -> Option<Bead> {
        let outline = section::polygon(section, SEGMENTS);
        let outline: Vec<Vector2<f64>> = outline.into_iter().map(Vector2::from).collect();
        let across = Vector2::new(-down.y, down.x);
        // A rib wider than the bead is there begins where the bead is as wide.
        let ends = (0..10).find_map(|i| {
            let side = half * 0.9_f64.powi(i) * across;
            Some([
                leaves(&outline, centre + side, down)?,
                leaves(&outline, centre - side, down)?,
            ])
        });
        let [(first, start), (last, end)] = ends?;
        let count = outline.len();
        // All corners where both ends lie on one side of the outline.
        let between = (last + count - first - 1) % count + 1;
        let mut path = vec![start];
        path.extend((1..=between).map(|i| outline[(first + i) % count]));
        path.push(end);
        let mut lengths = vec![0.0];
        let mut sum = 0.0;
        for side in path.windows(2) {
            sum += (side[1] - side[0]).norm();
            lengths.push(sum);
        }
        Some(Bead { path, lengths })
    }

    /// The ends of its chord.
    pub fn chord(&self) -> [Vector2<f64>; 2] {
        [self.on_path(0.0), self.on_path(1.0)]
    }

    /// The point at `x` across and `y` upwards, both from 0 to 1.
    pub fn at(&self, x: f64, y: f64) -> Vector2<f64> {
        let [from, to] = self.chord();
        let third = 1.0 / 3.0;
        let (left, right) = (self.on_path(third * y), self.on_path(1.0 - third * y));
        let top = self.on_path(third * (1.0 + x));
        let bottom = from + x * (to - from);
        let (top_left, top_right) = (self.on_path(third), self.on_path(2.0 * third));
        let corners = (1.0 - y) * bottom + y * ((1.0 - x) * top_left + x * top_right);
        (1.0 - y) * bottom + y * top + (1.0 - x) * left + x * right - corners
    }

    /// The point at a share of the path's length.
    fn on_path(&self, share: f64) -> Vector2<f64> {
        let last = self.path.len() - 1;
        let goal = share * self.lengths[last];
        let i = self.lengths.partition_point(|&s| s <= goal).clamp(1, last);
        let step = self.lengths[i] - self.lengths[i - 1];
        let part = ((goal - self.lengths[i - 1]) / step.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        self.path[i - 1] + part * (self.path[i] - self.path[i - 1])
    }
}

/// Where a ray from `start` last leaves the outline: the corner before and the point.
fn leaves(
    outline: &[Vector2<f64>],
    start: Vector2<f64>,
    along: Vector2<f64>,
) -> Option<(usize, Vector2<f64>)> {
    let mut farthest: Option<(f64, usize)> = None;
    for (i, &a) in outline.iter().enumerate() {
        let side = outline[(i + 1) % outline.len()] - a;
        let (from, slope) = (along.perp(&(a - start)), along.perp(&side));
        let part = -from / slope;
        if !(0.0..1.0).contains(&part) {
            continue;
        }
        let reach = along.dot(&(a + part * side - start));
        if reach > 0.0 && farthest.is_none_or(|(most, _)| reach > most) {
            farthest = Some((reach, i));
        }
    }
    farthest.map(|(reach, i)| (i, start + reach * along))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn fills_the_outline_above_the_rib() {
        let usual = Section::of(&Settings::default());
        // Cut off so low that both sides of the rib end on the flat end of the section.
        let low = Section {
            thickness: 1.9,
            flank_radius: 3.0,
            tip: 0.8,
            root: 0.5,
            ..usual
        };
        let centre = Vector2::new(0.5 * (usual.clearance + usual.thickness), 0.0);
        for (section, angle) in [(usual, -2.2), (usual, -1.6), (usual, -1.0_f64), (low, -1.6)] {
            let down = Vector2::new(angle.cos(), angle.sin());
            let bead = Bead::new(&section, (centre, down), 0.5 * section.rib).expect("a bead");
            let [from, to] = bead.chord();
            assert!((from - to).norm() > section.rib - 1e-9);
            // The cells' areas are what the path and its chord enclose.
            let area = |corners: &[Vector2<f64>]| -> f64 {
                let next = corners.iter().cycle().skip(1);
                0.5 * corners
                    .iter()
                    .zip(next)
                    .map(|(a, b)| a.perp(b))
                    .sum::<f64>()
            };
            let n = 40;
            let mut sum = 0.0;
            for i in 0..n {
                for j in 0..n {
                    let at = |i: usize, j: usize| bead.at(i as f64 / n as f64, j as f64 / n as f64);
                    let cell = area(&[at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
                    assert!(cell > 0.0, "folded at {i}, {j}");
                    sum += cell;
                }
            }
            assert!((sum / area(&bead.path) - 1.0).abs() < 1e-2, "{sum}");
        }
    }
}
