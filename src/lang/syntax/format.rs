//! The one style of scenario files. Comments stay, and formatting twice changes nothing.
//!
//! A block that is written in one line stays in one line; every other statement gets a line of its own, indented by
//! two spaces a level. Line breaks inside brackets stay where they are.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::ast::{self, View};
use super::lexer::TokenKind;
use super::tree::{Node, Rule, Tree};
use crate::diagnostic::Diagnostic;
use crate::source::SourceId;

const INDENT: &str = "  ";

/// The text in the one style, or why it does not parse.
pub fn format(source: SourceId, text: &str) -> Result<String, Vec<Diagnostic>> {
    let (tree, diagnostics) = Tree::parse(source, Arc::from(text));
    if diagnostics.is_empty() { Ok(format_tree(&tree)) } else { Err(diagnostics) }
}

/// A node in the one style in one line, without comments.
pub fn phrase(node: Node) -> String {
    // Everything counts as the inside of a bracket, where lines break only as in the source.
    let mut printer = Printer { frames: vec![Frame::Bracket], ..Printer::default() };
    for mut atom in atoms(node) {
        if atom.kind != AtomKind::Comment {
            atom.newlines = 0;
            printer.print(&atom);
        }
    }
    printer.out.trim().to_string()
}

/// Something that is printed without anything inside it being touched.
struct Atom {
    text: String,
    kind: AtomKind,
    /// Line ends in the source between the one before and this.
    newlines: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AtomKind {
    Word,
    Negation,
    /// Of a calculation or comparison, after which a line may end.
    Operator,
    Comment,
    /// `{`; written in one line up to its partner, and whether it holds settings.
    OpenBrace {
        inline: bool,
        settings: bool,
    },
    CloseBrace,
    /// `(` or `[`; of a group, which is no call.
    OpenBracket {
        group: bool,
    },
    CloseBracket,
    Comma,
    Semicolon,
    /// Of `a : base`, with space before it.
    Colon {
        base: bool,
    },
    Dot,
    DotDot,
}

fn is_leaf(rule: Rule) -> bool {
    use Rule::{
        boolean, distribution_name, integer, name, negation, number, operator, reference, setting_name,
        signal, string, tag, unit,
    };
    matches!(
        rule,
        boolean
            | distribution_name
            | integer
            | name
            | negation
            | number
            | operator
            | reference
            | setting_name
            | signal
            | string
            | tag
            | unit
    ) || rule == Rule::relation
        || format!("{rule:?}").starts_with("kw_")
}

fn atoms(of: Node) -> Vec<Atom> {
    let tree = of.tree();
    let text = tree.text();
    let mut leaves: HashMap<usize, (usize, Rule, String)> = HashMap::new();
    let mut settings: HashSet<usize> = HashSet::new();
    let mut groups: HashSet<usize> = HashSet::new();
    let mut bases: HashSet<usize> = HashSet::new();
    for node in of.descendants() {
        let span = node.span();
        match node.rule() {
            Rule::settings | Rule::parameter_set | Rule::weights_block => _ = settings.insert(span.start),
            Rule::base => _ = bases.insert(span.start),
            Rule::group | Rule::claimed_group => _ = groups.insert(span.start),
            Rule::relation => {
                let meaning = ast::Relation::cast(node).map(ast::Relation::meaning);
                let symbol = meaning.map_or(String::new(), |relation| relation.symbol().to_string());
                leaves.insert(span.start, (span.end, Rule::relation, symbol));
            }
            rule if is_leaf(rule) => {
                leaves.entry(span.start).or_insert_with(|| (span.end, rule, node.text().to_string()));
            }
            _ => {}
        }
    }
    let mut atoms = Vec::new();
    let mut newlines = 0;
    let span = of.span();
    let mut skip_to = 0;
    let first = tree.tokens().partition_point(|token| token.start < span.start);
    for (index, token) in tree.tokens().iter().enumerate().skip(first) {
        if token.start >= span.end {
            break;
        }
        // A leaf may end inside a token, such as the number of `1e3s`, whose unit is the rest of the word `e3s`.
        let mut start = token.start.max(skip_to);
        while let Some((end, rule, text)) = leaves.get(&start).filter(|_| start < token.end) {
            let kind = match rule {
                Rule::negation => AtomKind::Negation,
                Rule::operator | Rule::relation => AtomKind::Operator,
                _ => AtomKind::Word,
            };
            atoms.push(Atom { text: text.clone(), kind, newlines: std::mem::take(&mut newlines) });
            start = *end;
        }
        skip_to = start;
        if start >= token.end {
            continue;
        }
        let written = &text[start..token.end];
        let kind = match (token.kind, written) {
            (TokenKind::Space, _) => continue,
            (TokenKind::Newline, _) => {
                newlines += 1;
                continue;
            }
            (TokenKind::Comment, _) => AtomKind::Comment,
            (_, "{") => AtomKind::OpenBrace {
                inline: is_inline(tree, index),
                settings: settings.contains(&token.start),
            },
            (_, "}") => AtomKind::CloseBrace,
            (_, "(" | "[") => {
                AtomKind::OpenBracket { group: written == "[" || groups.contains(&token.start) }
            }
            (_, ")" | "]") => AtomKind::CloseBracket,
            (_, ",") => AtomKind::Comma,
            (_, ";") => AtomKind::Semicolon,
            (_, ":") => AtomKind::Colon { base: bases.contains(&token.start) },
            (_, ".") if text[token.end..].starts_with('.') => {
                skip_to = token.end + 1;
                AtomKind::DotDot
            }
            (_, ".") => AtomKind::Dot,
            _ => AtomKind::Word,
        };
        let text = if kind == AtomKind::DotDot { ".." } else { written.trim_end() };
        atoms.push(Atom { text: text.to_string(), kind, newlines: std::mem::take(&mut newlines) });
    }
    atoms
}

/// Whether the bracket that opens at a token closes in the same line.
fn is_inline(tree: &Tree, open: usize) -> bool {
    let mut depth = 0;
    for token in &tree.tokens()[open..] {
        match token.kind {
            TokenKind::Open => depth += 1,
            TokenKind::Close => depth -= 1,
            TokenKind::Newline => return false,
            _ => {}
        }
        if depth == 0 {
            return true;
        }
    }
    false
}

/// What is open around a place.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Frame {
    Block { settings: bool },
    Inline { settings: bool },
    Bracket,
}

