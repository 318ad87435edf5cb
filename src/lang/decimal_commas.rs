//! Lists in which a comma may have been meant as a decimal point: `[0,5 %, 1,25 %]` has four values.

use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::syntax::ast;
use super::syntax::{Node, Tree};

/// A warning for each list of which some commas look as if they were decimal points: between digits, without a space, where only what is
/// behind has a unit, or other commas of the list have a space behind them.
pub fn found(tree: &Tree) -> Vec<Diagnostic> {
    tree.nodes().filter_map(in_list).collect()
}

fn in_list(list: Node) -> Option<Diagnostic> {
    let values: Vec<ast::Expression> = list.parts().collect();
    let text = list.text();
    let between = |one: &ast::Expression, other: &ast::Expression| {
        let start = list.span().start;
        text.get(one.span().end - start..other.span().start - start).unwrap_or_default()
    };
    let pairs = || values.windows(2).map(|two| (two[0], two[1]));
    let is_tight = |(one, other): &(ast::Expression, ast::Expression)| {
        between(one, other) == "," && is_whole(one.text()) && begins_with_digit(other.text())
    };
    let has_space = pairs().any(|(one, other)| between(&one, &other).contains([' ', '\n']));
    let lacks_unit = |(_, other): &(ast::Expression, ast::Expression)| !is_number(other.text());
    let suspicious: Vec<bool> =
        pairs().map(|pair| is_tight(&pair) && (has_space || lacks_unit(&pair))).collect();
    let first = suspicious.iter().position(|one| *one)?;
    let mut points = values[0].text().to_string();
    for (value, joins) in values[1..].iter().zip(&suspicious) {
        points += if *joins { "." } else { ", " };
        points += value.text();
    }
    let commas: Vec<&str> = values.iter().map(|value| value.text()).collect();
    let (one, other) = (values[first], values[first + 1]);
    let mut span = one.span();
    span.end = other.span().end;
    let message = format!("`{},{}` is read as two values, `{0}` and `{1}`", one.text(), other.text());
    Some(
        Diagnostic::new(Code::DecimalComma, span, message)
            .label("a comma separates values")
            .note(format!("as it stands: {}", of_values(commas.len(), &commas.join(", "))))
            .note(format!("with decimal points: {}", of_values(points.split(", ").count(), &points)))
            .hint(format!(
                "write a point, `{}.{}`, or a space behind commas that separate: `{0}, {1}`",
                one.text(),
                other.text()
            )),
    )
}

fn of_values(count: usize, values: &str) -> String {
    let noun = if count == 1 { "value" } else { "values" };
    format!("{count} {noun}, {values}")
}

fn is_whole(text: &str) -> bool {
    let digits = text.strip_prefix('-').unwrap_or(text);
    !digits.is_empty() && digits.chars().all(|letter| letter.is_ascii_digit())
}

fn begins_with_digit(text: &str) -> bool {
    text.starts_with(|letter: char| letter.is_ascii_digit())
}

/// Whether it is a number without a unit.
fn is_number(text: &str) -> bool {
    text.parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::SourceId;

    fn notes(values: &str) -> Vec<String> {
        let text = format!("scenario s {{\n  vary x in {values}\n}}\n");
        let (tree, wrong) = Tree::parse(SourceId(0), text.as_str().into());
        assert!(wrong.is_empty(), "{values}: {wrong:?}");
        found(&tree).into_iter().flat_map(|one| one.notes).collect()
    }

    #[test]
    fn both_readings_are_told() {
        let both =
            ["as it stands: 4 values, 0, 5 %, 1, 25 %", "with decimal points: 2 values, 0.5 %, 1.25 %"];
        assert_eq!(notes("[0,5 %, 1,25 %]"), both);
        assert_eq!(notes("[0,5 %,1,25 %]"), both, "units tell, whatever spaces are");
        assert_eq!(notes("[1,5, 2,5]")[1], "with decimal points: 2 values, 1.5, 2.5");
        assert_eq!(notes("[0,5 %]")[1], "with decimal points: 1 value, 0.5 %");
        assert_eq!(notes("[-1,5 m, 2 m]")[1], "with decimal points: 2 values, -1.5 m, 2 m");
        assert_eq!(notes("uniform(0,5 s, 1,5 s) 5 times").len(), 2);
    }

    #[test]
    fn lists_that_can_only_be_meant_as_they_are_draw_no_warning() {
        for right in
            ["[1,2,3]", "[1, 2, 3]", "[0, 5 %, 10 %]", "[0 %,5 %]", "[1.5,2 m]", "[a,5]", "[0.5 %, 1.25 %]"]
        {
            assert_eq!(notes(right), [""; 0], "{right}");
        }
    }
}
