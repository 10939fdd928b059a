//! Hostile input made of good one, the same for the same seed.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Pieces that have broken readers before.
const TOKENS: [&str; 40] = [
    "nan",
    "inf",
    "-0",
    "1e308",
    "-1e-320",
    "1e999",
    "4e9",
    "18446744073709551616",
    "-1",
    "0",
    "\"\"",
    "\"",
    "'''",
    "[",
    "]",
    "{",
    "}",
    "[[",
    "(",
    ")",
    ",",
    "=",
    ".",
    "#",
    "\n",
    "\r\n",
    "\t",
    "\0",
    "\u{1b}[2J",
    "\u{feff}",
    "\u{ffff}",
    "é",
    "💥",
    "*/",
    "sin(",
    "phi^",
    "../x",
    "null",
    "true",
    "solid",
];

/// Input number `index` for a target with these `seeds`.
pub fn input(seeds: &[Vec<u8>], index: u64) -> Vec<u8> {
    let mut random = ChaCha8Rng::seed_from_u64(index);
    let mut data = pick(&mut random, seeds).clone();
    for _ in 0..random.random_range(1..=6) {
        change(&mut random, &mut data, seeds);
    }
    data
}

fn pick<'s, T>(random: &mut impl Rng, of: &'s [T]) -> &'s T {
    &of[random.random_range(0..of.len())]
}

/// A piece of `data`, up to `most` bytes long; empty at its end.
fn piece(random: &mut impl Rng, data: &[u8], most: usize) -> std::ops::Range<usize> {
    let from = random.random_range(0..=data.len());
    let length = random.random_range(0..=most.min(data.len() - from));
    from..from + length
}

fn change(random: &mut impl Rng, data: &mut Vec<u8>, seeds: &[Vec<u8>]) {
    let at = piece(random, data, 0).start;
    match random.random_range(0..10) {
        0 => {
            if let Some(byte) = data.get_mut(at) {
                *byte = random.random();
            }
        }
        1 => {
            if let Some(byte) = data.get_mut(at) {
                *byte ^= 1 << random.random_range(0..8);
            }
        }
        2 => {
            let gone = piece(random, data, 40);
            data.drain(gone);
        }
        3 => data.truncate(at),
        4 => {
            let copied = data[piece(random, data, 60)].to_vec();
            data.splice(at..at, copied);
        }
        5 => {
            let other = pick(random, seeds);
            let copied = other[piece(random, other, 200)].to_vec();
            data.splice(at..at, copied);
        }
        6 => {
            let copied = data[piece(random, data, 12)].repeat(random.random_range(2..2000));
            data.splice(at..at, copied);
        }
        7 => {
            let token = pick(random, &TOKENS).repeat(random.random_range(1..200));
            data.splice(at..at, token.into_bytes());
        }
        // Values: what stands after a sign that begins one is replaced.
        _ => {
            let begins = |b: &u8| matches!(b, b'=' | b':' | b',' | b'[' | b'(' | b' ' | b'*');
            let Some(start) = data[at..].iter().position(begins).map(|i| at + i + 1) else {
                return;
            };
            let ends = |b: &u8| !(b.is_ascii_alphanumeric() || matches!(b, b'.' | b'-' | b'+'));
            let space = data[start..].iter().take_while(|b| **b == b' ').count();
            let start = start + space;
            let length = data[start..].iter().position(ends);
            let end = length.map_or(data.len(), |length| start + length);
            data.splice(start..end, pick(random, &TOKENS).bytes());
        }
    }
}
