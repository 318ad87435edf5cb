//! What is wrong with a statement that does not parse.

use pest::Parser;
use pest::error::{Error, ErrorVariant, InputLocation};

use super::codes::Code;
use super::diagnostic::Diagnostic;
use super::lexer::{self, TokenKind};
use super::source::{SourceId, Span};
use super::tree::{Grammar, Node, Rule, Tree};

/// The statements of a block: first word and rule.
type Statements = &'static [(&'static str, Rule)];

const FILE: Statements = &[
    ("use", Rule::use_file),
    ("let", Rule::binding),
    ("road", Rule::road_definition),
    ("define", Rule::define),
    ("scenario", Rule::scenario),
    ("suite", Rule::suite),
];
const ROAD: Statements = &[
    ("lanes", Rule::lanes),
    ("lane_width", Rule::lane_width),
    ("speed_limit", Rule::speed_limit),
    ("no", Rule::no_kerbs),
    ("crossing", Rule::crossing),
    ("box", Rule::obstacle),
    ("parked", Rule::obstacle),
];
const SCENARIO: Statements = &[
    ("tags", Rule::tags),
    ("road", Rule::road_choice),
    ("vehicle", Rule::vehicle),
    ("pedestrian", Rule::pedestrian),
    ("vary", Rule::vary),
    ("repeat", Rule::repeat),
    ("step", Rule::step),
    ("horizon", Rule::horizon),
    ("finish", Rule::finish),
    ("end", Rule::end_on_collision),
    ("expect", Rule::expect),
    ("let", Rule::binding),
];
const VEHICLE: Statements = &[
    ("controller", Rule::controller),
    ("dynamics", Rule::dynamics),
    ("sees", Rule::sees),
    ("size", Rule::size),
    ("speed", Rule::speed),
    ("lane", Rule::lane),
    ("start", Rule::vehicle_start),
];
const PEDESTRIAN: Statements = &[
    ("model", Rule::model),
    ("individuals", Rule::individuals),
    ("individual", Rule::individual),
    ("size", Rule::size),
    ("radius", Rule::radius),
    ("start", Rule::pedestrian_start),
    ("from", Rule::side),
    ("along", Rule::along),
    ("goal", Rule::goal),
    ("appears", Rule::appears),
];
const SUITE: Statements = &[
    ("scenarios", Rule::suite_files),
    ("tags", Rule::tags),
    ("seed", Rule::seed),
    ("time_limit", Rule::time_limit),
    ("expect", Rule::expect),
    ("scenario", Rule::scenario),
];

/// The blocks with the word that people know them by.
const BLOCKS: &[(Rule, &str, Statements)] = &[
    (Rule::file, "a file", FILE),
    (Rule::road_block, "a `road`", ROAD),
    (Rule::scenario_block, "a `scenario`", SCENARIO),
    (Rule::vehicle_block, "a `vehicle`", VEHICLE),
    (Rule::pedestrian_block, "a `pedestrian`", PEDESTRIAN),
    (Rule::suite_block, "a `suite`", SUITE),
];

/// A diagnostic for every statement that is `bad`.
pub fn explain(tree: &Tree) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for block in tree.nodes() {
        for child in block.children() {
            match child.rule() {
                Rule::bad => diagnostics.push(statement(block.rule(), child)),
                Rule::bad_setting => diagnostics.push(setting(child)),
                _ => {}
            }
        }
    }
    diagnostics
}

fn statement(block: Rule, bad: Node) -> Diagnostic {
    match block {
        Rule::expect_block => return again(bad, Rule::criterion, "a criterion"),
        Rule::together_block => return again(bad, Rule::varied, "`NAME in [ … ]`"),
        _ => {}
    }
    let (place, statements) = BLOCKS
        .iter()
        .find(|(rule, ..)| *rule == block)
        .map_or(("this block", FILE), |(_, place, statements)| (*place, *statements));
    let word = first_word(bad);
    let word_text = &bad.tree().text()[word.start..word.end];
    if let Some((_, rule)) = statements.iter().find(|(keyword, _)| *keyword == word_text) {
        let is_together =
            *rule == Rule::vary && bad.text()["vary".len()..].trim_start().starts_with("together");
        let rule = if is_together { Rule::vary_together } else { *rule };
        return again(bad, rule, "this statement");
    }
    let elsewhere: Vec<&str> = BLOCKS
        .iter()
        .filter(|(_, _, statements)| statements.iter().any(|(keyword, _)| *keyword == word_text))
        .map(|(_, place, _)| *place)
        .collect();
    if !elsewhere.is_empty() {
        return Diagnostic::new(
            Code::MisplacedStatement,
            word,
            format!("`{word_text}` does not belong into {place}"),
        )
        .label("not here")
        .hint(format!("it belongs into {}", elsewhere.join(" or ")));
    }
    Diagnostic::new(Code::UnknownStatement, word, format!("{place} has no statement `{word_text}`"))
        .label("unknown here")
        .suggest(word_text, statements.iter().map(|(keyword, _)| *keyword))
}

