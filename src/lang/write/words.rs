//! Values, settings and comparisons in the language's words, so that they are read back to the last bit.

use crate::units::UNITS;
use scenario::{
    Comparison, Declaration, Dimension, Expression, MetricKind, MetricReference, Model, ParameterKind,
    Registered, Relation, Scope, Value, WhenUndefined,
};

/// A comparison in the language's words, such as `pet(av, walker) >= 1.5 s undefined passes`.
pub fn write_comparison(comparison: &Comparison) -> String {
    let Comparison { metric: reference, relation, bound, when_undefined } = comparison;
    let name = metric_text(reference);
    let number = number_of(bound);
    let kind = reference.known().map(|metric| &metric.kind);
    let text = match kind {
        Some(MetricKind::Flag) if matches!(relation, Relation::Equal | Relation::NotEqual) => {
            let wanted = (number != 0.0) == (*relation == Relation::Equal);
            if wanted { name } else { format!("no {name}") }
        }
        Some(MetricKind::Category(words)) => {
            let word = words.get(number as usize).map(|word| &**word).unwrap_or_default();
            format!("{name} {} {word}", relation.symbol())
        }
        Some(MetricKind::Quantity(dimension)) => {
            format!("{name} {} {}", relation.symbol(), quantity(number, *dimension))
        }
        _ => format!("{name} {} {number}", relation.symbol()),
    };
    match when_undefined {
        WhenUndefined::AsDeclared => text,
        WhenUndefined::Fails => text + " undefined fails",
        WhenUndefined::Passes => text + " undefined passes",
    }
}

fn metric_text(reference: &MetricReference) -> String {
    let found = reference.known();
    // Where it is written to, a group may stand as its members alone.
    let pair = reference.pair.iter().flat_map(|(car, person)| {
        let people =
            if reference.several.is_empty() { std::slice::from_ref(person) } else { &reference.several };
        match found.map(|metric| metric.scope) {
            Some(Scope::Vehicle) => vec![car.clone()],
            Some(Scope::Pedestrian) => people.to_vec(),
            Some(Scope::Contact) if person.is_empty() => vec![car.clone()],
            _ => [std::slice::from_ref(car), people].concat(),
        }
    });
    let declaration = found.map(|metric| &metric.declaration);
    let settings = reference.settings.0.iter().map(|(name, value)| setting(declaration, name, value));
    let inside: Vec<_> = pair.chain(settings).collect();
    if inside.is_empty() {
        reference.name().to_string()
    } else {
        format!("{}({})", reference.name(), inside.join(", "))
    }
}

/// A name with its settings, if there are any.
pub fn model_text<T: Registered>(model: &Model<T>) -> String {
    if model.settings.is_empty() {
        model.first.to_string()
    } else {
        format!("{} {{ {} }}", model.first, settings_text(model))
    }
}

pub fn settings_text<T: Registered>(model: &Model<T>) -> String {
    let declaration = model.first.declaration();
    let said = model.settings.iter().map(|(name, value)| setting(declaration, name, value_of(value)));
    said.collect::<Vec<_>>().join(", ")
}

/// `name: value` with the unit that the declaration asks for.
fn setting(declaration: Option<&Declaration>, name: &str, value: &Value) -> String {
    let kind = declaration.and_then(|known| known.parameter(name)).map(|parameter| &parameter.kind);
    let text = match (value, kind) {
        (Value::Number(number), Some(ParameterKind::Number { dimension, .. })) => {
            quantity(*number, *dimension)
        }
        (Value::Number(number), _) => number.to_string(),
        (Value::Flag(flag), _) => flag.to_string(),
        (Value::Word(word), _) if is_name(word) => word.clone(),
        (Value::Word(word), _) => quoted(word),
    };
    format!("{name}: {text}")
}

fn value_of(expression: &Expression) -> &Value {
    match expression {
        Expression::Constant(value) => value,
        other => panic!("variations are put in before a scenario is written, but this is left: {other:?}"),
    }
}

pub fn number_of(expression: &Expression) -> f64 {
    value_of(expression).as_number().expect("the checker found a number here")
}

pub fn constant(expression: &Expression, dimension: Dimension) -> String {
    quantity(number_of(expression), dimension)
}

/// A number in SI units with the unit in which it is shortest and is read back to the last bit.
pub fn quantity(si: f64, dimension: Dimension) -> String {
    if dimension == Dimension::NUMBER {
        return si.to_string();
    }
    // Rust writes the shortest digits that give the number back.
    let plain = format!("{si} {}", dimension.si_unit());
    let units = UNITS.iter().filter(|unit| unit.dimension == dimension && unit.is_usual);
    let in_unit = units.filter_map(|unit| {
        let number = unit.of_si(si);
        // Rounded to few digits it is often exactly what somebody wrote.
        (0..=6).map(|digits| format!("{number:.digits$}")).find_map(|text| {
            let exact = text.parse::<f64>().is_ok_and(|number| unit.to_si(number) == si);
            exact.then(|| format!("{text} {}", unit.symbol))
        })
    });
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).count();
    // The first of the shortest, and the plain one if none is shorter.
    in_unit.chain([plain.clone()]).min_by_key(|text| (digits(text), *text != plain)).unwrap_or(plain)
}

/// Whether a word can stand without quotes.
pub fn is_name(word: &str) -> bool {
    let mut letters = word.chars();
    letters.next().is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// A text in quotes, as scenario files write it; a line break becomes a space.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace(['\n', '\r'], " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_short_and_exact() {
        for (si, dimension, text) in [
            (30.0 / 3.6, Dimension::SPEED, "30 km/h"),
            (1.4, Dimension::SPEED, "1.4 m/s"),
            (10.0, Dimension::SPEED, "10 m/s"),
            (0.025, Dimension::TIME, "25 ms"),
            (6.0, Dimension::TIME, "6 s"),
            (-2.5, Dimension::LENGTH, "-2.5 m"),
            (0.95, Dimension::NUMBER, "0.95"),
            (0.0, Dimension::LENGTH, "0 m"),
            (1.0 / 3.0, Dimension::LENGTH, "0.3333333333333333 m"),
        ] {
            assert_eq!(quantity(si, dimension), text);
        }
    }
}
