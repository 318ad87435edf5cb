//! YAML to the text of a scenario file.

use super::document::{Content, Yaml, read};
use super::{Piece, TranslatedPlaces};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::SourceId;
use crate::syntax::words::{BlockKind, StatementEntry, YamlShape};
use crate::syntax::{self, TokenKind};

/// The text of a scenario file that says what a YAML file says.
#[derive(Debug, Clone)]
pub struct Translation {
    pub text: String,
    pub places: TranslatedPlaces,
}

/// Translates the YAML `text` of `source`; findings are about the YAML.
pub fn to_scn(source: SourceId, text: &str) -> Result<Translation, Vec<Diagnostic>> {
    let document = read(source, text).map_err(|diagnostic| vec![*diagnostic])?;
    let mut writer = Writer {
        source,
        yaml: text,
        text: String::new(),
        places: TranslatedPlaces::default(),
        report: Vec::new(),
        depth: 0,
    };
    writer.block(&document, BlockKind::File, "a file");
    if writer.report.is_empty() {
        Ok(Translation { text: writer.text, places: writer.places })
    } else {
        Err(writer.report)
    }
}

struct Writer<'a> {
    source: SourceId,
    yaml: &'a str,
    text: String,
    places: TranslatedPlaces,
    report: Vec<Diagnostic>,
    depth: usize,
}

