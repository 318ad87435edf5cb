//! From the text of a filter expression to conditions and how they are combined, or to everything that is wrong.

use pest::Parser;
use pest::iterators::Pair;
use reader::filter::{Grammar, Rule};

use super::condition::{Condition, Expression, Filter, Test};
use super::matcher::{Bound, Mark, Matcher, ValueMatcher};
use super::predicate::{Asked, PREDICATES, Predicate};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, Span};
use crate::syntax::DEEPEST_NESTING;
use scenario::Relation;

/// The filter, unless something is wrong.
pub fn parse(source: SourceId, text: &str, report: &mut Vec<Diagnostic>) -> Option<Filter> {
    let before = report.len();
    if let Some(at) = too_deep(text) {
        let span = Span::new(source, at, at + 1);
        let message = format!("brackets are nested more than {DEEPEST_NESTING} deep");
        let finding = Diagnostic::new(Code::NestedTooDeeply, span, message).label("too deep");
        report.push(finding.hint("give several expressions, each with its own -E: any of them selects"));
        return None;
    }
    let pairs = match Grammar::parse(Rule::filter, text) {
        Ok(pairs) => pairs,
        Err(error) => {
            let at = match error.location {
                pest::error::InputLocation::Pos(at) | pest::error::InputLocation::Span((at, _)) => at,
            };
            let finding = Diagnostic::new(Code::BadFilter, Span::new(source, at, at), "this is no filter");
            report.push(finding.label("not understood").hint(SEE));
            return None;
        }
    };
    let mut reader = Reader { source, conditions: Vec::new(), report };
    let mut terms = Terms::default();
    for part in pairs.flat_map(Pair::into_inner) {
        match part.as_rule() {
            Rule::expression => terms.add(reader.expression(part)),
            Rule::stray => reader.complain(&part, "`)` closes nothing", "never opened", "take it out"),
            _ => reader.joined(part, &mut terms),
        }
    }
    let conditions = reader.conditions;
    (report.len() == before).then(|| Filter { expression: terms.finish(), conditions })
}

const SEE: &str = "`scenario-runner help filter` shows the whole language";

/// The first bracket that is nested too deeply.
fn too_deep(text: &str) -> Option<usize> {
    let mut depth = 0usize;
    text.bytes().enumerate().find_map(|(at, byte)| {
        match byte {
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        (depth > DEEPEST_NESTING).then_some(at)
    })
}

/// Terms between operators; `&` binds more tightly than `|`.
#[derive(Default)]
struct Terms {
    any: Vec<Vec<Expression>>,
    /// How the next term is joined to the last.
    union: bool,
    negated: bool,
}

impl Terms {
    fn add(&mut self, term: Expression) {
        let term = if std::mem::take(&mut self.negated) { Expression::Not(Box::new(term)) } else { term };
        match self.any.last_mut() {
            Some(all) if !std::mem::take(&mut self.union) => all.push(term),
            _ => self.any.push(vec![term]),
        }
        self.union = false;
    }

    fn finish(self) -> Expression {
        Expression::Any(self.any.into_iter().map(Expression::All).collect())
    }
}

struct Reader<'r> {
    source: SourceId,
    conditions: Vec<Condition>,
    report: &'r mut Vec<Diagnostic>,
}

