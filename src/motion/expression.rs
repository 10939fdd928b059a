//! Formulas in `phi`: parsed once, evaluated with their first two derivatives.

use std::collections::BTreeMap;

use exmex::{Express, FlatEx, MatchLiteral};
use num_dual::Dual2_64;

use super::derivative::{Dependence, KINKED, NAMES, Number, Operators};

exmex::literal_matcher_from_pattern!(Literal, r"^([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?");

/// Longest formula, bytes: some six hundred terms of a Fourier series.
const MAX_LENGTH: usize = 20_000;

/// How deep parentheses may be nested.
const MAX_DEPTH: usize = 100;

/// Names and values that formulas may use beside `phi`.
pub(super) type Constants = BTreeMap<String, f64>;

/// `pi` and `deg` (π/180), always known.
pub(super) fn builtin_constants() -> Constants {
    let pi = std::f64::consts::PI;
    BTreeMap::from([("pi".to_owned(), pi), ("deg".to_owned(), pi / 180.0)])
}

/// Whether formulas know `name` already, so that no constant can be called so.
pub(super) fn is_taken(name: &str) -> bool {
    name == "phi" || NAMES.contains(&name) || builtin_constants().contains_key(name)
}

/// One formula: a constant, or a parsed formula in `phi`.
#[derive(Debug, Clone)]
pub(super) enum Expression {
    Constant(f64),
    Variable(Box<Parsed>),
}

/// A formula with the values of its variables; `phi` is the one at `phi_index`.
#[derive(Debug, Clone)]
pub(super) struct Parsed {
    formula: FlatEx<Number, Operators, Literal>,
    values: Vec<Number>,
    phi_index: usize,
}

impl Expression {
    /// Parses `text`; the error says in one sentence what is wrong with it, and where.
    pub(super) fn parse(text: &str, constants: &Constants) -> Result<Expression, String> {
        let formula = FlatEx::<Number, Operators, Literal>::parse(&prepared(text, constants)?)
            .map_err(|e| format!("{} is not a formula ({})", quoted(text), brief(e.msg())))?;
        let names = formula.var_names().to_vec();
        let mut values = Vec::with_capacity(names.len());
        for name in &names {
            match constants.get(name) {
                Some(value) => values.push(Number::constant(*value)),
                None if name == "phi" => values.push(Number::phi(1.0)),
                None => return Err(unknown_name(text, name, constants)),
            }
        }
        let sample = formula
            .eval(&values)
            .map_err(|e| format!("{} has no value ({})", quoted(text), brief(e.msg())))?;
        let kinked = formula
            .unary_reprs()
            .into_iter()
            .chain(formula.binary_reprs());
        match (
            sample.dependence,
            names.iter().position(|name| name == "phi"),
        ) {
            (Dependence::Kinked, _) => {
                let names: Vec<String> = kinked.filter(|name| KINKED.contains(&&**name)).collect();
                Err(format!(
                    "{} has no derivative everywhere ({}); use smooth functions only",
                    quoted(text),
                    brief(&names.join(", "))
                ))
            }
            (Dependence::Smooth, Some(phi_index)) => Ok(Expression::Variable(Box::new(Parsed {
                formula,
                values,
                phi_index,
            }))),
            _ => Ok(Expression::Constant(sample.dual.re)),
        }
    }

    /// The gear's own turn −φ.
    pub(super) fn own_turn() -> crate::Result<Expression> {
        Expression::parse("-phi", &Constants::new()).map_err(crate::Error::Internal)
    }

    /// Value and two derivatives at `phi`; NaN where the formula is undefined.
    pub(super) fn at(&self, phi: f64) -> Dual2_64 {
        match self {
            Expression::Constant(value) => Dual2_64::from_re(*value),
            Expression::Variable(parsed) => {
                let mut values = parsed.values.clone();
                values[parsed.phi_index] = Number::phi(phi);
                let undefined = Number::constant(f64::NAN);
                parsed.formula.eval(&values).unwrap_or(undefined).dual
            }
        }
    }
}

/// A formula in a message: whole, or how it begins.
fn quoted(text: &str) -> String {
    format!("`{}`", brief(text))
}