impl Writer<'_> {
    fn wrong(&mut self, value: &Yaml, message: impl Into<String>, hint: impl Into<String>) {
        self.report.push(
            Diagnostic::new(Code::WrongShape, value.span(self.source), message)
                .label("not understood")
                .hint(hint),
        );
    }

    /// Text that came from `value`.
    fn from(&mut self, value: &Yaml, text: &str) {
        let start = self.text.len();
        self.text.push_str(text);
        let verbatim = self.yaml.get(value.start..value.end) == Some(text);
        let piece = Piece { start, end: self.text.len(), from: value.start, to: value.end, verbatim };
        self.places.pieces.push(piece);
    }

    fn line(&mut self) {
        self.text.push('\n');
        let indentation = "  ".repeat(self.depth);
        self.text.push_str(&indentation);
    }

    /// A name that can stand in a scenario file.
    fn name(&mut self, value: &Yaml) {
        let name = value.scalar().unwrap_or_default();
        let fits =
            name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '.')) && !name.is_empty();
        if fits {
            self.from(value, name);
        } else {
            self.wrong(value, format!("`{name}` is no name"), "names are made of letters, digits and `_`");
        }
    }

    /// Words of the language as they are.
    fn words(&mut self, value: &Yaml) {
        let Some(words) = value.scalar() else {
            return self.wrong(
                value,
                "words are needed here",
                "write it as in a scenario file, such as `30 km/h`",
            );
        };
        let tokens = syntax::fragment(words);
        let forbidden = tokens.iter().any(|token| {
            matches!(token.kind, TokenKind::Comment | TokenKind::Newline | TokenKind::OpenString)
                || matches!(&words[token.start..token.end], "{" | "}" | ";")
        });
        if forbidden || !syntax::balance(self.source, words, &tokens).is_empty() {
            let shown: String = words.chars().take(40).collect();
            return self.wrong(
                value,
                format!("`{shown}` cannot stand in a statement"),
                "write only what follows the key",
            );
        }
        self.from(value, words);
    }

    fn quoted(&mut self, value: &Yaml) {
        let Some(text) = value.scalar() else {
            return self.wrong(value, "a text is needed here", "write it in quotes");
        };
        let escaped =
            text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n").replace('\t', "\\t");
        self.text.push('"');
        let escaped: String = escaped.chars().filter(|c| !c.is_control()).collect();
        self.from(value, &escaped);
        self.text.push('"');
    }

    fn fields<'y>(&mut self, value: &'y Yaml, what: &str) -> &'y [(Yaml, Yaml)] {
        match &value.value {
            Content::Mapping(fields) => fields,
            // `vehicles:` with nothing below it.
            Content::Scalar(text) if text.is_empty() || text == "~" || text == "null" => &[],
            _ => {
                self.wrong(value, format!("{what} is made of keys"), "write `key: value` lines below it");
                &[]
            }
        }
    }

    fn block(&mut self, value: &Yaml, kind: BlockKind, what: &str) {
        for (name, value) in self.fields(value, what) {
            let word = name.scalar().unwrap_or_default();
            match kind.block().keys().find(|statement| statement.key == word) {
                Some(key) => self.statement(name, value, key),
                None => {
                    let known = kind.block().keys().map(|statement| statement.key);
                    self.report.push(
                        Diagnostic::new(
                            Code::UnknownKey,
                            name.span(self.source),
                            format!("{what} has no key `{word}`"),
                        )
                        .label("unknown here")
                        .suggest(word, known),
                    );
                }
            }
        }
    }

    /// `keyword` and what `rest` writes, as a line of its own.
    fn said(&mut self, key: &Yaml, keyword: &str, rest: impl FnOnce(&mut Self)) {
        self.line();
        if !keyword.is_empty() {
            self.from(key, keyword);
            self.text.push(' ');
        }
        rest(self);
    }

    fn braces(&mut self, inside: impl FnOnce(&mut Self)) {
        self.text.push_str(" {");
        self.depth += 1;
        inside(self);
        self.depth -= 1;
        self.line();
        self.text.push('}');
    }

    fn each(value: &Yaml) -> &[Yaml] {
        match &value.value {
            Content::List(items) => items,
            _ => std::slice::from_ref(value),
        }
    }

    fn statement(&mut self, name: &Yaml, value: &Yaml, statement: &StatementEntry) {
        let (keyword, key) = (statement.words, statement.key);
        match statement.shape {
            YamlShape::Words | YamlShape::Lines => {
                for item in Self::each(value) {
                    self.said(name, keyword, |writer| writer.words(item));
                }
            }
            YamlShape::Text => {
                for item in Self::each(value) {
                    self.said(name, keyword, |writer| writer.quoted(item));
                }
            }
            YamlShape::Table => {
                for item in Self::each(value) {
                    self.said(name, keyword, |writer| writer.table(item));
                }
            }
            YamlShape::Texts => self.said(name, keyword, |writer| {
                for (index, item) in Self::each(value).iter().enumerate() {
                    if index > 0 {
                        writer.text.push_str(", ");
                    }
                    writer.quoted(item);
                }
            }),
            YamlShape::OwnParameters => {
                for (parameter, value) in self.fields(value, &format!("`{key}`")) {
                    self.said(name, keyword, |writer| writer.own_parameter(parameter, value));
                }
            }
            YamlShape::Commas => self.said(name, keyword, |writer| writer.separated(value)),
            YamlShape::Named => {
                let Some(kind) = statement.opens else { return };
                for (user, block) in self.fields(value, &format!("`{key}`")) {
                    self.said(name, keyword, |writer| {
                        writer.name(user);
                        match kind {
                            BlockKind::Scenario => writer.head(block),
                            BlockKind::Pedestrian => writer.group_size(block),
                            _ => {}
                        }
                        writer.braces(|writer| writer.block(block, kind, &format!("a `{keyword}`")));
                    });
                }
            }
            YamlShape::NameOrBlock => {
                self.said(name, keyword, |writer| match (&value.value, statement.opens) {
                    (Content::Mapping(_), Some(kind)) => {
                        writer.braces(|writer| writer.block(value, kind, &format!("a `{keyword}`")))
                    }
                    _ => writer.words(value),
                })
            }
            YamlShape::Statements if keyword.is_empty() => {
                for item in Self::each(value) {
                    self.said(name, "", |writer| writer.words(item));
                }
            }
            YamlShape::Statements => self.said(name, keyword, |writer| {
                writer.braces(|writer| {
                    for item in Self::each(value) {
                        writer.said(name, "", |writer| writer.words_or_settings(item));
                    }
                });
            }),
            YamlShape::Model => self.said(name, keyword, |writer| writer.model(value)),
            YamlShape::Tested => {
                for (vehicle, tested) in self.fields(value, &format!("`{key}`")) {
                    self.said(name, keyword, |writer| {
                        writer.model(tested);
                        writer.text.push_str(" as ");
                        // `av where present`
                        match vehicle.scalar() {
                            Some(words) if words.contains(' ') => writer.words(vehicle),
                            _ => writer.name(vehicle),
                        }
                    });
                }
            }
            YamlShape::NamedModels => {
                for (user, model) in self.fields(value, &format!("`{key}`")) {
                    self.said(name, keyword, |writer| {
                        writer.name(user);
                        writer.text.push(' ');
                        writer.model(model);
                    });
                }
            }
            YamlShape::NamedSettings => {
                for (user, settings) in self.fields(value, &format!("`{key}`")) {
                    self.said(name, keyword, |writer| {
                        writer.name(user);
                        writer.settings(settings);
                    });
                }
            }
            YamlShape::Settings => self.said(name, keyword, |writer| writer.settings(value)),
            YamlShape::Values => {
                for (varied, values) in self.fields(value, &format!("`{key}`")) {
                    self.said(name, keyword, |writer| writer.varied(varied, values));
                }
            }
            YamlShape::Drawn => {
                for (drawn, from) in self.fields(value, &format!("`{key}`")) {
                    self.said(name, keyword, |writer| {
                        writer.name(drawn);
                        writer.text.push_str(" from ");
                        match &from.value {
                            Content::Mapping(fields) => match fields.as_slice() {
                                [(file, path)] if file.scalar() == Some("file") => writer.quoted(path),
                                _ => writer.wrong(
                                    from,
                                    "draws come from a distribution or a file",
                                    "write `normal(5 m, 1 m)` or `{ file: gaps.csv }`",
                                ),
                            },
                            _ => writer.words(from),
                        }
                    });
                }
            }
            YamlShape::Together => {
                for group in Self::each(value) {
                    self.said(name, keyword, |writer| writer.together(group));
                }
            }
            YamlShape::Bindings => {
                for (bound, expression) in self.fields(value, "`let`") {
                    self.said(name, keyword, |writer| {
                        writer.name(bound);
                        writer.text.push_str(" = ");
                        writer.words(expression);
                    });
                }
            }
            YamlShape::Flag | YamlShape::NotFlag => {
                let wanted = statement.shape == YamlShape::Flag;
                match value.scalar() {
                    Some("true") if wanted => self.said(name, keyword, |_| {}),
                    Some("false") if !wanted => self.said(name, keyword, |_| {}),
                    Some("true" | "false") => {}
                    _ => self.wrong(value, format!("`{key}` is true or false"), "write `true` or `false`"),
                }
            }
            YamlShape::Cases => self.said(name, keyword, |writer| match &value.value {
                Content::Mapping(fields) => match fields.as_slice() {
                    [(file, path)] if file.scalar() == Some("file") => writer.quoted(path),
                    _ => writer.wrong(
                        value,
                        "cases come from a name or a file",
                        "write `{ file: cases.json }`",
                    ),
                },
                _ => writer.words(value),
            }),
            YamlShape::Conditions => self.said(name, keyword, |writer| {
                for (index, item) in Self::each(value).iter().enumerate() {
                    if index > 0 {
                        writer.text.push_str(", ");
                    }
                    writer.condition(item);
                }
            }),
            YamlShape::ParameterSets => {
                for item in Self::each(value) {
                    self.said(name, keyword, |writer| writer.settings(item));
                }
            }
            YamlShape::Rows => {
                for (condition, values) in self.fields(value, &format!("`{key}`")) {
                    self.said(name, keyword, |writer| {
                        writer.name(condition);
                        writer.text.push_str(": ");
                        writer.separated(values);
                    });
                }
            }
            YamlShape::Weights => {
                for item in Self::each(value) {
                    self.said(name, keyword, |writer| writer.weights(item));
                }
            }
            YamlShape::Base | YamlShape::Parameters | YamlShape::GroupSize => {}
        }
    }

    /// `{ when: speed = 30 km/h, "0 km/h": 1, "below 10 km/h": 0.25 }`
    fn weights(&mut self, value: &Yaml) {
        let fields = self.fields(value, "a table of weights");
        let is_when = |(key, _): &&(Yaml, Yaml)| key.scalar() == Some("when");
        if let Some((_, when)) = fields.iter().find(is_when) {
            self.text.push_str("when ");
            self.words(when);
            self.text.push(' ');
        }
        self.text.push('{');
        for (index, (of, weight)) in fields.iter().filter(|field| !is_when(field)).enumerate() {
            self.text.push_str(if index == 0 { " " } else { ", " });
            self.words(of);
            self.text.push_str(": ");
            self.words(weight);
        }
        self.text.push_str(" }");
    }

    /// `exposure.csv`, or `{ file: exposure.csv, without: [id, date] }`
    fn table(&mut self, value: &Yaml) {
        let Content::Mapping(fields) = &value.value else { return self.quoted(value) };
        match fields.as_slice() {
            [(file, path), (without, names)]
                if file.scalar() == Some("file") && without.scalar() == Some("without") =>
            {
                if matches!(&names.value, Content::List(names) if names.is_empty()) {
                    self.wrong(
                        names,
                        "no column is left out",
                        "name one, or write the file alone: `exposure.csv`",
                    );
                }
                self.quoted(path);
                self.text.push_str(" without ");
                self.separated(names);
            }
            _ => self.wrong(
                value,
                "a table is a file, perhaps without some of its columns",
                "write `exposure.csv` or `{ file: exposure.csv, without: [id, date] }`",
            ),
        }
    }

    /// `name`, or `name: { setting: value }`
    fn model(&mut self, value: &Yaml) {
        match &value.value {
            Content::Mapping(fields) => match fields.as_slice() {
                [(model, settings)] => {
                    self.name(model);
                    self.settings(settings);
                }
                _ => self.wrong(value, "one name is needed here", "write `name: { setting: value }`"),
            },
            _ => self.words(value),
        }
    }

    /// Words, or `words: { setting: value }`
    fn words_or_settings(&mut self, value: &Yaml) {
        match &value.value {
            Content::Mapping(fields) => match fields.as_slice() {
                [(words, settings)] => {
                    self.words(words);
                    self.settings(settings);
                }
                _ => {
                    self.wrong(value, "words alone are needed here", "write `turn left: { setting: value }`")
                }
            },
            _ => self.words(value),
        }
    }

    /// `name`, `name as other`, `{ file: PATH, as: NAME }` or `{ set: { parameter: value }, as: NAME }`
    fn condition(&mut self, value: &Yaml) {
        let Content::Mapping(fields) = &value.value else { return self.words(value) };
        let field = |wanted: &str| fields.iter().find(|(key, _)| key.scalar() == Some(wanted));
        match (field("file"), field("set"), fields.len()) {
            (Some((_, path)), None, 1 | 2) => self.quoted(path),
            (None, Some((_, set)), 1 | 2) => self.settings(set),
            _ => {
                return self.wrong(
                    value,
                    "a condition is a name, a file or a set of parameters",
                    "write `{ set: { av.controller.braking_distance: 10 m }, as: ten }`",
                );
            }
        }
        match field("as") {
            Some((_, alias)) => {
                self.text.push_str(" as ");
                self.name(alias);
            }
            None if fields.len() == 2 => {
                self.wrong(value, "a condition has no other key than `as`", "write `as: NAME`");
            }
            None => {}
        }
    }

    fn separated(&mut self, value: &Yaml) {
        let mut before = None;
        for item in Self::each(value) {
            // Where a comma may have been meant as a decimal point it is seen by the space behind it.
            if let Some(end) = before.replace(item.end) {
                let is_tight = self.yaml.get(end..item.start) == Some(",");
                self.text.push_str(if is_tight { "," } else { ", " });
            }
            self.words(item);
        }
    }

    /// `parameters` and `extends`, which stand before the block in this order.
    fn head(&mut self, block: &Yaml) {
        let Content::Mapping(fields) = &block.value else { return };
        let mut fields: Vec<_> = fields.iter().collect();
        fields.sort_by_key(|(key, _)| key.scalar() == Some("extends"));
        for (key, value) in fields {
            match key.scalar() {
                Some("extends") => {
                    self.text.push_str(" : ");
                    self.words(value);
                }
                Some("parameters") => {
                    self.text.push('(');
                    for (index, (name, default)) in self.fields(value, "`parameters`").iter().enumerate() {
                        if index > 0 {
                            self.text.push_str(", ");
                        }
                        self.name(name);
                        if !matches!(default.scalar(), Some("" | "~" | "null")) {
                            self.text.push_str(" = ");
                            self.words(default);
                        }
                    }
                    self.text.push(')');
                }
                _ => {}
            }
        }
    }

    /// `times 5`
    fn group_size(&mut self, block: &Yaml) {
        let Content::Mapping(fields) = &block.value else { return };
        if let Some((_, number)) = fields.iter().find(|(key, _)| key.scalar() == Some("times")) {
            self.text.push_str(" times ");
            self.words(number);
        }
    }

    /// A default alone, or `{ default: 5 m, in: 1 m .. 30 m, as: T, unit: m, doc: … }`; in place of `default`, `text` is one that is in
    /// quotes.
    fn own_parameter(&mut self, name: &Yaml, value: &Yaml) {
        self.name(name);
        self.text.push_str(" = ");
        let Content::Mapping(fields) = &value.value else { return self.words(value) };
        let field = |wanted: &str| fields.iter().find(|(key, _)| key.scalar() == Some(wanted));
        let known = |(key, _): &(Yaml, Yaml)| {
            matches!(key.scalar(), Some("default" | "text" | "in" | "as" | "unit" | "doc"))
        };
        match (field("default"), field("text")) {
            (Some((_, default)), None) if fields.iter().all(known) => self.words(default),
            (None, Some((_, text))) if fields.iter().all(known) => self.quoted(text),
            _ => {
                return self.wrong(
                    value,
                    "a parameter is made of `default` or `text`, `in`, `as`, `unit` and `doc`",
                    "write `{ default: 5 m, in: 1 m .. 30 m, doc: … }`",
                );
            }
        }
        if let Some((_, values)) = field("in") {
            self.text.push_str(" in ");
            match &values.value {
                Content::List(_) => {
                    self.text.push('[');
                    self.separated(values);
                    self.text.push(']');
                }
                _ => self.words(values),
            }
        }
        match (field("as"), field("unit")) {
            (Some((_, variable)), unit) => {
                self.text.push_str(" as ");
                self.quoted(variable);
                if let Some((_, unit)) = unit {
                    self.text.push_str(" in ");
                    self.words(unit);
                }
            }
            (None, Some((unit, _))) => self.wrong(
                unit,
                "`unit` is that of the variable that `as` names",
                "write `{ default: 5 m, in: 1 m .. 30 m, as: T, unit: m }`",
            ),
            (None, None) => {}
        }
        if let Some((_, doc)) = field("doc") {
            self.text.push(' ');
            self.quoted(doc);
        }
    }

    fn settings(&mut self, value: &Yaml) {
        self.text.push_str(" { ");
        for (index, (name, value)) in self.fields(value, "settings").iter().enumerate() {
            if index > 0 {
                self.text.push_str(", ");
            }
            self.name(name);
            self.text.push_str(": ");
            self.words(value);
        }
        self.text.push_str(" }");
    }

    fn varied(&mut self, name: &Yaml, values: &Yaml) {
        self.name(name);
        self.text.push_str(" in ");
        match values.value {
            Content::List(_) => {
                self.text.push('[');
                self.separated(values);
                self.text.push(']');
            }
            _ => self.words(values),
        }
    }

    fn together(&mut self, group: &Yaml) {
        let fields = self.fields(group, "`vary_together`");
        if let Some((_, sampling)) = fields.iter().find(|(name, _)| name.scalar() == Some("sample")) {
            self.words(sampling);
        }
        self.braces(|writer| {
            for (name, values) in fields.iter().filter(|(name, _)| name.scalar() != Some("sample")) {
                writer.line();
                writer.varied(name, values);
            }
        });
    }
}
