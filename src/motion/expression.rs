//! Formulas in `phi` with symbolic first and second derivatives.

use std::collections::BTreeMap;

use exmex::{Differentiate, Express, FlatEx, FloatOpsFactory, MatchLiteral};
use num_dual::Dual2_64;

exmex::literal_matcher_from_pattern!(Number, r"^([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?");

type Formula = FlatEx<f64, FloatOpsFactory<f64>, Number>;

/// Names and values that formulas may use beside `phi`.
pub(super) type Constants = BTreeMap<String, f64>;

/// `pi` and `deg` (π/180), always known.
pub(super) fn builtin_constants() -> Constants {
    let pi = std::f64::consts::PI;
    BTreeMap::from([("pi".to_owned(), pi), ("deg".to_owned(), pi / 180.0)])
}

/// One formula: a constant, or value and two derivatives with the values of their variables.
#[derive(Debug, Clone)]
pub(super) enum Expression {
    Constant(f64),
    Variable(Box<Derivatives>),
}

/// f, f′, f″ and the values of their common variables; `phi` is the variable at `phi_index`.
#[derive(Debug, Clone)]
pub(super) struct Derivatives {
    orders: [Formula; 3],
    values: Vec<f64>,
    phi_index: usize,
}

impl Expression {
    /// Parses `text`; the error says in one sentence what is wrong with it.
    pub(super) fn parse(text: &str, constants: &Constants) -> Result<Expression, String> {
        let formula = Formula::parse(&unary_signs(text)?)
            .map_err(|e| format!("`{text}` is not a formula ({e})"))?;
        let names = formula.var_names().to_vec();
        let mut values = Vec::with_capacity(names.len());
        for name in &names {
            match constants.get(name) {
                Some(value) => values.push(*value),
                None if name == "phi" => values.push(0.0),
                None => return Err(unknown_name(text, name, constants)),
            }
        }
        let Some(phi_index) = names.iter().position(|name| name == "phi") else {
            let value = formula.eval(&values).map_err(|e| e.to_string())?;
            return Ok(Expression::Constant(value));
        };
        let derivative = |f: &Formula| {
            f.clone().partial(phi_index).map_err(|e| {
                format!("`{text}` has no derivative everywhere ({e}); use smooth functions only")
            })
        };
        let first = derivative(&formula)?;
        let second = derivative(&first)?;
        Ok(Expression::Variable(Box::new(Derivatives {
            orders: [formula, first, second],
            values,
            phi_index,
        })))
    }

    /// The gear's own turn −φ.
    pub(super) fn own_turn() -> crate::Result<Expression> {
        Expression::parse("-phi", &Constants::new()).map_err(crate::Error::Internal)
    }

    /// Value and two derivatives at `phi`; NaN where the formula is undefined.
    pub(super) fn at(&self, phi: f64) -> Dual2_64 {
        match self {
            Expression::Constant(value) => Dual2_64::from_re(*value),
            Expression::Variable(derivatives) => {
                let mut values = derivatives.values.clone();
                values[derivatives.phi_index] = phi;
                let [re, v1, v2] = [0, 1, 2]
                    .map(|order| derivatives.orders[order].eval(&values).unwrap_or(f64::NAN));
                Dual2_64::new(re, v1, v2)
            }
        }
    }
}

fn unknown_name(text: &str, name: &str, constants: &Constants) -> String {
    let known = constants.keys().map(String::as_str).chain(["phi"]);
    let known: Vec<_> = known.collect();
    format!(
        "`{text}` uses `{name}`, which is not known; known are {} and the constants of [motion]",
        known.join(", ")
    )
}

/// Makes a leading sign act on the whole term (`-x^2` is −(x²)), where the parser would bind it
/// to `x` first; a sign right after another operator is ambiguous and refused.
fn unary_signs(text: &str) -> Result<String, String> {
    let mut out = String::with_capacity(text.len() + 8);
    let mut previous = '(';
    for (at, c) in text.char_indices() {
        if c == '-' || c == '+' {
            let exponent = matches!(previous, 'e' | 'E') && is_exponent(&text[..at]);
            if matches!(previous, '(' | ',') {
                out.push('0');
            } else if "+-*/^".contains(previous) && !exponent {
                return Err(format!(
                    "`{text}`: put the signed part behind `{previous}` in parentheses"
                ));
            }
        }
        out.push(c);
        if !c.is_whitespace() {
            previous = c;
        }
    }
    Ok(out)
}

/// Whether `head`, which ends in `e`, ends in a number such as `1.5e`.
fn is_exponent(head: &str) -> bool {
    head.trim_end_matches(['e', 'E'])
        .ends_with(|c: char| c.is_ascii_digit() || c == '.')
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
    }
}
