//! A scenario file to YAML. Comments and the order of unlike statements are not kept.

use crate::syntax::ast::{self, View};
use crate::syntax::words::{StatementEntry, YamlShape};
use crate::syntax::{Node, Tree, phrase};

/// The YAML form of a file without syntax errors.
pub fn to_yaml(tree: &Tree) -> String {
    let mut out = String::new();
    block(tree.root(), 0, &mut out);
    if out.is_empty() {
        // A file that says nothing is still a file, and no text at all is no YAML mapping.
        out.push_str("{}\n");
    }
    out
}

fn block(node: Node, depth: usize, out: &mut String) {
    let Some(known) = node.block() else { return };
    let first_group = node.parts::<ast::VaryTogether>().next().map(|group| group.span().start);
    // Variations count in their order: what comes after a group is a group of its own.
    let grouped = |said: &Node| {
        ast::Varied::cast(*said).is_some_and(is_listed)
            && first_group.is_some_and(|at| at < said.span().start)
    };
    for statement in known.keys() {
        let belongs = |said: &Node| match statement.shape {
            YamlShape::Together => statement.is(*said) || grouped(said),
            _ => statement.is(*said) && !grouped(said),
        };
        let said: Vec<Node> = node.children().filter(belongs).collect();
        if !said.is_empty() {
            write(statement, &said, depth, out);
        }
    }
}

/// `vary NAME in [a, b]`, which a group may say as well; draws belong to the statement that they stand in.
fn is_listed(varied: ast::Varied) -> bool {
    varied.list().is_some() || varied.range().is_some()
}

fn line(depth: usize, text: &str, out: &mut String) {
    out.push_str(&"  ".repeat(depth));
    out.push_str(text);
    out.push('\n');
}

/// A scalar, in quotes unless it is plainly a word or quantity.
fn scalar(text: &str) -> String {
    let plain = text.starts_with(|c: char| c.is_ascii_alphanumeric())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || " _./%^*+-=<>()".contains(c))
        && !text.ends_with(' ')
        && !matches!(text.to_lowercase().as_str(), "null" | "yes" | "no" | "on" | "off" | "y" | "n");
    if plain { text.to_string() } else { serde_json::Value::from(text).to_string() }
}

/// The statement's words after its first `skip` words.
fn rest(node: Node, skip: &str) -> String {
    phrase(node)[skip.len()..].trim().to_string()
}

fn flow_list(items: impl Iterator<Item = String>) -> String {
    format!(
        "[{}]",
        items.map(|item| serde_json::Value::from(item).to_string()).collect::<Vec<_>>().join(", ")
    )
}

fn name<'t>(node: Node<'t>) -> &'t str {
    node.parts::<ast::Name>().next().map_or("", |name| name.text())
}

/// `{ profile: "normal" }`
fn settings(said: Option<ast::Settings>) -> String {
    let pair = |setting: ast::Setting| {
        format!("{}: {}", setting.name().text(), serde_json::Value::from(phrase(*setting.value())))
    };
    let pairs: Vec<_> = said.into_iter().flat_map(ast::Settings::each).map(pair).collect();
    if pairs.is_empty() { "{}".to_string() } else { format!("{{ {} }}", pairs.join(", ")) }
}

/// A path, or `{ file: "exposure.csv", without: ["id", "date"] }`
fn table(said: ast::DrawTogether) -> String {
    let path = serde_json::Value::from(said.file().value());
    let left_out: Vec<String> = said.left_out().map(|name| name.text().to_string()).collect();
    match left_out.is_empty() {
        true => path.to_string(),
        false => format!("{{ file: {path}, without: {} }}", flow_list(left_out.into_iter())),
    }
}

fn settings_of<'t>(node: Node<'t>) -> Option<ast::Settings<'t>> {
    node.parts().next()
}

fn values(node: Node) -> String {
    match node.parts::<ast::List>().next() {
        Some(list) => flow_list(list.values().map(|value| phrase(*value))),
        None => {
            let words = phrase(node);
            scalar(words.split_once(" in ").map_or("", |(_, values)| values))
        }
    }
}

