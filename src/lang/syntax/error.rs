//! What is wrong with a statement that does not parse.

use pest::Parser;
use pest::error::{Error, ErrorVariant, InputLocation};

use super::lexer::{self, Token, TokenKind};
use super::tree::{Grammar, Node, Rule, Tree};
use super::words::{self as statements, StatementEntry};
use crate::codes::Code;
use crate::diagnostic::{Diagnostic, MOST_FINDINGS, Remedy, nearest};
use crate::source::{SourceId, Span};

/// A diagnostic for every statement that is `bad`.
pub fn explain(tree: &Tree) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for block in tree.nodes() {
        for child in block.children() {
            if diagnostics.len() > MOST_FINDINGS {
                return diagnostics;
            }
            match child.rule() {
                Rule::bad => diagnostics.push(statement(block, child)),
                Rule::bad_setting => diagnostics.push(setting(block.rule(), child)),
                _ => {}
            }
        }
    }
    diagnostics
}

fn statement(block: Node, bad: Node) -> Diagnostic {
    let context = block.block().unwrap_or(statements::BlockKind::File.block());
    let word = first_word(bad);
    let word_text = &bad.tree().text()[word.start..word.end];
    if let Some(statement) = context.beginning(bad.text()).or(context.free()) {
        return again(bad, statement);
    }
    let place = context.name;
    let elsewhere = statements::homes(word_text);
    if !elsewhere.is_empty() {
        return Diagnostic::new(
            Code::MisplacedStatement,
            word,
            format!("`{word_text}` does not belong in {place}"),
        )
        .label("not here")
        .hint(format!("it belongs in {}", elsewhere.join(" or ")));
    }
    if is_invisible(word_text) {
        return Diagnostic::new(
            Code::UnknownStatement,
            word,
            format!("{place} has no statement that begins with {}", words(bad.tree().text(), word)),
        )
        .label("here")
        .hint("remove it");
    }
    Diagnostic::new(Code::UnknownStatement, word, format!("{place} has no statement `{word_text}`"))
        .label("unknown here")
        .suggest(word_text, context.statements.iter().map(StatementEntry::word))
}

fn setting(block: Rule, bad: Node) -> Diagnostic {
    let kind = match block {
        Rule::parameter_set => &statements::GIVEN,
        Rule::weights_block => &statements::WEIGHT,
        _ => &statements::SETTING,
    };
    let mut diagnostic = again(bad, kind);
    diagnostic.code = Code::BadSetting;
    let comma = |text: &str| text.replace(END, "`,`");
    diagnostic.message = comma(&diagnostic.message);
    diagnostic.labels[0].text = comma(&diagnostic.labels[0].text);
    diagnostic
}

/// Parses the statement once more on its own, to see how far it gets.
fn again(bad: Node, statement: &StatementEntry) -> Diagnostic {
    let span = bad.span();
    let text = bad.tree().text();
    let hint = format!("it reads `{}`", statement.usage);
    // Only how errors are described depends on it, so that setting it again and for everybody is harmless.
    pest::set_error_detail(true);
    match Grammar::parse(statement.rule, bad.text()) {
        Err(error) => {
            let diagnostic = unexpected(span.source, span.start, text, &error).hint(hint);
            match advice(&text[span.start..], span.start, statement, &diagnostic) {
                Some(advice) => diagnostic.hint(advice),
                None => diagnostic,
            }
        }
        Ok(_) => Diagnostic::new(Code::UnexpectedText, span, "this statement cannot be read").hint(hint),
    }
}

/// What a statement that is being written could go on with.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Next {
    Metric,
    Aggregate,
    Value,
    Target,
    Name,
    SettingName,
    Tag,
    Distribution,
    Keyword(String),
    Sign,
}

