//! Generates the reader of `scn.pest`: functions that find where the rules of the grammar match a text.
//!
//! The generator takes the same optimised rules as `pest_derive`, so that both read the same. In addition it works out the bytes with
//! which a match of each rule can begin: of the many statements that a line may be, the reader tries those that begin like the line.

use std::collections::HashMap;
use std::mem::discriminant;
use std::path::Path;
use std::{env, fs};

use pest_meta::ast::RuleType;
use pest_meta::optimizer::{OptimizedExpr, OptimizedRule, optimize};
use pest_meta::parser;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // From the build script of the package `grammar`.
    let path = env::var("DEP_SCN_GRAMMAR_TEXT").expect("the package `grammar` gives the path of its text");
    println!("cargo::rerun-if-changed={path}");
    let text = fs::read_to_string(path).expect("the grammar is there");
    let pairs = parser::parse(parser::Rule::grammar_rules, &text).expect("the grammar can be parsed");
    let rules = optimize(parser::consume_rules(pairs).expect("the grammar is valid"));
    let out = env::var("OUT_DIR").expect("Cargo says where it goes");
    fs::write(Path::new(&out).join("scn.rs"), reader(&rules)).expect("the reader can be written");
}

/// What a text may begin with.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Beginning {
    bytes: [bool; 256],
    /// Whether nothing may be enough.
    empty: bool,
}

impl Beginning {
    const NOTHING: Self = Self { bytes: [false; 256], empty: true };

    fn one_of(belongs: impl Fn(u8) -> bool) -> Self {
        Self { bytes: std::array::from_fn(|byte| belongs(byte as u8)), empty: false }
    }

    fn or(mut self, other: Self) -> Self {
        self.bytes.iter_mut().zip(other.bytes).for_each(|(one, other)| *one |= other);
        Self { empty: self.empty || other.empty, ..self }
    }

    /// The pattern of those bytes, for `matches!`.
    fn pattern(&self) -> String {
        let mut ranges: Vec<(usize, usize)> = Vec::new();
        for byte in (0..256).filter(|byte| self.bytes[*byte]) {
            match ranges.last_mut() {
                Some((_, last)) if *last + 1 == byte => *last = byte,
                _ => ranges.push((byte, byte)),
            }
        }
        ranges.iter().map(|(first, last)| format!("{first}..={last}")).collect::<Vec<_>>().join(" | ")
    }
}

/// What every rule may begin with: the least sets that agree with all rules.
fn beginnings(rules: &[OptimizedRule]) -> HashMap<&str, Beginning> {
    let none = Beginning { empty: false, ..Beginning::NOTHING };
    let mut known: HashMap<&str, Beginning> = rules.iter().map(|rule| (rule.name.as_str(), none)).collect();
    loop {
        let before = known.clone();
        for rule in rules {
            let found = beginning(&rule.expr, &known);
            known.insert(&rule.name, found);
        }
        if known == before {
            return known;
        }
    }
}