fn write(statement: &StatementEntry, statements: &[Node], depth: usize, out: &mut String) {
    let Some(first) = statements.first().copied() else { return };
    let (keyword, key) = (statement.words, statement.key);
    match statement.shape {
        YamlShape::Words => match statements {
            [only] => line(depth, &format!("{key}: {}", scalar(&rest(*only, keyword))), out),
            several => {
                let items = several.iter().map(|node| rest(*node, keyword));
                line(depth, &format!("{key}: {}", flow_list(items)), out);
            }
        },
        YamlShape::Lines => {
            line(depth, &format!("{key}:"), out);
            for node in statements {
                line(depth + 1, &format!("- {}", scalar(&rest(*node, keyword))), out);
            }
        }
        YamlShape::Text => {
            let texts: Vec<String> =
                statements.iter().flat_map(|node| node.parts::<ast::Text>()).map(ast::Text::value).collect();
            match texts.as_slice() {
                [only] => line(depth, &format!("{key}: {}", serde_json::Value::from(only.as_str())), out),
                _ => line(depth, &format!("{key}: {}", flow_list(texts.into_iter())), out),
            }
        }
        YamlShape::Table => {
            let tables: Vec<String> =
                statements.iter().copied().filter_map(ast::DrawTogether::cast).map(table).collect();
            match tables.as_slice() {
                [only] => line(depth, &format!("{key}: {only}"), out),
                several => line(depth, &format!("{key}: [{}]", several.join(", ")), out),
            }
        }
        YamlShape::Texts => {
            let texts = statements.iter().flat_map(|node| node.parts::<ast::Text>()).map(ast::Text::value);
            line(depth, &format!("{key}: {}", flow_list(texts)), out);
        }
        YamlShape::OwnParameters => {
            line(depth, &format!("{key}:"), out);
            for parameter in statements.iter().copied().filter_map(ast::OwnParameter::cast) {
                line(depth + 1, &format!("{}: {}", parameter.name().text(), own_parameter(parameter)), out);
            }
        }
        YamlShape::Commas => {
            let parts = statements.iter().flat_map(|node| node.parts::<ast::Listed>());
            line(depth, &format!("{key}: {}", flow_list(parts.map(|part| phrase(*part)))), out);
        }
        YamlShape::Named => {
            line(depth, &format!("{key}:"), out);
            for node in statements {
                line(depth + 1, &format!("{}:", name(*node)), out);
                let before = out.len();
                head(*node, depth + 2, out);
                if let Some(inner) = statement.opened(*node) {
                    block(inner, depth + 2, out);
                }
                say_if_empty(before, out);
            }
        }
        YamlShape::NameOrBlock => match statement.opened(first) {
            Some(inner) => {
                line(depth, &format!("{key}:"), out);
                let before = out.len();
                block(inner, depth + 1, out);
                say_if_empty(before, out);
            }
            None => line(depth, &format!("{key}: {}", name(first)), out),
        },
        YamlShape::Statements => {
            line(depth, &format!("{key}:"), out);
            let criteria: Vec<Node> = statements
                .iter()
                .flat_map(|node| match statement.opened(*node) {
                    Some(block) => block.children().collect(),
                    None => vec![*node],
                })
                .collect();
            for criterion in criteria {
                let said = match settings_of(criterion) {
                    Some(given) => {
                        let words = phrase(criterion);
                        let words = words.split('{').next().unwrap_or_default().trim();
                        format!("{{ {words}: {} }}", settings(Some(given)))
                    }
                    None => scalar(&phrase(criterion)),
                };
                line(depth + 1, &format!("- {said}"), out);
            }
        }
        YamlShape::Model => {
            let block = settings_of(first);
            let words = rest(first, keyword);
            let model = words.split(['{', ' ']).next().unwrap_or_default();
            match block {
                Some(_) => line(depth, &format!("{key}: {{ {model}: {} }}", settings(block)), out),
                None => line(depth, &format!("{key}: {model}"), out),
            }
        }
        YamlShape::Tested => {
            line(depth, &format!("{key}:"), out);
            for tested in statements.iter().copied().filter_map(ast::Tested::cast) {
                let (vehicle, controller) = (tested.vehicle().name().text(), tested.name().text());
                let said = match settings_of(*tested) {
                    Some(given) => format!("{{ {controller}: {} }}", settings(Some(given))),
                    None => controller.to_string(),
                };
                let vehicle =
                    if tested.where_present() { format!("{vehicle} where present") } else { vehicle.into() };
                line(depth + 1, &format!("{vehicle}: {said}"), out);
            }
        }
        YamlShape::NamedModels => {
            line(depth, &format!("{key}:"), out);
            for node in statements {
                let user = name(*node);
                let words = rest(*node, keyword);
                let model = words[user.len()..].trim_start().split(['{', ' ']).next().unwrap_or_default();
                let said = match settings_of(*node) {
                    Some(given) => format!("{{ {model}: {} }}", settings(Some(given))),
                    None => model.to_string(),
                };
                line(depth + 1, &format!("{user}: {said}"), out);
            }
        }
        YamlShape::NamedSettings => {
            line(depth, &format!("{key}:"), out);
            for node in statements {
                line(depth + 1, &format!("{}: {}", name(*node), settings(settings_of(*node))), out);
            }
        }
        YamlShape::Settings => line(depth, &format!("{key}: {}", settings(settings_of(first))), out),
        YamlShape::Values => {
            line(depth, &format!("{key}:"), out);
            for node in statements {
                for range in node.parts::<ast::OverRange>() {
                    line(depth + 1, &format!("{}: {}", phrase(*range.target()), values(*range)), out);
                }
                if let Some(varied) = ast::Varied::cast(*node) {
                    line(depth + 1, &format!("{}: {}", varied.name().text(), values(*varied)), out);
                }
            }
        }
        YamlShape::Drawn => {
            line(depth, &format!("{key}:"), out);
            for draw in statements.iter().copied().filter_map(ast::Draw::cast) {
                let from = match (draw.file(), draw.distribution()) {
                    (Some(file), _) => format!("{{ file: {} }}", serde_json::Value::from(file.value())),
                    (None, Some(distribution)) => scalar(&phrase(*distribution)),
                    (None, None) => String::new(),
                };
                line(depth + 1, &format!("{}: {from}", draw.name().text()), out);
            }
        }
        YamlShape::Together => {
            line(depth, &format!("{key}:"), out);
            for node in statements {
                let sampling = node.parts::<ast::Sampling>().next();
                let sample = sampling.map(|sampling| format!("sample: {}", scalar(&phrase(*sampling))));
                let lines = node
                    .every::<ast::Varied>()
                    .map(|varied| format!("{}: {}", varied.name().text(), values(*varied)));
                for (index, text) in sample.into_iter().chain(lines).enumerate() {
                    line(depth + 1, &format!("{} {text}", if index == 0 { "-" } else { " " }), out);
                }
            }
        }
        YamlShape::Bindings => {
            line(depth, &format!("{key}:"), out);
            for binding in statements.iter().copied().filter_map(ast::Binding::cast) {
                let value = scalar(&phrase(*binding.value()));
                line(depth + 1, &format!("{}: {value}", binding.name().text()), out);
            }
        }
        YamlShape::Flag => line(depth, &format!("{key}: true"), out),
        YamlShape::NotFlag => line(depth, &format!("{key}: false"), out),
        YamlShape::Cases => match first.parts::<ast::Text>().next() {
            Some(path) => {
                let path = serde_json::Value::from(path.value());
                line(depth, &format!("{key}: {{ file: {path} }}"), out);
            }
            None => line(depth, &format!("{key}: {}", scalar(&rest(first, keyword))), out),
        },
        YamlShape::Conditions => {
            let conditions = statements.iter().flat_map(|node| node.parts::<ast::Evaluated>()).map(condition);
            line(depth, &format!("{key}: [{}]", conditions.collect::<Vec<_>>().join(", ")), out);
        }
        YamlShape::ParameterSets => {
            let sets = statements.iter().flat_map(|node| node.parts::<ast::ParameterSet>());
            let sets: Vec<_> = sets.map(parameter_set).collect();
            match sets.as_slice() {
                [only] => line(depth, &format!("{key}: {only}"), out),
                several => line(depth, &format!("{key}: [{}]", several.join(", ")), out),
            }
        }
        YamlShape::Rows => {
            line(depth, &format!("{key}:"), out);
            for row in statements.iter().copied().filter_map(ast::ReportedRow::cast) {
                let values = flow_list(row.values().map(|value| phrase(*value)));
                line(depth + 1, &format!("{}: {values}", row.name().text()), out);
            }
        }
        YamlShape::Weights => {
            line(depth, &format!("{key}:"), out);
            for weights in statements.iter().copied().filter_map(ast::Weights::cast) {
                let when = weights.when().map(|when| format!("when: {}", scalar(&rest(*when, "when"))));
                let lines = weights.block().lines().map(|line| {
                    let said = phrase(*line);
                    let (value, weight) = said.rsplit_once(':').unwrap_or((&said, ""));
                    format!("{}: {}", serde_json::Value::from(value.trim()), scalar(weight.trim()))
                });
                let pairs: Vec<_> = when.into_iter().chain(lines).collect();
                line(depth + 1, &format!("- {{ {} }}", pairs.join(", ")), out);
            }
        }
        YamlShape::Base | YamlShape::Parameters | YamlShape::GroupSize => {}
    }
}