/// What those statements could go on with that begin with `text`, each once and in the order of the grammar; nothing after what is
/// wrong already.
pub fn goes_on_with<'s>(statements: impl Iterator<Item = &'s StatementEntry>, text: &str) -> Vec<Next> {
    let mut rules: Vec<Rule> = statements.flat_map(|statement| after(statement.rule, text)).collect();
    rules.sort_unstable();
    rules.dedup();
    let mut all: Vec<Next> = Vec::new();
    for one in rules.into_iter().map(next) {
        if !all.contains(&one) {
            all.push(one);
        }
    }
    all
}

fn next(rule: Rule) -> Next {
    match rule {
        Rule::metric | Rule::condition | Rule::criterion | Rule::constraint => Next::Metric,
        Rule::rate
        | Rule::quantile
        | Rule::statistic
        | Rule::statistic_name
        | Rule::aggregate_claim
        | Rule::measured
        | Rule::measure => Next::Aggregate,
        Rule::expression
        | Rule::quantity
        | Rule::reference
        | Rule::lone_operand
        | Rule::group
        | Rule::each => Next::Value,
        Rule::target => Next::Target,
        Rule::name | Rule::when_condition | Rule::run_condition => Next::Name,
        Rule::setting_name => Next::SettingName,
        Rule::tag | Rule::points_of_tag => Next::Tag,
        Rule::distribution | Rule::distribution_name => Next::Distribution,
        other => match format!("{other:?}").strip_prefix("kw_") {
            Some(word) => Next::Keyword(word.to_string()),
            None => Next::Sign,
        },
    }
}

/// The rules with which one could go on.
fn after(rule: Rule, text: &str) -> Vec<Rule> {
    // No statement has this character outside of texts, so that every one stops there.
    const STOP: char = '\u{0}';
    let stopped = format!("{text}{STOP}");
    match Grammar::parse(rule, &stopped) {
        Err(Error {
            variant: ErrorVariant::ParsingError { positives, .. },
            location: InputLocation::Pos(at),
            ..
        }) if stopped[at..].trim_start().starts_with(STOP) => positives,
        _ => Vec::new(),
    }
}

/// What people mean who write what was found; `text` begins with the statement, at `start`.
fn advice(text: &str, start: usize, statement: &StatementEntry, diagnostic: &Diagnostic) -> Option<String> {
    let found = diagnostic.span();
    let may_end = diagnostic.message.contains(END);
    let (before, rest) = text.split_at(found.start - start);
    let token = &rest[..found.end - found.start];
    let criterion = statement.rule == Rule::criterion;
    let setting = matches!(statement.rule, Rule::whole_setting | Rule::whole_given | Rule::whole_weight);
    let digit = |c: char| c.is_ascii_digit();
    let in_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let advice = match token {
        "&" | "and" | "|" | "or" if criterion => {
            "every criterion has a line of its own, and all must hold".to_string()
        }
        "not" | "!" if criterion => "say `no collision` for what must not happen".to_string(),
        "-" if before.ends_with(in_name) && rest[1..].starts_with(in_name) => {
            "names are made of letters, digits and `_`".to_string()
        }
        "," | "." if before.ends_with(digit) && rest[1..].starts_with(digit) => {
            "the decimal sign is a point: `1.5`".to_string()
        }
        "." if before.ends_with(digit) || rest[1..].starts_with(digit) => {
            "digits stand on both sides of the decimal point: `0.5`".to_string()
        }
        "." if criterion => format!("of one road user it reads `METRIC({})`", first_name(before)?),
        ">" | "<" if before.ends_with('=') => format!("write `{token}=`"),
        "=" if before.ends_with([' ', '=']) && before.trim_end().ends_with(['<', '>', '=']) => {
            "a comparison is one sign without spaces: `<`, `<=`, `>`, `>=`, `=` or `!=`".to_string()
        }
        _ if may_end
            && !setting
            && (begins_a_statement(token) || criterion && token.starts_with(in_name)) =>
        {
            "a statement ends with its line; put `;` between two in one line".to_string()
        }
        _ => return None,
    };
    Some(advice)
}

