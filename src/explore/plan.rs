//! Trials spread evenly over the variables, each by its number alone: what `--shard` computes.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use toml::Value;

use super::study::{Range, Study};
use crate::motion::Change;

/// Bases of the sequence, one a variable.
pub const PRIMES: [u32; 24] = [
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89,
];

/// Trial `number` of a study: a point of the Halton sequence, turned by its seed.
pub fn trial(study: &Study, number: u64) -> Vec<Change> {
    let mut rng = ChaCha8Rng::seed_from_u64(study.seed);
    let variables = study.variables.iter().zip(PRIMES);
    variables
        .map(|(variable, base)| {
            let turn: f64 = rng.random_range(0.0..1.0);
            let at = (radical_inverse(number + 1, base) + turn).fract();
            Change {
                path: variable.path.clone(),
                value: value(&variable.range, at),
            }
        })
        .collect()
}

/// The digits of `n` in `base` behind the point, in reverse.
fn radical_inverse(mut n: u64, base: u32) -> f64 {
    let (mut value, mut share) = (0.0, 1.0 / f64::from(base));
    while n > 0 {
        value += (n % u64::from(base)) as f64 * share;
        n /= u64::from(base);
        share /= f64::from(base);
    }
    value
}

/// The value at the share `at` (0 to 1) of a range.
fn value(range: &Range, at: f64) -> Value {
    let index = |count: f64| (at * count).floor().min(count - 1.0);
    match range {
        Range::Choice { choices } => choices[index(choices.len() as f64) as usize].clone(),
        Range::Whole { low, high, step } => {
            let count = ((high - low) / step + 1) as f64;
            Value::Integer(low + step * index(count) as i64)
        }
        Range::Number {
            low,
            high,
            step: Some(step),
            ..
        } => {
            let count = ((high - low) / step + 1e-9).floor() + 1.0;
            Value::Float(tidy(low + step * index(count)))
        }
        Range::Number {
            low,
            high,
            log: true,
            ..
        } => Value::Float(tidy(low * (high / low).powf(at)).clamp(*low, *high)),
        Range::Number { low, high, .. } => {
            Value::Float(tidy(low + at * (high - low)).clamp(*low, *high))
        }
    }
}

/// Ten digits behind the point are enough for anything that is built.
fn tidy(value: f64) -> f64 {
    (value * 1e10).round() / 1e10
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_a_range_gets_its_share() {
        let whole = Range::Whole {
            low: 8,
            high: 12,
            step: 2,
        };
        let values = (0..30).map(|i| value(&whole, radical_inverse(i + 1, 3)));
        let mut counts = [0; 3];
        for v in values {
            counts[(v.as_integer().expect("whole") - 8) as usize / 2] += 1;
        }
        assert!(counts.iter().all(|c| (9..=11).contains(c)), "{counts:?}");
        let stepped = Range::Number {
            low: 0.1,
            high: 0.4,
            step: Some(0.1),
            log: false,
        };
        assert_eq!(value(&stepped, 0.999), Value::Float(0.4));
        let log = Range::Number {
            low: 1.0,
            high: 100.0,
            step: None,
            log: true,
        };
        assert_eq!(value(&log, 0.5), Value::Float(10.0));
    }
}