/// `{ default: 5 m, in: 1 m .. 30 m, as: "T", unit: "m", doc: "…" }`, where a default in quotes is a `text`.
fn own_parameter(node: ast::OwnParameter) -> String {
    let (default, text) = (node.default(), |text: &str| serde_json::Value::from(text).to_string());
    let mut parts = vec![match (default.parts::<ast::Text>().next(), default.terms().count()) {
        (Some(quoted), 1) => format!("text: {}", text(&quoted.value())),
        _ => format!("default: {}", scalar(&phrase(*default))),
    }];
    if let Some(values) = node.values() {
        let words = phrase(*values);
        parts.push(match values.list() {
            Some(list) => format!("in: {}", flow_list(list.values().map(|value| phrase(*value)))),
            None => format!("in: {}", scalar(words.strip_prefix("in ").unwrap_or(&words))),
        });
    }
    if let Some(wired) = node.wired() {
        parts.push(format!("as: {}", text(&wired.variable().value())));
        parts.extend(wired.unit().map(|said| format!("unit: {}", text(said.unit().text()))));
    }
    parts.extend(node.doc().map(|doc| format!("doc: {}", text(&doc.value()))));
    format!("{{ {} }}", parts.join(", "))
}

/// A block that says nothing is still a block.
fn say_if_empty(before: usize, out: &mut String) {
    if out.len() == before {
        out.pop();
        out.push_str(" {}\n");
    }
}