fn beginning(expression: &OptimizedExpr, known: &HashMap<&str, Beginning>) -> Beginning {
    match expression {
        OptimizedExpr::Str(text) => Beginning::one_of(|byte| text.as_bytes()[0] == byte),
        OptimizedExpr::Insens(text) => {
            Beginning::one_of(|byte| text.as_bytes()[0].eq_ignore_ascii_case(&byte))
        }
        OptimizedExpr::Ident(name) => match name.as_str() {
            "ANY" => Beginning::one_of(|_| true),
            "SOI" | "EOI" => Beginning::NOTHING,
            "NEWLINE" => Beginning::one_of(|byte| matches!(byte, b'\n' | b'\r')),
            "ASCII_DIGIT" => Beginning::one_of(|byte| byte.is_ascii_digit()),
            "ASCII_HEX_DIGIT" => Beginning::one_of(|byte| byte.is_ascii_hexdigit()),
            "ASCII_ALPHA" => Beginning::one_of(|byte| byte.is_ascii_alphabetic()),
            "ASCII_ALPHANUMERIC" => Beginning::one_of(|byte| byte.is_ascii_alphanumeric()),
            name => *known.get(name).unwrap_or_else(|| panic!("`{name}` is a rule")),
        },
        // What only looks ahead takes nothing: what follows it says more.
        OptimizedExpr::PosPred(_) | OptimizedExpr::NegPred(_) => Beginning::NOTHING,
        OptimizedExpr::Seq(one, other) => match beginning(one, known) {
            // What is skipped between the two may come first.
            one if one.empty => {
                let skipped = known["WHITESPACE"].or(known["COMMENT"]);
                let other = beginning(other, known);
                let all = one.or(skipped).or(other);
                Beginning { empty: other.empty, ..all }
            }
            one => one,
        },
        OptimizedExpr::Choice(one, other) => beginning(one, known).or(beginning(other, known)),
        OptimizedExpr::Opt(inner) | OptimizedExpr::Rep(inner) => {
            beginning(inner, known).or(Beginning::NOTHING)
        }
        OptimizedExpr::RestoreOnErr(inner) => beginning(inner, known),
        other => panic!("the reader knows nothing of {other:?}"),
    }
}

/// The functions of all rules, and the one that finds them.
fn reader(rules: &[OptimizedRule]) -> String {
    let mut made = Made { beginnings: beginnings(rules), labels: 0 };
    let mut out = String::new();
    for rule in rules {
        let name = &rule.name;
        let is_atomic = match rule.ty {
            RuleType::Normal | RuleType::Silent => matches!(name.as_str(), "WHITESPACE" | "COMMENT"),
            RuleType::Atomic => true,
            other => panic!("the reader knows nothing of {other:?} as `{name}` is"),
        };
        let within = if is_atomic { Within::ATOMIC } else { Within { quiet: "QUIET", atomic: "ATOMIC" } };
        let body = made.code(&rule.expr, within);
        let body = match rule.ty {
            RuleType::Silent => body,
            _ => format!("reader.rule::<QUIET>(Rule::r#{name}, at, |reader| {body})"),
        };
        out += &format!(
            "fn r#{name}<const QUIET: bool, const ATOMIC: bool>(reader: &mut Reader, at: usize) -> Option<usize> {{ {body} }}\n"
        );
    }
    out += "fn skip(reader: &mut Reader, mut at: usize) -> usize { loop { ";
    out += "while let Some(end) = r#WHITESPACE::<true, true>(reader, at) { at = end; } ";
    out += "match r#COMMENT::<true, true>(reader, at) { Some(end) => at = end, None => return at } } }\n";
    let told = rules.iter().filter(|rule| rule.ty != RuleType::Silent);
    let begin =
        |rule: &OptimizedRule| format!("Rule::r#{0} => r#{0}::<false, false>(reader, 0), ", rule.name);
    let begin: String = told.map(begin).collect();
    out += &format!(
        "pub fn begin(rule: Rule, reader: &mut Reader) -> Option<usize> {{ match rule {{ {begin} _ => None }} }}\n"
    );
    out
}

/// Where an expression stands: whether nothing is told of its rules, and whether nothing is skipped between its parts; as code.
#[derive(Clone, Copy)]
struct Within {
    quiet: &'static str,
    atomic: &'static str,
}

impl Within {
    const ATOMIC: Self = Self { quiet: "true", atomic: "true" };
}

struct Made<'r> {
    beginnings: HashMap<&'r str, Beginning>,
    labels: usize,
}