fn setting(bad: Node) -> Diagnostic {
    let mut diagnostic = again(bad, Rule::setting, "a setting");
    diagnostic.code = Code::BadSetting;
    diagnostic.hint("settings read `name: value`, with commas or line ends between them")
}

/// Parses the statement once more on its own, to see how far it gets.
fn again(bad: Node, rule: Rule, what: &str) -> Diagnostic {
    let span = bad.span();
    match Grammar::parse(rule, bad.text()) {
        Err(error) => unexpected(span.source, span.start, bad.tree().text(), &error, Some(what)),
        Ok(pairs) => {
            let parsed = pairs.last().map_or(0, |pair| pair.as_span().end());
            let rest = bad.text()[parsed..].trim_start_matches([' ', '\t', '\u{feff}']);
            let start = span.end - rest.len();
            let found = Span::new(span.source, start, end_of_token(bad.tree().text(), start));
            let text = &bad.tree().text()[found.start..found.end];
            Diagnostic::new(Code::UnexpectedText, found, format!("`{text}` does not belong to {what}"))
                .label("expected the end of the line")
                .hint("a statement ends with its line; put `;` between two in one line")
        }
    }
}

/// A pest error of text that begins at `offset`, in words.
pub fn unexpected(
    source: SourceId,
    offset: usize,
    text: &str,
    error: &Error<Rule>,
    what: Option<&str>,
) -> Diagnostic {
    let at = match error.location {
        InputLocation::Pos(at) | InputLocation::Span((at, _)) => at + offset,
    };
    let span = Span::new(source, at, end_of_token(text, at));
    let found = match &text[span.start..span.end] {
        "" => "the end of the file".to_string(),
        "\n" | "\r\n" | "\r" => "the end of the line".to_string(),
        token => format!("`{token}`"),
    };
    let mut expected = match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => positives.iter().filter_map(describe).collect(),
        ErrorVariant::CustomError { message } => vec![message.clone()],
    };
    expected.sort();
    expected.dedup();
    let list = match expected.as_slice() {
        [] => "something else".to_string(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    };
    let message = match what {
        Some(_) => format!("expected {list}, found {found}"),
        None => format!("cannot read {found}"),
    };
    Diagnostic::new(Code::UnexpectedText, span, message)
        .label(format!("expected {list}"))
        .hint(format!("{} is described by `scenario-runner explain E0106`", what.unwrap_or("it")))
}

/// The token that begins at `start`; empty at the end of the text.
fn end_of_token(text: &str, start: usize) -> usize {
    let rest = &text[start..];
    let end = rest.find(['\n', '\r']).map_or(rest.len(), |end| end + 1);
    lexer::tokens(&rest[..end]).first().map_or(start, |token| start + token.end)
}

fn first_word(bad: Node) -> Span {
    let span = bad.span();
    let first = lexer::tokens(bad.text()).into_iter().find(|token| token.kind != TokenKind::Space);
    first.map_or(span, |token| Span::new(span.source, span.start + token.start, span.start + token.end))
}

/// A rule as people call it; `None` for what goes without saying.
fn describe(rule: &Rule) -> Option<String> {
    let name = format!("{rule:?}");
    if let Some(keyword) = name.strip_prefix("kw_") {
        return Some(format!("`{keyword}`"));
    }
    let words = match rule {
        Rule::EOI | Rule::operator | Rule::negation | Rule::modifier | Rule::base => return None,
        Rule::expression | Rule::quantity | Rule::number | Rule::reference | Rule::group | Rule::boolean => {
            "a value"
        }
        Rule::unit => "a unit",
        Rule::name => "a name",
        Rule::string => "a text in quotes",
        Rule::integer => "a whole number",
        Rule::relation => "a comparison such as `<=`",
        Rule::condition | Rule::metric | Rule::criterion => "a metric",
        Rule::direction => "`forward` or `backward`",
        Rule::list => "a list `[ … ]`",
        Rule::distribution | Rule::distribution_name => "a distribution such as `uniform(…)`",
        Rule::range => "a range such as `6 s .. 18 s step 4 s`",
        Rule::setting | Rule::setting_name => "a setting `name: value`",
        Rule::settings => "settings `{ … }`",
        Rule::statistic_name | Rule::statistic | Rule::rate | Rule::quantile => {
            "an aggregate such as `mean(…)`"
        }
        Rule::start_distance => "a distance `… from kerb` or `… from lane centre`",
        Rule::population => "`standard` or a file's name in quotes",
        Rule::tag => "a tag",
        Rule::vehicle_part => "`front` or `centre`",
        Rule::varied => "`NAME in [ … ]`",
        Rule::metric_details => return None,
        _ if name.ends_with("_block") => "`{`",
        _ => return Some(name.replace('_', " ")),
    };
    Some(words.to_string())
}