impl Reader<'_> {
    fn span(&self, pair: &Pair<Rule>) -> Span {
        let span = pair.as_span();
        let text = span.as_str().trim_end();
        Span::new(self.source, span.start(), span.start() + text.len())
    }

    fn complain(
        &mut self,
        at: &Pair<Rule>,
        message: impl Into<String>,
        label: &str,
        hint: impl Into<String>,
    ) {
        let finding = Diagnostic::new(Code::BadFilter, self.span(at), message);
        self.report.push(finding.label(label).hint(hint));
    }

    fn expression(&mut self, pair: Pair<Rule>) -> Expression {
        let mut terms = Terms::default();
        for part in pair.into_inner() {
            self.joined(part, &mut terms);
        }
        terms.finish()
    }

    /// A term, or what joins it to the one before.
    fn joined(&mut self, part: Pair<Rule>, terms: &mut Terms) {
        match part.as_rule() {
            Rule::term => {
                let term = self.term(part);
                terms.add(term);
            }
            Rule::union => terms.union = true,
            Rule::difference => terms.negated = true,
            Rule::wrong => {
                let hint = match part.as_str() {
                    "&&" => "write `&`, `and`, or `-` for `and not`",
                    "||" => "write `|`, `+` or `or`",
                    _ => "join predicates by `&` (both) or `|` (either)",
                };
                self.complain(&part, format!("`{}` is no operator", part.as_str()), "no operator", hint);
            }
            Rule::adjacent => {
                let start = self.span(&part).start;
                let finding = Diagnostic::new(
                    Code::BadFilter,
                    Span::new(self.source, start, start),
                    "there is no operator between two predicates",
                );
                self.report.push(
                    finding.label("expected `&` or `|`").hint("join them by `&` (both) or `|` (either)"),
                );
                let term = self.term(part);
                terms.add(term);
            }
            _ => {}
        }
    }

    fn term(&mut self, pair: Pair<Rule>) -> Expression {
        let mut negated = false;
        let mut term = Expression::Any(Vec::new());
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::negation => negated = !negated,
                Rule::term => term = self.term(part),
                Rule::group => term = self.group(part),
                Rule::predicate => term = self.predicate(part),
                Rule::bare => self.bare(&part),
                _ => self.complain(
                    &part,
                    "a predicate is missing",
                    "expected a predicate such as `scenario(…)`",
                    SEE,
                ),
            }
        }
        if negated { Expression::Not(Box::new(term)) } else { term }
    }

    fn group(&mut self, pair: Pair<Rule>) -> Expression {
        let opened = self.span(&pair).start;
        let mut inner = Expression::Any(Vec::new());
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::expression => inner = self.expression(part),
                _ => self.unclosed(opened),
            }
        }
        inner
    }

    fn unclosed(&mut self, at: usize) {
        let span = Span::new(self.source, at, at + 1);
        let finding = Diagnostic::new(Code::BadFilter, span, "`(` is never closed").label("opened here");
        self.report.push(finding.hint("close it with `)`"));
    }

    /// A word without brackets.
    fn bare(&mut self, pair: &Pair<Rule>) {
        let word = pair.as_str();
        let (message, hint) = match Predicate::of(word) {
            Some(Predicate { default: None, .. }) => {
                (format!("`{word}` has no brackets"), format!("write `{word}()`"))
            }
            Some(known) => {
                (format!("`{word}` does not say which"), format!("write it as in `{}`", known.example))
            }
            None => (
                format!("`{word}` stands outside of a predicate"),
                format!("to select by a part of the name, write `scenario({word})`"),
            ),
        };
        self.complain(pair, message, "expected a predicate such as `scenario(…)`", hint);
    }

    fn predicate(&mut self, pair: Pair<Rule>) -> Expression {
        let span = self.span(&pair);
        let mut known = None;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => known = self.known(&part).map(|known| (known, self.span(&part).end)),
                Rule::argument => {
                    let Some((predicate, _)) = known else { continue };
                    if let Some((test, text)) = self.test(predicate, part) {
                        self.conditions.push(Condition { asked: predicate.asked, test, text, span });
                    }
                }
                _ => {
                    let opened = known.map_or(span.start, |(_, end)| end);
                    self.unclosed(opened);
                }
            }
        }
        Expression::Condition(self.conditions.len().saturating_sub(1))
    }

    fn known(&mut self, name: &Pair<Rule>) -> Option<&'static Predicate> {
        let found = Predicate::of(name.as_str());
        if found.is_none() {
            let message = format!("there is no predicate `{}`", name.as_str());
            let finding = Diagnostic::new(Code::UnknownPredicate, self.span(name), message)
                .label("unknown predicate")
                .suggest(name.as_str(), PREDICATES.iter().map(|predicate| predicate.name));
            self.report.push(finding);
        }
        found
    }

    fn bad_pattern(&mut self, span: Span, message: String, label: &str, hint: String) {
        self.report.push(Diagnostic::new(Code::BadFilterPattern, span, message).label(label).hint(hint));
    }

    /// What stands in the brackets, and its text for hints.
    fn test(&mut self, predicate: &Predicate, argument: Pair<Rule>) -> Option<(Test, String)> {
        let span = self.span(&argument);
        let whole = argument.as_str().trim();
        let Some(default) = predicate.default else {
            if !whole.is_empty() {
                let message = format!("`{}` takes nothing in its brackets", predicate.name);
                self.bad_pattern(span, message, "not here", format!("write `{}`", predicate.example));
                return None;
            }
            return Some((Test::Always(predicate.asked == Asked::All), String::new()));
        };
        if whole.is_empty() {
            let message = format!("`{}` does not say which", predicate.name);
            let hint = format!("write it as in `{}`", predicate.example);
            self.bad_pattern(span, message, "expected a pattern", hint);
            return None;
        }
        let part = argument.into_inner().next()?;
        if predicate.asked == Asked::Variation {
            return self.value(predicate, &part).map(|test| (test, whole.to_string()));
        }
        let (mark, text, at) = match part.as_rule() {
            Rule::regex | Rule::marked => self.marked(part)?,
            _ => (default, whole, span),
        };
        if mark == default && text == whole && text.starts_with('/') {
            let message = "a regular expression ends with `/`".to_string();
            let hint = format!("to mean the text itself, write `{}(={text})`", predicate.name);
            self.bad_pattern(at, message, "begun here, or not meant as one", hint);
            return None;
        }
        let matcher = self.matcher(mark, text, at)?;
        Some((Test::Name(matcher), text.to_string()))
    }

    /// `/regex/` or a mark with text.
    fn marked<'t>(&self, pair: Pair<'t, Rule>) -> Option<(Mark, &'t str, Span)> {
        let is_regex = pair.as_rule() == Rule::regex;
        let mut parts = pair.into_inner();
        let first = parts.next()?;
        if is_regex {
            return Some((Mark::Regex, first.as_str(), self.span(&first)));
        }
        let mark = match first.as_str() {
            "=" => Mark::Equal,
            "~" => Mark::Contains,
            _ => Mark::Glob,
        };
        let text = parts.next()?;
        Some((mark, text.as_str().trim_end(), self.span(&text)))
    }

    fn matcher(&mut self, mark: Mark, text: &str, at: Span) -> Option<Matcher> {
        let text = if mark == Mark::Regex { text.replace("\\/", "/") } else { self.unescaped(text, at)? };
        match Matcher::new(mark, &text) {
            Ok(matcher) => Some(matcher),
            Err(error) => {
                let message = format!("`{text}` is no {}: {error}", mark.words());
                let hint = match mark {
                    Mark::Regex => {
                        "`.`, `*`, `[…]`, `(…|…)`, `^`, `$` have a meaning; `\\` before one takes it away"
                    }
                    _ => "a glob knows `*`, `?`, `[abc]`, and `**` for any number of folders",
                };
                self.bad_pattern(at, message, "malformed", hint.to_string());
                None
            }
        }
    }

    /// Without the `\` before brackets and `\` themselves.
    fn unescaped(&mut self, text: &str, at: Span) -> Option<String> {
        let mut plain = String::with_capacity(text.len());
        let mut characters = text.chars();
        while let Some(character) = characters.next() {
            let escaped = if character == '\\' { characters.next() } else { Some(character) };
            match escaped {
                Some(c) if character != '\\' || "()\\/=~#".contains(c) => plain.push(c),
                other => {
                    let found: String = other.into_iter().collect();
                    let message = format!("`\\{found}` means nothing");
                    let hint = "`\\(`, `\\)`, `\\/` and `\\\\` stand for the character itself".to_string();
                    self.bad_pattern(at, message, "malformed", hint);
                    return None;
                }
            }
        }
        Some(plain)
    }

    /// `name`, `name=value`, `name>=value`, `name~text`, `name#glob`, `name/regex/`.
    fn value(&mut self, predicate: &Predicate, argument: &Pair<Rule>) -> Option<Test> {
        let span = self.span(argument);
        let only_a_name = argument.as_rule() == Rule::plain && is_name(argument.as_str().trim());
        if only_a_name {
            let name = argument.as_str().trim().to_string();
            return Some(Test::Value { name, value: ValueMatcher::Any });
        }
        let mut parts = argument.clone().into_inner();
        let (Rule::pair, Some(key), Some(part)) = (argument.as_rule(), parts.next(), parts.next()) else {
            let message = format!("`{}` needs the name of a variation first", predicate.name);
            let hint = "write it as in `variation(tta=6s)` or `variation(tta >= 10 s)`".to_string();
            self.bad_pattern(span, message, "expected `NAME=VALUE`", hint);
            return None;
        };
        let name = key.as_str().to_string();
        let value = match part.as_rule() {
            Rule::relation => {
                let relation = match part.as_str() {
                    "<" => Relation::Less,
                    "<=" | "≤" => Relation::LessOrEqual,
                    ">" => Relation::Greater,
                    ">=" | "≥" => Relation::GreaterOrEqual,
                    _ => Relation::NotEqual,
                };
                let text = parts.next()?;
                self.comparison(relation, text.as_str(), self.span(&text))?
            }
            _ => match self.marked(part)? {
                (Mark::Equal, text, at) => self.comparison(Relation::Equal, text, at)?,
                (mark, text, at) => ValueMatcher::Label(self.matcher(mark, text, at)?),
            },
        };
        Some(Test::Value { name, value })
    }

    fn comparison(&mut self, relation: Relation, text: &str, at: Span) -> Option<ValueMatcher> {
        let text = self.unescaped(text.trim(), at)?;
        let bound = Bound::new(&text);
        let has_order = !matches!(relation, Relation::Equal | Relation::NotEqual);
        if text.is_empty() || has_order && !bound.is_quantity() {
            let message = match text.as_str() {
                "" => "a value is missing".to_string(),
                _ => format!("`{text}` is no quantity, and words have no order"),
            };
            let hint = "write a number with its unit, as in `variation(tta >= 10 s)`".to_string();
            self.bad_pattern(at, message, "expected a quantity", hint);
            return None;
        }
        Some(ValueMatcher::Compare { relation, bound })
    }
}

fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}