fn first_name(text: &str) -> Option<&str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').find(|word| !word.is_empty())
}

fn begins_a_statement(word: &str) -> bool {
    !statements::homes(word).is_empty()
}

/// A pest error of text that begins at `offset`, in words.
pub fn unexpected(source: SourceId, offset: usize, text: &str, error: &Error<Rule>) -> Diagnostic {
    let mut at = match error.location {
        InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
    };
    let mut expected = match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => positives.iter().filter_map(describe).collect(),
        ErrorVariant::CustomError { message } => vec![message.clone()],
    };
    let (furthest, signs) = expected_signs(error);
    if furthest >= at && !signs.is_empty() {
        if furthest > at {
            expected.clear();
        }
        at = furthest;
        expected.extend(signs);
    }
    let found = next_token(source, text, offset + at);
    expected.sort();
    expected.dedup();
    if expected.len() > 1 {
        expected.retain(|words| words != OPERATOR);
    }
    for (general, special) in [(VALUE, "`(`"), (VALUE, "a text in quotes"), (COMPARISON, "`=`")] {
        if expected.iter().any(|words| words == general) {
            expected.retain(|words| words != special);
        }
    }
    let near = {
        let keywords = expected.iter().filter_map(|words| words.strip_prefix('`')?.strip_suffix('`'));
        nearest(&text[found.start..found.end], keywords.filter(|word| word.len() > 2)).map(str::to_string)
    };
    let list = match expected.as_slice() {
        [] => "something else".to_string(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    };
    let message = format!("expected {list}, found {}", words(text, found));
    const LONGEST_LABEL: usize = 40;
    let label =
        if list.len() > LONGEST_LABEL { "not expected here".to_string() } else { format!("expected {list}") };
    let diagnostic = Diagnostic::new(Code::UnexpectedText, found, message).label(label);
    match near {
        Some(near) => diagnostic.hint(format!("did you mean `{near}`?")).remedy(Remedy::Replace(near)),
        None => diagnostic,
    }
}

/// The brackets and signs that the statement could go on with at the furthest place that was read. Pest counts only
/// rules among what it expected; a sign is none.
fn expected_signs(error: &Error<Rule>) -> (usize, Vec<String>) {
    let Some(attempts) = error.parse_attempts() else { return (0, Vec::new()) };
    let tokens = attempts.expected_tokens();
    let signs = tokens.iter().map(ToString::to_string).filter(|token| SIGNS.contains(&token.as_str()));
    (attempts.max_position, signs.map(|sign| format!("`{sign}`")).collect())
}

fn words(text: &str, found: Span) -> String {
    match &text[found.start..found.end] {
        "" if text[found.end..].contains(['\n', '\r']) => "the end of the line".to_string(),
        "" => "the end of the file".to_string(),
        token if is_invisible(token) => {
            let number = token.chars().next().map_or(0, u32::from);
            format!("the invisible character U+{number:04X}")
        }
        token => format!("`{token}`"),
    }
}

/// Whether a token is one of the characters that look like a space or like nothing, as come with pasted text.
fn is_invisible(token: &str) -> bool {
    let looks_empty = |c: char| {
        c.is_whitespace()
            || c.is_control()
            || matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}')
    };
    token.chars().next().is_some_and(looks_empty)
}

/// The first token at or after `start` that is neither space nor comment. What ends a line or the text is the empty
/// place behind its last word.
fn next_token(source: SourceId, text: &str, start: usize) -> Span {
    let means_something = |token: &Token| !matches!(token.kind, TokenKind::Space | TokenKind::Comment);
    let rest = text[start..].split(['\n', '\r']).next().unwrap_or_default();
    if let Some(token) = lexer::fragment(rest).into_iter().find(means_something) {
        return Span::new(source, start + token.start, start + token.end);
    }
    let line = text[..start].rfind(['\n', '\r']).map_or(0, |at| at + 1);
    let last = lexer::fragment(&text[line..start]).into_iter().rfind(means_something);
    let end = last.map_or(start, |token| line + token.end);
    Span::new(source, end, end)
}