impl Made<'_> {
    /// What gives the end of what the expression describes from `at` on, if it describes anything. Where it does not, as many rules
    /// are told of as before.
    fn code(&mut self, expression: &OptimizedExpr, within: Within) -> String {
        let Within { quiet, atomic } = within;
        match expression {
            OptimizedExpr::Str(text) => format!("reader.exactly(at, {:?})", bytes(text)),
            OptimizedExpr::Insens(text) => format!("reader.in_any_case(at, {:?})", bytes(text)),
            OptimizedExpr::Ident(name) => match name.as_str() {
                "ANY" => "reader.any(at)".to_string(),
                "SOI" => "(at == 0).then_some(at)".to_string(),
                "EOI" => "reader.end(at)".to_string(),
                "NEWLINE" => "reader.newline(at)".to_string(),
                "ASCII_DIGIT" => "reader.one(at, |byte| byte.is_ascii_digit())".to_string(),
                "ASCII_HEX_DIGIT" => "reader.one(at, |byte| byte.is_ascii_hexdigit())".to_string(),
                "ASCII_ALPHA" => "reader.one(at, |byte| byte.is_ascii_alphabetic())".to_string(),
                "ASCII_ALPHANUMERIC" => "reader.one(at, |byte| byte.is_ascii_alphanumeric())".to_string(),
                name => format!("r#{name}::<{quiet}, {atomic}>(reader, at)"),
            },
            OptimizedExpr::PosPred(inner) => {
                let inner = self.code(inner, Within { quiet: "true", atomic });
                format!("({inner}).map(|_| at)")
            }
            OptimizedExpr::NegPred(inner) => {
                let inner = self.code(inner, Within { quiet: "true", atomic });
                format!("match ({inner}) {{ Some(_) => None, None => Some(at) }}")
            }
            OptimizedExpr::Seq(..) => {
                let label = self.label();
                let part = |part| {
                    let part = self.code(part, within);
                    format!("let Some(at) = ({part}) else {{ reader.forget(told); break '{label} None }}; ")
                };
                let parts: Vec<String> = parts(expression).into_iter().map(part).collect();
                let parts =
                    parts.join(&format!("let at = if {atomic} {{ at }} else {{ skip(reader, at) }}; "));
                format!("'{label}: {{ let told = reader.told(); {parts} Some(at) }}")
            }
            OptimizedExpr::Choice(..) => {
                let label = self.label();
                let part = |part| {
                    let part = self.guarded(part, within);
                    format!("if let Some(end) = {part} {{ break '{label} Some(end) }} ")
                };
                let parts: String = parts(expression).into_iter().map(part).collect();
                format!("'{label}: {{ {parts} None }}")
            }
            OptimizedExpr::Opt(inner) => {
                let inner = self.guarded(inner, within);
                format!("{inner}.or(Some(at))")
            }
            OptimizedExpr::Rep(inner) => {
                let inner = self.guarded(inner, within);
                format!(
                    "{{ let (mut at, mut end) = (at, at); while let Some(next) = {inner} {{ end = next; at = if {atomic} {{ end }} else {{ skip(reader, end) }}; }} Some(end) }}"
                )
            }
            OptimizedExpr::RestoreOnErr(inner) => self.code(inner, within),
            other => panic!("the reader knows nothing of {other:?}"),
        }
    }

    /// As [`Self::code`], tried only where the text begins like it.
    fn guarded(&mut self, expression: &OptimizedExpr, within: Within) -> String {
        let begins = beginning(expression, &self.beginnings);
        let code = self.code(expression, within);
        if begins.empty {
            return format!("({{ {code} }})");
        }
        format!("(if matches!(reader.next(at), Some({})) {{ {code} }} else {{ None }})", begins.pattern())
    }

    fn label(&mut self) -> String {
        self.labels += 1;
        format!("l{}", self.labels)
    }
}

/// Of a sequence or a choice, what is in it one after the other.
fn parts(expression: &OptimizedExpr) -> Vec<&OptimizedExpr> {
    let (mut parts, mut rest) = (Vec::new(), expression);
    while let OptimizedExpr::Seq(one, other) | OptimizedExpr::Choice(one, other) = rest
        && discriminant(rest) == discriminant(expression)
    {
        parts.push(&**one);
        rest = other;
    }
    parts.push(rest);
    parts
}

fn bytes(text: &str) -> &[u8] {
    text.as_bytes()
}
