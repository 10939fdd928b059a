//! The phases that a mechanism runs through: a period over and over, or a range there and back.

use std::f64::consts::TAU;

/// Stretch of phases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    start: f64,
    length: f64,
    wraps: bool,
}

impl Cycle {
    /// A whole period of 2π, whose end is its beginning.
    pub fn turning() -> Cycle {
        Cycle {
            start: 0.0,
            length: TAU,
            wraps: true,
        }
    }

    /// From `start` to `end` (rad) and back.
    pub fn reciprocating(start: f64, end: f64) -> Cycle {
        Cycle {
            start,
            length: end - start,
            wraps: false,
        }
    }

    /// Its first phase, rad.
    pub fn start(self) -> f64 {
        self.start
    }

    /// Its last phase, rad.
    pub fn end(self) -> f64 {
        self.start + self.length
    }

    /// How long it is, rad.
    pub fn length(self) -> f64 {
        self.length
    }

    /// Whether its end is its beginning.
    pub fn wraps(self) -> bool {
        self.wraps
    }

    /// Share of a whole turn.
    pub fn share(self) -> f64 {
        self.length / TAU
    }

    /// Phase at the beginning of part `part` of `parts` equal ones, rad.
    pub fn part(self, part: usize, parts: usize) -> f64 {
        self.start + self.length * part as f64 / parts as f64
    }

    /// `count` evenly spread phases, rad; of a range both ends are among them.
    pub fn phases(self, count: usize) -> impl Iterator<Item = f64> + Clone {
        let parts = if self.wraps { count } else { count.max(2) - 1 };
        (0..count).map(move |i| self.part(i, parts))
    }

    /// Tooth pairs of a band whose gears would have `teeth` all the way round: those of its share.
    pub fn pairs(self, teeth: usize) -> usize {
        match self.wraps {
            true => teeth,
            false => ((self.share() * teeth as f64 - 1e-9).ceil() as usize).max(2),
        }
    }

    /// How far `phi` is from `middle`, the nearer way where it wraps after `turns` of its length, rad.
    pub fn away(self, phi: f64, middle: f64, turns: usize) -> f64 {
        if !self.wraps {
            return (phi - middle).abs();
        }
        let period = self.length * turns as f64;
        let away = (phi - middle).rem_euclid(period);
        away.min(period - away)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_has_both_ends_and_a_turn_one() {
        let range = Cycle::reciprocating(-1.0, 0.5);
        let phases: Vec<f64> = range.phases(4).collect();
        assert_eq!(phases, [-1.0, -0.5, 0.0, 0.5]);
        let turn: Vec<f64> = Cycle::turning().phases(4).collect();
        assert_eq!(turn, [0.0, 0.25 * TAU, 0.5 * TAU, 0.75 * TAU]);
    }

    #[test]
    fn a_range_takes_its_share_of_the_teeth() {
        let range = |deg: f64| Cycle::reciprocating(0.0, deg.to_radians());
        assert_eq!(range(120.0).pairs(9), 3);
        assert_eq!(range(121.0).pairs(9), 4);
        assert_eq!(range(10.0).pairs(9), 2);
        assert_eq!(Cycle::turning().pairs(9), 9);
    }

    #[test]
    fn only_what_wraps_has_a_nearer_way() {
        let turn = Cycle::turning();
        assert!((turn.away(6.2, 0.1, 1) - (TAU - 6.1)).abs() < 1e-12);
        assert!((turn.away(6.2, 0.1, 2) - 6.1).abs() < 1e-12);
        assert!((Cycle::reciprocating(0.0, 6.2).away(6.2, 0.1, 1) - 6.1).abs() < 1e-12);
    }
}