fn first_word(bad: Node) -> Span {
    let span = bad.span();
    let first = lexer::fragment(bad.text()).into_iter().find(|token| token.kind != TokenKind::Space);
    first.map_or(span, |token| Span::new(span.source, span.start + token.start, span.start + token.end))
}

/// Could follow every value, so it is mentioned only when nothing else could.
const OPERATOR: &str = "an operator such as `+`";
const END: &str = "the end of the statement";
const VALUE: &str = "a value";
const COMPARISON: &str = "a comparison such as `<=`";

/// The signs of the language that stand between other things. A list in brackets and an opening brace are also rules.
const SIGNS: [&str; 6] = ["=", ":", ",", "..", "(", ")"];

/// A rule as people call it; `None` for what goes without saying.
fn describe(rule: &Rule) -> Option<String> {
    let name = format!("{rule:?}");
    if *rule == Rule::kw_each {
        return Some(VALUE.to_string());
    }
    if let Some(keyword) = name.strip_prefix("kw_") {
        return Some(format!("`{keyword}`"));
    }
    let words = match rule {
        Rule::negation | Rule::modifier | Rule::base => return None,
        Rule::EOI => END,
        Rule::operator => OPERATOR,
        Rule::expression
        | Rule::quantity
        | Rule::number
        | Rule::reference
        | Rule::group
        | Rule::each
        | Rule::boolean => VALUE,
        Rule::unit => "a unit",
        Rule::name => "a name",
        Rule::string => "a text in quotes",
        Rule::integer => "a whole number",
        Rule::relation => COMPARISON,
        Rule::condition | Rule::metric | Rule::criterion => "a metric",
        Rule::direction => "`forward` or `backward`",
        Rule::list => "a list `[ … ]`",
        Rule::weighted_value => VALUE,
        Rule::distribution | Rule::distribution_name => "a distribution such as `uniform(…)`",
        Rule::range => "a range such as `6 s .. 18 s step 4 s`",
        Rule::setting | Rule::setting_name => "a setting `name: value`",
        Rule::settings => "settings `{ … }`",
        Rule::statistic_name | Rule::statistic | Rule::rate | Rule::quantile => {
            "an aggregate such as `mean(…)`"
        }
        Rule::start_distance => "a distance `… from kerb` or `… from lane centre`",
        Rule::population => "`standard` or a file's name in quotes",
        Rule::tag | Rule::points_of_tag => "a tag",
        Rule::weight => "a value with its weight `below 10 km/h: 0.25`",
        Rule::weight_bound => "`below`, `at most`, `above` or `at least`",
        Rule::signal => "a signal such as `ego.speed`",
        Rule::vehicle_part => "`front` or `centre`",
        Rule::varied => "`NAME in [ … ]`",
        Rule::target => "what to search over",
        Rule::initial | Rule::batch => "a whole number",
        Rule::constraint => "a metric",
        Rule::measured | Rule::measure => "an aggregate such as `mean(…)`",
        Rule::claimed | Rule::claimed_group | Rule::lone_operand => VALUE,
        Rule::trend => return None,
        Rule::outcomes => "what is measured",
        Rule::run_conditions => "`when`",
        Rule::run_condition => "a name that is varied",
        Rule::chosen => "`chosen(…)`",
        Rule::evaluated | Rule::conditions => "`default`, a tune, a file or `{ parameter: value }`",
        Rule::alias => "`as NAME`",
        Rule::as_many => "`as many of …`",
        Rule::given => "a setting `av.controller.name: value`",
        Rule::metric_details => return None,
        _ if name.ends_with("_block") => "`{`",
        _ => return Some(name.replace('_', " ")),
    };
    Some(words.to_string())
}
