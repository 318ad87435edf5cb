//! What stands in the brackets of a predicate: patterns for names, comparisons for values of variations.

use glob::{MatchOptions, Pattern};
use regex_lite::Regex;

use crate::units;
use scenario::{Assignment, Dimension, Relation, Value};

/// How a name is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// `=text`
    Equal,
    /// `~text`
    Contains,
    /// `#glob`
    Glob,
    /// `/regex/`
    Regex,
}

impl Mark {
    /// As it is written.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Equal => "`=`",
            Self::Contains => "`~`",
            Self::Glob => "`#`",
            Self::Regex => "`/`",
        }
    }

    /// As messages call it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Contains => "contains",
            Self::Glob => "glob",
            Self::Regex => "regular expression",
        }
    }
}

/// A pattern that names are compared with.
#[derive(Debug, Clone)]
pub enum Matcher {
    Equal(String),
    Contains(String),
    Glob(Pattern),
    Regex(Regex),
}

/// `*` and `?` stay within a folder; `**` does not.
const GLOB: MatchOptions = MatchOptions {
    case_sensitive: true,
    require_literal_separator: true,
    require_literal_leading_dot: false,
};

impl Matcher {
    /// # Errors
    /// In the words of the pattern's own parser.
    pub fn new(mark: Mark, text: &str) -> Result<Self, String> {
        Ok(match mark {
            Mark::Equal => Self::Equal(text.to_string()),
            Mark::Contains => Self::Contains(text.to_string()),
            Mark::Glob => Self::Glob(Pattern::new(text).map_err(|error| error.to_string())?),
            Mark::Regex => Self::Regex(Regex::new(text).map_err(|error| error.to_string())?),
        })
    }

    pub fn matches(&self, name: &str) -> bool {
        match self {
            Self::Equal(text) => name == text,
            Self::Contains(text) => name.contains(text),
            Self::Glob(pattern) => pattern.matches_with(name, GLOB),
            Self::Regex(regex) => regex.is_match(name),
        }
    }

    /// Compares a path, or for a name or glob also what is left of it from any folder on.
    pub fn matches_path(&self, path: &str) -> bool {
        let by_its_end = matches!(self, Self::Equal(_) | Self::Glob(_));
        self.matches(path)
            || by_its_end && path.match_indices('/').any(|(at, _)| self.matches(&path[at + 1..]))
    }
}

/// What a variation's value is compared with.
#[derive(Debug, Clone)]
pub enum ValueMatcher {
    /// `tta`: any value.
    Any,
    /// `tta=6s`, `tta>=10 s`: as quantities where both are, as words otherwise.
    Compare { relation: Relation, bound: Bound },
    /// `speed~30`, `speed#*km/h`, `speed/^3/`: the words that the value was written in.
    Label(Matcher),
}

/// The right side of a comparison.
#[derive(Debug, Clone)]
pub struct Bound {
    text: String,
    quantity: Option<(f64, Dimension)>,
}

impl Bound {
    pub fn new(text: &str) -> Self {
        Self { text: text.split_whitespace().collect(), quantity: quantity(text) }
    }

    pub fn is_quantity(&self) -> bool {
        self.quantity.is_some()
    }
}

/// A quantity such as `6 s` in SI units; what follows `#` in a label only tells equal draws apart.
fn quantity(text: &str) -> Option<(f64, Dimension)> {
    let text = text.split('#').next().unwrap_or_default().trim();
    let end = text
        .char_indices()
        .find(|&(at, c)| {
            let exponent = matches!(c, 'e' | 'E')
                && text[at + 1..]
                    .starts_with(|next: char| next.is_ascii_digit() || next == '-' || next == '+');
            let after_exponent = matches!(c, '-' | '+') && (at == 0 || text[..at].ends_with(['e', 'E']));
            !(c.is_ascii_digit() || c == '.' || exponent || after_exponent)
        })
        .map_or(text.len(), |(at, _)| at);
    let number: f64 = text[..end].parse().ok()?;
    match text[end..].trim() {
        "" => Some((number, Dimension::NUMBER)),
        symbol => units::unit_of(symbol).map(|unit| (unit.to_si(number), unit.dimension)),
    }
}

impl ValueMatcher {
    pub fn matches(&self, assignment: &Assignment) -> bool {
        match self {
            Self::Any => true,
            Self::Label(matcher) => matcher.matches(&assignment.label),
            Self::Compare { relation, bound } => compare(assignment, *relation, bound),
        }
    }
}