/// `"braking as tuned"`, `{ file: "tuned.json", as: saved }` or `{ set: { av.controller.gap: "5 m" }, as: near }`
fn condition(node: ast::Evaluated) -> String {
    let alias = node.alias().map(|alias| format!(", as: {}", alias.name().text())).unwrap_or_default();
    if let Some(path) = node.path() {
        return format!("{{ file: {}{alias} }}", serde_json::Value::from(path.value()));
    }
    let Some(set) = node.set() else {
        return serde_json::Value::from(phrase(*node)).to_string();
    };
    format!("{{ set: {}{alias} }}", parameter_set(set))
}

/// `{ av.controller.gap: "5 m" }`
fn parameter_set(set: ast::ParameterSet) -> String {
    let pair = |given: ast::Given| {
        let value = serde_json::Value::from(phrase(*given.value()));
        format!("{}: {value}", phrase(*given.target()))
    };
    let pairs: Vec<_> = set.given().map(pair).collect();
    if pairs.is_empty() { "{}".to_string() } else { format!("{{ {} }}", pairs.join(", ")) }
}

fn head(node: Node, depth: usize, out: &mut String) {
    if let Some(size) = ast::Pedestrian::cast(node).and_then(ast::Pedestrian::group) {
        line(depth, &format!("times: {}", size.number().text()), out);
    }
    let Some(scenario) = ast::Scenario::cast(node) else { return };
    if let Some(base) = scenario.base() {
        line(depth, &format!("extends: {}", scalar(phrase(*base).trim_start_matches(':').trim())), out);
    }
    if let Some(parameters) = scenario.parameters() {
        line(depth, "parameters:", out);
        for parameter in parameters.each() {
            let default = parameter.default().map(|value| format!(" {}", scalar(&phrase(*value))));
            line(depth + 1, &format!("{}:{}", parameter.name().text(), default.unwrap_or_default()), out);
        }
    }
}