#[derive(Default)]
struct Printer {
    out: String,
    frames: Vec<Frame>,
    /// Whether something is in the current line already.
    in_line: bool,
    before: Option<AtomKind>,
    /// A separator that is printed only if another statement follows in the line.
    pending: Option<&'static str>,
}

fn format_tree(tree: &Tree) -> String {
    let mut printer = Printer::default();
    for atom in atoms(tree.root()) {
        printer.print(&atom);
    }
    if printer.in_line {
        printer.out.push('\n');
    }
    printer.out
}

impl Printer {
    fn print(&mut self, atom: &Atom) {
        let frame = self.frame();
        match (atom.kind, frame) {
            (AtomKind::Comment, _) => return self.comment(atom),
            (AtomKind::Semicolon, Frame::Block { .. }) => return self.separate(""),
            (AtomKind::Comma, Frame::Block { settings: true }) => return self.separate(""),
            (AtomKind::Semicolon, Frame::Inline { settings: false }) => return self.separate(";"),
            (AtomKind::Semicolon | AtomKind::Comma, Frame::Inline { settings: true }) => {
                return self.separate(",");
            }
            _ => {}
        }
        if atom.kind == AtomKind::CloseBrace {
            return self.close_brace(frame);
        }
        self.begin(atom, frame);
        if atom.kind == AtomKind::CloseBracket {
            self.frames.pop();
        }
        self.out.push_str(&atom.text);
        self.in_line = true;
        self.before = Some(atom.kind);
        match atom.kind {
            AtomKind::OpenBrace { inline, settings } => {
                self.frames.push(if inline { Frame::Inline { settings } } else { Frame::Block { settings } });
            }
            AtomKind::OpenBracket { .. } => self.frames.push(Frame::Bracket),
            _ => {}
        }
    }