fn compare(assignment: &Assignment, relation: Relation, bound: &Bound) -> bool {
    let same_words = assignment.label == bound.text;
    let (Value::Number(value), Some((wanted, dimension))) = (&assignment.value, bound.quantity) else {
        return match relation {
            Relation::Equal => same_words,
            Relation::NotEqual => !same_words,
            _ => false,
        };
    };
    // A label that is a calculation does not say its unit; then the numbers alone are compared.
    let same_kind = quantity(&assignment.label).is_none_or(|(_, own)| own == dimension);
    let equal = same_words || same_kind && (value - wanted).abs() <= 1e-9 * value.abs().max(wanted.abs());
    match relation {
        Relation::Equal => equal,
        Relation::NotEqual => !equal,
        Relation::LessOrEqual | Relation::GreaterOrEqual if equal => true,
        Relation::Less | Relation::Greater if equal => false,
        _ => same_kind && relation.holds(*value, wanted),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matches(mark: Mark, text: &str, name: &str) -> bool {
        Matcher::new(mark, text).unwrap().matches(name)
    }

    #[test]
    fn names_are_compared_as_the_mark_says() {
        assert!(matches(Mark::Equal, "paper", "paper") && !matches(Mark::Equal, "paper", "papers"));
        assert!(matches(Mark::Contains, "ape", "paper") && !matches(Mark::Contains, "x", "paper"));
        assert!(
            matches(Mark::Glob, "carla_*", "carla_walker") && !matches(Mark::Glob, "carla", "carla_walker")
        );
        assert!(matches(Mark::Regex, "^car(la|d)_", "carla_walker") && !matches(Mark::Regex, "^la", "carla"));
        assert!(Matcher::new(Mark::Regex, "(").is_err() && Matcher::new(Mark::Glob, "a***").is_err());
    }

    #[test]
    fn a_path_is_known_by_its_end() {
        let matches = |mark, text| Matcher::new(mark, text).unwrap().matches_path("scenarios/zebra/a.scn");
        assert!(matches(Mark::Glob, "a.scn") && matches(Mark::Glob, "zebra/*.scn"));
        assert!(matches(Mark::Equal, "zebra/a.scn") && matches(Mark::Glob, "scenarios/**"));
        assert!(!matches(Mark::Glob, "scenarios/*.scn") && !matches(Mark::Equal, "ebra/a.scn"));
        assert!(matches(Mark::Contains, "ebra/a") && !matches(Mark::Regex, "^zebra"));
    }

    fn holds(label: &str, value: Value, relation: Relation, bound: &str) -> bool {
        let assignment = Assignment { name: "x".into(), label: label.into(), value };
        ValueMatcher::Compare { relation, bound: Bound::new(bound) }.matches(&assignment)
    }

    #[test]
    fn values_are_compared_as_quantities() {
        use Relation::{Equal, Greater, GreaterOrEqual, Less, NotEqual};
        let six = || Value::Number(6.0);
        for bound in ["6s", "6 s", "6000 ms", "6.0s", "0.1min"] {
            assert!(holds("6s", six(), Equal, bound), "{bound}");
            assert!(holds("6s", six(), GreaterOrEqual, bound) && !holds("6s", six(), Less, bound));
        }
        assert!(holds("30km/h", Value::Number(30.0 / 3.6), Less, "9 m/s"));
        assert!(
            !holds("30km/h", Value::Number(30.0 / 3.6), Less, "9 s"),
            "a speed is not shorter than a time"
        );
        assert!(holds("30km/h", Value::Number(30.0 / 3.6), NotEqual, "9 s"));
        assert!(holds("2*late", Value::Number(13.0), Greater, "12 s"));
        assert!(holds("-1.5e1m", Value::Number(-15.0), Equal, "-15 m"));
        assert!(
            holds("1.25s#2", Value::Number(1.25), Equal, "1.25s#2")
                && holds("1.25s#2", Value::Number(1.25), Equal, "1.25 s")
        );
        assert!(holds("20%", Value::Number(0.2), Equal, "0.2"));
    }

    #[test]
    fn words_are_equal_or_not() {
        let normal = || Value::Word("normal".into());
        assert!(holds("normal", normal(), Relation::Equal, "normal"));
        assert!(holds("normal", normal(), Relation::NotEqual, "cautious"));
        assert!(!holds("normal", normal(), Relation::Less, "zebra"));
    }
}
