//! Names, numbers, texts and calculations with them.

#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};
use scenario::BinaryOperator;

views! {
    /// What somebody calls something.
    Name = name {}
    /// `"words"`
    Text = string {}
    Integer = integer {}
    Number = number {}
    Unit = unit {}
    /// `ego.speed`, `time`
    Signal = signal {}
    /// `true` or `false`
    Boolean = boolean {}
    /// A name that stands for a value.
    Reference = reference {}
    /// `1.5 s`
    Quantity = quantity { number: Number, unit: (Unit) }
    /// `(…)`
    Group = group { inside: Expression }
    /// `each(0 m, 0.7 m)`: the first member of a group takes the first value, and so on.
    Each = each { values: [Expression] }
    /// A calculation; after the `when` of a claim, of one operand only.
    Expression = expression | lone_operand {}
    /// `[a, b]`
    List = list { values: [Expression] }
    /// `{ profile: normal }`, or what stands in brackets after a metric, where road users may be named too.
    Settings = settings | metric_details { each: [Setting], names: [Name] }
    /// `profile: normal`
    Setting = setting { name: SettingName, value: Expression }
    SettingName = setting_name {}
}

choices! {
    /// What means something by itself.
    Word = Name | Reference | SettingName | Signal | Unit;
    /// What a value is made of, between operators.
    Operand = Quantity | Boolean | Each | Text | Group | Reference;
}

/// A part of a calculation.
#[derive(Debug, Clone, Copy)]
pub enum Term<'t> {
    Negation,
    Operator(BinaryOperator),
    Operand(Node<'t>),
}

impl<'t> Node<'t> {
    /// The node as a calculation.
    pub fn terms(self) -> impl Iterator<Item = Term<'t>> {
        self.children().map(|part| match (part.rule(), part.text()) {
            (Rule::negation, _) => Term::Negation,
            (Rule::operator, "*") => Term::Operator(BinaryOperator::Multiply),
            (Rule::operator, "/") => Term::Operator(BinaryOperator::Divide),
            (Rule::operator, "+") => Term::Operator(BinaryOperator::Add),
            (Rule::operator, _) => Term::Operator(BinaryOperator::Subtract),
            _ => Term::Operand(part),
        })
    }
}

impl<'t> Expression<'t> {
    /// The name that it consists of, if it is nothing but one.
    pub fn lone_word(self) -> Option<&'t str> {
        let mut parts = self.children();
        let first = Reference::cast(parts.next()?)?;
        parts.next().is_none().then(|| first.text())
    }

    /// The number and the unit, if it is nothing but a quantity with its sign.
    pub fn signed_quantity(self) -> Option<(f64, &'t str)> {
        let mut sign = 1.0;
        let mut found = None;
        for term in self.terms() {
            match term {
                Term::Negation => sign = -sign,
                Term::Operand(operand) if found.is_none() => found = Some(Quantity::cast(operand)?),
                _ => return None,
            }
        }
        let quantity = found?;
        let unit = quantity.unit().map_or("", |unit| unit.text());
        Some((sign * quantity.number().value()?, unit))
    }
}

impl Number<'_> {
    pub fn value(self) -> Option<f64> {
        self.text().replace('_', "").parse().ok()
    }
}

impl Text<'_> {
    /// What stands between the quotes.
    pub fn value(self) -> String {
        unquote(self.text(), true)
    }

    /// The same of the name of a file: on Windows backslashes separate folders. Elsewhere they are refused, and what else there is to say of the
    /// file is said of the one that was meant.
    pub fn path(self) -> String {
        if cfg!(windows) { self.word() } else { self.value().replace('\\', "/") }
    }

    /// The same of a word of a command, which may be the name of a file.
    pub fn word(self) -> String {
        unquote(self.text(), !cfg!(windows))
    }
}

/// A text without its quotes; with letters that are line ends and tabs behind a backslash, if they are. A backslash that makes nothing else of
/// what follows it stays.
fn unquote(quoted: &str, has_layout: bool) -> String {
    let inner = quoted.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(quoted);
    let mut text = String::with_capacity(inner.len());
    let mut characters = inner.chars();
    while let Some(character) = characters.next() {
        match character {
            '\\' => match characters.next() {
                Some('n') if has_layout => text.push('\n'),
                Some('t') if has_layout => text.push('\t'),
                Some(escaped @ ('"' | '\\')) => text.push(escaped),
                Some(other) => text.extend(['\\', other]),
                None => {}
            },
            other => text.push(other),
        }
    }
    text
}