    /// Line ends, indentation or space before an atom.
    fn begin(&mut self, atom: &Atom, frame: Frame) {
        let continues = self.continues(frame);
        if let Some(separator) = self.pending.take() {
            self.out.push_str(separator);
            if separator.is_empty() {
                self.end_line();
            }
        } else if self.in_line && matches!(frame, Frame::Block { .. }) {
            if atom.newlines > 0 || matches!(self.before, Some(AtomKind::OpenBrace { .. })) {
                self.end_line();
            }
        } else if self.in_line && frame == Frame::Bracket && atom.newlines > 0 {
            self.end_line();
        }
        if !self.in_line {
            if atom.newlines > 1
                && !continues
                && !matches!(self.before, None | Some(AtomKind::OpenBrace { .. }))
                && frame != Frame::Bracket
            {
                self.out.push('\n');
            }
            self.indent(usize::from(continues), usize::from(atom.kind == AtomKind::CloseBracket));
        } else if self.spaced(atom) {
            self.out.push(' ');
        }
    }

    /// What is open here; a file is a block.
    fn frame(&self) -> Frame {
        self.frames.last().copied().unwrap_or(Frame::Block { settings: false })
    }

    /// Whether what comes next belongs to the statement of the line before, which ended after a comma or operator.
    fn continues(&self, frame: Frame) -> bool {
        matches!(frame, Frame::Block { .. })
            && matches!(self.before, Some(AtomKind::Comma | AtomKind::Operator))
    }

    fn indent(&mut self, more: usize, less: usize) {
        let depth = self.frames.iter().filter(|frame| !matches!(frame, Frame::Inline { .. })).count();
        self.out.push_str(&INDENT.repeat(depth + more - less));
    }

    fn end_line(&mut self) {
        self.out.push('\n');
        self.in_line = false;
    }

    fn separate(&mut self, separator: &'static str) {
        if self.in_line && !matches!(self.before, Some(AtomKind::OpenBrace { .. })) {
            self.pending = Some(separator);
        }
    }

    fn close_brace(&mut self, frame: Frame) {
        self.pending = None;
        let empty = matches!(self.before, Some(AtomKind::OpenBrace { .. })) && self.in_line;
        self.frames.pop();
        match frame {
            Frame::Inline { .. } => self.out.push_str(" }"),
            _ if empty => self.out.push_str(" }"),
            _ => {
                if self.in_line {
                    self.end_line();
                }
                self.indent(0, 0);
                self.out.push('}');
            }
        }
        self.in_line = true;
        self.before = Some(AtomKind::CloseBrace);
    }

    /// A comment ends its line; one that began a line keeps a line of its own.
    fn comment(&mut self, atom: &Atom) {
        let trailing = atom.newlines == 0 && self.in_line;
        match self.pending.take() {
            Some(separator) if !separator.is_empty() && self.frames.last() == Some(&Frame::Bracket) => {
                self.out.push_str(separator);
            }
            _ => {}
        }
        if trailing {
            self.out.push_str("  ");
        } else {
            if self.in_line {
                self.end_line();
            }
            let frame = self.frame();
            let continues = self.continues(frame);
            if atom.newlines > 1
                && !continues
                && !matches!(self.before, None | Some(AtomKind::OpenBrace { .. }))
            {
                self.out.push('\n');
            }
            self.indent(usize::from(continues), 0);
        }
        self.out.push_str(&atom.text);
        self.end_line();
        if self.before.is_none() || matches!(self.before, Some(AtomKind::OpenBrace { .. })) {
            // Blank lines after it count again.
            self.before = Some(AtomKind::Comment);
        }
    }