/// How a text begins.
fn brief(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

fn unknown_name(text: &str, name: &str, constants: &Constants) -> String {
    let known = constants.keys().map(String::as_str).chain(["phi"]);
    let known: Vec<_> = known.take(20).collect();
    let at = text.find(name).unwrap_or(0);
    format!(
        "{} uses `{}`{}, which is not known; known are {} and the constants of [motion]",
        quoted(text),
        brief(name),
        place(text, at),
        known.join(", ")
    )
}

/// Where the byte `at` of `text` is, for messages; nothing in a formula that one sees at a glance.
fn place(text: &str, at: usize) -> String {
    if text.len() < 20 {
        return String::new();
    }
    format!(" at character {}", text[..at].chars().count() + 1)
}

/// The text as the parser takes it, checked for size, depth and parentheses.
///
/// A leading sign acts on the whole term (`-x^2` is −(x²)), where the parser would bind it to `x`
/// first; a sign right after another operator is ambiguous and refused. Names of constants go in
/// braces, so that the parser does not take `minimum` for `min`.
fn prepared(text: &str, constants: &Constants) -> Result<String, String> {
    if text.len() > MAX_LENGTH {
        return Err(format!(
            "{} has {} characters, allowed {MAX_LENGTH}",
            quoted(text),
            text.chars().count()
        ));
    }
    let fail = |at: usize, what: &str| {
        let position = text[..at].chars().count() + 1;
        Err(format!("{}: {what} at character {position}", quoted(text)))
    };
    let mut out = String::with_capacity(text.len() + 8);
    let mut open = Vec::new();
    let mut previous = '(';
    let mut word = 0;
    for (at, c) in text.char_indices() {
        if at < word {
            continue;
        }
        match c {
            '-' | '+' if matches!(previous, '(' | ',') => out.push('0'),
            '-' | '+' if "+-*/^".contains(previous) => {
                return Err(format!(
                    "{}: put the signed part behind `{previous}` in parentheses{}",
                    quoted(text),
                    place(text, at)
                ));
            }
            '(' if open.len() == MAX_DEPTH => {
                let what = format!("parentheses are nested more than {MAX_DEPTH} deep");
                return fail(at, &what);
            }
            '(' => open.push(at),
            ')' if open.pop().is_none() => return fail(at, "nothing to close by parentheses"),
            _ => {}
        }
        let rest = &text[at..];
        let in_number = previous.is_ascii_digit() || previous == '.';
        if c == '{' {
            let name = &rest[..rest.find('}').map_or(rest.len(), |end| end + 1)];
            out.push_str(name);
            word = at + name.len();
            previous = 'x';
        } else if (c.is_alphabetic() || c == '_') && !in_number {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_'));
            let name = &rest[..end.unwrap_or(rest.len())];
            if constants.contains_key(name) {
                out.extend(["{", name, "}"]);
            } else {
                out.push_str(name);
            }
            word = at + name.len();
            previous = 'x';
        } else if c.is_whitespace() {
            out.push(' ');
        } else {
            out.push(c);
            previous = c;
        }
    }
    match open.first() {
        Some(&at) => fail(at, "parentheses do not match: nothing closes the one"),
        None => Ok(out),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str, phi: f64) -> Dual2_64 {
        Expression::parse(text, &builtin_constants())
            .expect(text)
            .at(phi)
    }

    #[test]
    fn a_leading_minus_acts_on_the_whole_term() {
        assert_eq!(at("-phi^2", 3.0).re, -9.0);
        assert_eq!(at("2*(-phi^2)", 3.0).re, -18.0);
        assert_eq!(at(" - 2^2 * phi", 1.0).re, -4.0);
        assert!(Expression::parse("2*-phi", &builtin_constants()).is_err());
    }

    #[test]
    fn numbers_and_names() {
        assert_eq!(at("1e-3*phi", 2.0).v1, 1e-3);
        assert_eq!(at("1.5E+2", 0.0).re, 150.0);
        assert_eq!(at("180*deg - pi", 0.0).re, 0.0);
        assert_eq!(at("sin(phi)", 0.0).v1, 1.0);
    }

    #[test]
    fn bad_formulas_say_what_is_wrong() {
        let message = |text: &str| {
            Expression::parse(text, &builtin_constants())
                .err()
                .unwrap_or_else(|| panic!("{text} must be refused"))
        };
        assert!(message("sin(phi").contains("parentheses"));
        assert!(message("abs(phi)").contains("derivative"));
        assert!(message("speed*phi").contains("`speed`"));
        assert!(message("").contains("not a formula"));
        let long = "phi + ".repeat(4) + "speed";
        assert!(message(&long).contains("`speed` at character 25"));
        assert!(message("sin(phi))").contains("at character 9"));
        assert!(message("1 + (phi").contains("at character 5"));
    }

    #[test]
    fn size_and_depth_are_limited_with_a_message() {
        let refused = |text: &str| Expression::parse(text, &builtin_constants()).unwrap_err();
        let deep = "sin(".repeat(1000) + "phi" + &")".repeat(1000);
        let message = refused(&deep);
        assert!(
            message.contains("more than 100 deep at character 404"),
            "{message}"
        );
        assert!(message.len() < 300);
        let message = refused(&"cos(phi)*".repeat(5000));
        assert!(
            message.contains("45000 characters, allowed 20000"),
            "{message}"
        );
        assert!(message.len() < 300);
    }

    /// The cases that overflowed the stack or ran for minutes, with derivatives in closed form.
    #[test]
    fn long_deep_and_towering_formulas_have_exact_derivatives() {
        let phi = 0.7;
        let terms = 300;
        let series: Vec<String> = (1..=terms)
            .map(|k| format!("{k}e-4*cos({k}*phi) + {k}e-5*sin({k}*phi)"))
            .collect();
        let found = at(&series.join(" + "), phi);
        let mut wanted = [0.0; 3];
        for k in (1..=terms).map(f64::from) {
            let ((s, c), [a, b]) = ((k * phi).sin_cos(), [k * 1e-4, k * 1e-5]);
            wanted[0] += a * c + b * s;
            wanted[1] += k * (b * c - a * s);
            wanted[2] -= k * k * (a * c + b * s);
        }
        for (found, wanted) in [found.re, found.v1, found.v2].iter().zip(wanted) {
            approx::assert_relative_eq!(*found, wanted, max_relative = 1e-10);
        }

        let product = at(&["cos(phi)"; 50].join("*"), phi);
        approx::assert_relative_eq!(product.re, phi.cos().powi(50), max_relative = 1e-12);
        let first = -50.0 * phi.cos().powi(49) * phi.sin();
        approx::assert_relative_eq!(product.v1, first, max_relative = 1e-12);

        let nested = at(&("sin(".repeat(100) + "phi" + &")".repeat(100)), phi);
        let (mut f, mut f1) = (phi, 1.0);
        for _ in 0..100 {
            (f, f1) = (f.sin(), f1 * f.cos());
        }
        approx::assert_relative_eq!(nested.re, f, max_relative = 1e-12);
        approx::assert_relative_eq!(nested.v1, f1, max_relative = 1e-12);

        // ((phi^phi)^phi)^… = phi^(phi^19)
        let tower = at(&["phi"; 20].join("^"), 1.1);
        let exponent = 1.1f64.powi(19);
        approx::assert_relative_eq!(tower.re, 1.1f64.powf(exponent), max_relative = 1e-10);
        let first = tower.re * exponent / 1.1 * (19.0 * 1.1f64.ln() + 1.0);
        approx::assert_relative_eq!(tower.v1, first, max_relative = 1e-10);
    }

    /// Every function, against differences of its values and first derivatives.
    #[test]
    fn derivatives_of_all_functions() {
        for name in NAMES.iter().filter(|name| !KINKED.contains(name)) {
            let x = if *name == "acosh" {
                "(1.5 + phi)"
            } else {
                "(0.2 + phi/3)"
            };
            let text = match *name {
                "atan2" => "atan2(sin(phi), 0.3 + phi^2)".to_owned(),
                "PI" | "π" | "E" | "e" | "TAU" | "τ" => {
                    format!("{name}^phi + phi^{name} - phi^(-2)/phi")
                }
                name => format!("{name}{x}^2 + 3*{name}{x}"),
            };
            for phi in [0.3, 0.9] {
                let h = 1e-5;
                let [a, b, c] = [phi - h, phi, phi + h].map(|phi| at(&text, phi));
                let close = |found: f64, wanted: f64| {
                    assert!(
                        (found - wanted).abs() < 1e-7 * (1.0 + wanted.abs()),
                        "{text}: {found} {wanted}"
                    );
                };
                close(b.v1, (c.re - a.re) / (2.0 * h));
                close(b.v2, (c.v1 - a.v1) / (2.0 * h));
            }
        }
    }

    #[test]
    fn what_does_not_depend_on_phi_may_be_kinked_and_singular() {
        let constants = Constants::from([("a".to_owned(), -4.0), ("minimum".to_owned(), 3.0)]);
        let at = |text: &str| Expression::parse(text, &constants).expect(text).at(2.0);
        assert_eq!(at("abs(a)*phi").v1, 4.0);
        assert_eq!(at("max(a, -1)*phi").v1, -1.0);
        assert_eq!(at("minimum*phi").v1, 3.0);
        assert_eq!(at("{minimum}*{phi}").v1, 3.0);
        assert_eq!(at("sqrt(a + 4) + phi").v1, 1.0);
        assert_eq!(at("floor(2.5)").re, 2.0);
        assert_eq!(at("(phi - 2)^2").v2, 2.0);
        assert_eq!(at("(phi - 2)^1").v1, 1.0);
        assert_eq!(at("(phi - 3)^3").v2, -6.0);
        assert_eq!(at("2^3^2").re, 64.0);
        assert_eq!(at("phi/2*3\n\t- 1").re, 2.0);
        for text in ["min(phi, 1)", "floor(phi)*2", "1 max phi"] {
            let message = Expression::parse(text, &constants).unwrap_err();
            assert!(message.contains("no derivative"), "{text}: {message}");
        }
    }
}
