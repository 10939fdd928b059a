//! What formulas calculate with: numbers that carry their first two derivatives along, and the
//! operators of [`exmex`] on them. The cost of a formula is that of its value, a few times over.

use std::f64::consts::{E, LN_2, LN_10, PI, TAU};
use std::str::FromStr;

use exmex::{BinOp, MakeOperators, Operator};
use num_dual::Dual2_64;

/// How a number depends on `phi`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Dependence {
    /// Not at all.
    #[default]
    None,
    /// Twice differentiable wherever it is defined.
    Smooth,
    /// Through a function with kinks or jumps.
    Kinked,
}

/// A number with its first two derivatives by `phi`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Number {
    pub dual: Dual2_64,
    pub dependence: Dependence,
}

/// Functions with kinks or jumps: usable on what does not depend on `phi`.
pub(super) const KINKED: [&str; 9] = [
    "abs", "signum", "floor", "round", "ceil", "trunc", "fract", "min", "max",
];

/// Names that formulas know, beside `phi` and the built-in constants.
pub(super) const NAMES: [&str; 35] = [
    "abs", "signum", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh",
    "acosh", "atanh", "floor", "round", "ceil", "trunc", "fract", "exp", "sqrt", "cbrt", "ln",
    "log2", "log10", "log", "atan2", "min", "max", "PI", "π", "E", "e", "TAU", "τ",
];

impl Number {
    pub(super) fn constant(value: f64) -> Number {
        Number {
            dual: Dual2_64::from_re(value),
            dependence: Dependence::None,
        }
    }

    /// The variable itself.
    pub(super) fn phi(value: f64) -> Number {
        Number {
            dual: Dual2_64::new(value, 1.0, 0.0),
            dependence: Dependence::Smooth,
        }
    }

    /// f(x) from f, f′ and f″ at x.
    fn chain(self, [f, f1, f2]: [f64; 3]) -> Number {
        // A constant stays one, also where f has no derivative.
        if self.dependence == Dependence::None {
            return Number::constant(f);
        }
        let Dual2_64 { v1, v2, .. } = self.dual;
        Number {
            dual: Dual2_64::new(f, f1 * v1, f2 * v1 * v1 + f1 * v2),
            ..self
        }
    }

    fn kinked(self, f: f64) -> Number {
        match self.dependence {
            Dependence::None => Number::constant(f),
            _ => Number {
                dual: Dual2_64::new(f, f64::NAN, f64::NAN),
                dependence: Dependence::Kinked,
            },
        }
    }

    fn with(self, other: Number, dual: Dual2_64) -> Number {
        Number {
            dual,
            dependence: self.dependence.max(other.dependence),
        }
    }

    fn divided_by(self, other: Number) -> Number {
        let (a, b) = (self.dual, other.dual);
        let f = a.re / b.re;
        let f1 = (a.v1 - f * b.v1) / b.re;
        let f2 = (a.v2 - 2.0 * f1 * b.v1 - f * b.v2) / b.re;
        self.with(other, Dual2_64::new(f, f1, f2))
    }

    fn to_the(self, exponent: Number) -> Number {
        let (x, n) = (self.dual.re, exponent.dual.re);
        let f = x.powf(n);
        if exponent.dependence == Dependence::None {
            // Powers that differentiation takes away leave zero, also at x = 0.
            let term = |factor: f64, n: f64| match factor {
                0.0 => 0.0,
                factor => factor * x.powf(n),
            };
            return self.chain([f, term(n, n - 1.0), term(n * (n - 1.0), n - 2.0)]);
        }
        // xⁿ = exp(n ln x)
        let ln = self.chain([x.ln(), 1.0 / x, -1.0 / (x * x)]);
        let product = exponent.with(ln, exponent.dual * ln.dual);
        product.chain([f, f, f])
    }

    /// Angle of the point (x, y), with `self` = y.
    fn atan2(self, x: Number) -> Number {
        let (b, a) = (self.dual, x.dual);
        let square = a.re * a.re + b.re * b.re;
        let rate = a.re * b.v1 - b.re * a.v1;
        let f1 = rate / square;
        let f2 =
            (a.re * b.v2 - b.re * a.v2) / square - 2.0 * f1 * (a.re * a.v1 + b.re * b.v1) / square;
        let dual = match self.dependence.max(x.dependence) {
            Dependence::None => Dual2_64::from_re(b.re.atan2(a.re)),
            _ => Dual2_64::new(b.re.atan2(a.re), f1, f2),
        };
        self.with(x, dual)
    }

    /// The smaller or larger of two, as `pick` has it.
    fn picked(self, other: Number, pick: fn(f64, f64) -> f64) -> Number {
        let f = pick(self.dual.re, other.dual.re);
        self.with(other, self.dual).kinked(f)
    }
}

impl Default for Number {
    fn default() -> Number {
        Number::constant(0.0)
    }
}