    fn spaced(&self, atom: &Atom) -> bool {
        let Some(before) = self.before else { return false };
        if matches!(before, AtomKind::Negation | AtomKind::Dot | AtomKind::OpenBracket { .. }) {
            return false;
        }
        match atom.kind {
            AtomKind::Comma | AtomKind::Semicolon | AtomKind::CloseBracket | AtomKind::Dot => false,
            AtomKind::OpenBracket { group } => group,
            AtomKind::Colon { base } => base,
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sources;

    fn formatted(text: &str) -> String {
        format(Sources::default().add("test.scn", ""), text).unwrap()
    }

    #[test]
    fn continued_statements_are_indented_past_comments_and_without_blank_lines() {
        let text = "suite a {\n  scenarios \"a\",\n\n\n  \"b\", # x\n\n  # y\n\n  \"c\" # z\n\n  seed 3\n}\n\
                    statement s {\n claim mean(pet) of a >\n\n mean(pet) of b\n}\n";
        let once = formatted(text);
        insta::assert_snapshot!(once, @r#"
        suite a {
          scenarios "a",
            "b",  # x
            # y
            "c"  # z

          seed 3
        }
        statement s {
          claim mean(pet) of a >
            mean(pet) of b
        }
        "#);
        assert_eq!(formatted(&once), once);
    }

    #[test]
    fn there_is_one_style() {
        let untidy = "# first\n\n\nuse   \"a.scn\";let x=-( 1+2 )*3km/h   # why\nscenario a:base( t : 2s ){\n\n\n \
                      vehicle av{controller c{profile:normal,gap:5m};speed 30km/h}\n# own line\n   expect\t{\n\
                      no collision;pet>=1.5s in 80% of runs\n\n\n\nrate( max_deceleration≥2m/s^2 )<20%\n\n}\n vary t in[1s,2 s,\n\
                      3s]\n  vary u in 1s..3s step 1s\n controller { a: 1\n b : 2, c:3 }\n} \n\n\n";
        // `controller` is no statement of a scenario, so that line goes.
        let untidy = untidy.replace(" controller { a: 1\n b : 2, c:3 }\n", "");
        insta::assert_snapshot!(formatted(&untidy), @r#"
        # first

        use "a.scn"
        let x = -(1 + 2) * 3 km/h  # why
        scenario a : base(t: 2 s) {
          vehicle av { controller c { profile: normal, gap: 5 m }; speed 30 km/h }
          # own line
          expect {
            no collision
            pet >= 1.5 s in 80 % of runs

            rate(max_deceleration >= 2 m/s^2) < 20 %
          }
          vary t in [1 s, 2 s,
            3 s]
          vary u in 1 s .. 3 s step 1 s
        }
        "#);
    }

    #[test]
    fn blocks_over_several_lines_keep_their_comments() {
        let text = "scenario a { # one\n  # two\n\n  vehicle av { # three\n    controller c {\n profile: normal, # four\n\n      \
                    gap: 5 m }\n    # five\n  }\n  vary t in [ # six\n    1 s, # seven\n    2 s\n  ]\n} # eight\n# nine\n";
        insta::assert_snapshot!(formatted(text), @r"
        scenario a {  # one
          # two

          vehicle av {  # three
            controller c {
              profile: normal  # four

              gap: 5 m
            }
            # five
          }
          vary t in [  # six
            1 s,  # seven
            2 s
          ]
        }  # eight
        # nine
        ");
    }

    #[test]
    fn a_unit_without_space_stays() {
        assert_eq!(formatted("let a=1e3m/s+6s*2E-1µm"), "let a = 1e3 m/s + 6 s * 2E-1 µm\n");
    }

    #[test]
    fn a_byte_order_mark_goes() {
        assert_eq!(formatted("\u{feff} let a=1 m"), "let a = 1 m\n");
        assert!(format(Sources::default().add("test.scn", ""), " \u{feff}").is_err(), "it is none elsewhere");
    }

    #[test]
    fn what_does_not_parse_is_left_alone() {
        assert!(format(Sources::default().add("test.scn", ""), "scenario {").is_err());
    }
}