impl FromStr for Number {
    type Err = std::num::ParseFloatError;

    fn from_str(text: &str) -> Result<Number, Self::Err> {
        text.parse().map(Number::constant)
    }
}

/// Operators and functions of formulas: those of [`exmex::FloatOpsFactory`], with derivatives.
#[derive(Debug, Clone)]
pub(super) struct Operators;

impl MakeOperators<Number> for Operators {
    fn make<'a>() -> Vec<Operator<'a, Number>> {
        let binary = |apply, prio, is_commutative| BinOp {
            apply,
            prio,
            is_commutative,
        };
        let mut all = vec![
            Operator::make_bin("^", binary(Number::to_the, 4, false)),
            Operator::make_bin("*", binary(|a, b| a.with(b, a.dual * b.dual), 2, true)),
            Operator::make_bin("/", binary(Number::divided_by, 3, false)),
            Operator::make_bin_unary(
                "+",
                binary(|a, b| a.with(b, a.dual + b.dual), 0, true),
                |a| a,
            ),
            Operator::make_bin_unary(
                "-",
                binary(|a, b| a.with(b, a.dual - b.dual), 1, false),
                |a| a.with(a, -a.dual),
            ),
            Operator::make_bin("atan2", binary(Number::atan2, 0, false)),
            Operator::make_bin("min", binary(|a, b| a.picked(b, f64::min), 0, false)),
            Operator::make_bin("max", binary(|a, b| a.picked(b, f64::max), 0, false)),
        ];
        let constants = [
            ("PI", PI),
            ("π", PI),
            ("E", E),
            ("e", E),
            ("TAU", TAU),
            ("τ", TAU),
        ];
        all.extend(
            constants.map(|(name, value)| Operator::make_constant(name, Number::constant(value))),
        );
        all.extend(functions());
        all
    }
}

/// Functions of one number: x ↦ [f, f′, f″].
fn functions<'a>() -> Vec<Operator<'a, Number>> {
    macro_rules! smooth {
        ($($name:literal: |$x:ident| $jet:expr;)*) => {
            vec![$(Operator::make_unary($name, |number: Number| {
                let $x = number.dual.re;
                number.chain($jet)
            })),*]
        };
    }
    macro_rules! kinked {
        ($($name:literal: $f:expr;)*) => {
            [$(Operator::make_unary($name, |x: Number| x.kinked($f(x.dual.re)))),*]
        };
    }
    let mut all = smooth! {
        "sin": |x| { let (s, c) = x.sin_cos(); [s, c, -s] };
        "cos": |x| { let (s, c) = x.sin_cos(); [c, -s, -c] };
        "tan": |x| { let t = x.tan(); let d = 1.0 + t * t; [t, d, 2.0 * t * d] };
        "asin": |x| { let d = 1.0 / (1.0 - x * x).sqrt(); [x.asin(), d, x * d * d * d] };
        "acos": |x| { let d = -1.0 / (1.0 - x * x).sqrt(); [x.acos(), d, x * d * d * d] };
        "atan": |x| { let d = 1.0 / (1.0 + x * x); [x.atan(), d, -2.0 * x * d * d] };
        "sinh": |x| { let (s, c) = (x.sinh(), x.cosh()); [s, c, s] };
        "cosh": |x| { let (s, c) = (x.sinh(), x.cosh()); [c, s, c] };
        "tanh": |x| { let t = x.tanh(); let d = 1.0 - t * t; [t, d, -2.0 * t * d] };
        "asinh": |x| { let d = 1.0 / (1.0 + x * x).sqrt(); [x.asinh(), d, -x * d * d * d] };
        "acosh": |x| { let d = 1.0 / (x * x - 1.0).sqrt(); [x.acosh(), d, -x * d * d * d] };
        "atanh": |x| { let d = 1.0 / (1.0 - x * x); [x.atanh(), d, 2.0 * x * d * d] };
        "exp": |x| { let f = x.exp(); [f, f, f] };
        "sqrt": |x| { let f = x.sqrt(); let d = 0.5 / f; [f, d, -0.5 * d / x] };
        "cbrt": |x| { let f = x.cbrt(); let d = 1.0 / (3.0 * f * f); [f, d, -2.0 / 3.0 * d / x] };
        "ln": |x| [x.ln(), 1.0 / x, -1.0 / (x * x)];
        "log": |x| [x.ln(), 1.0 / x, -1.0 / (x * x)];
        "log2": |x| [x.log2(), 1.0 / (x * LN_2), -1.0 / (x * x * LN_2)];
        "log10": |x| [x.log10(), 1.0 / (x * LN_10), -1.0 / (x * x * LN_10)];
    };
    all.extend(kinked! {
        "abs": f64::abs;
        "signum": f64::signum;
        "floor": f64::floor;
        "round": f64::round;
        "ceil": f64::ceil;
        "trunc": f64::trunc;
        "fract": f64::fract;
    });
    all
}
