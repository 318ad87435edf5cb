//! A scenario file to YAML. Comments and the order of unlike statements are not kept.

use super::shape::{Key, Shape, keys};
use crate::lang::format::phrase;
use crate::lang::tree::{Node, Rule, Tree};
use crate::lang::value::unquote;

/// The YAML form of a file without syntax errors.
pub fn to_yaml(tree: &Tree) -> String {
    let mut out = String::new();
    block(tree.root(), Rule::file, 0, &mut out);
    if out.is_empty() {
        // A file that says nothing is still a file, and no text at all is no YAML mapping.
        out.push_str("{}\n");
    }
    out
}

fn block(node: Node, rule: Rule, depth: usize, out: &mut String) {
    let first_group = node.child(Rule::vary_together).map(|group| group.span().start);
    for key in keys(rule) {
        let belongs = |statement: &Node| {
            let grouped = is_listed(*statement) && first_group.is_some_and(|at| at < statement.span().start);
            match key.rule {
                // Variations count in their order: what comes after a group is a group of its own.
                Rule::vary => statement.rule() == key.rule && !grouped,
                Rule::vary_together => statement.rule() == key.rule || grouped,
                _ => statement.rule() == key.rule && belongs(*statement, key),
            }
        };
        let statements: Vec<Node> = node.children().filter(belongs).collect();
        if !statements.is_empty() {
            write(key, &statements, depth, out);
        }
    }
}

/// `vary NAME in [a, b]`, which a group may say as well; draws belong to the statement that they stand in.
fn is_listed(statement: Node) -> bool {
    statement.rule() == Rule::vary && (statement.has(Rule::list) || statement.has(Rule::range))
}

/// Statements of one rule may have two keys: `minimise` and `maximise`.
fn belongs(statement: Node, key: &Key) -> bool {
    match (key.rule, key.name) {
        (Rule::objective, name) => statement.has(Rule::kw_minimise) == (name == "minimise"),
        (Rule::obstacle, name) => statement.has(Rule::kw_parked) == (name == "parked"),
        _ => true,
    }
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
    node.child(Rule::name).map_or("", Node::text)
}

/// `{ profile: "normal" }`
fn settings(node: Option<Node>) -> String {
    let pairs: Vec<_> = node
        .iter()
        .flat_map(|node| node.all(Rule::setting))
        .filter_map(|setting| {
            let value = phrase(setting.child(Rule::expression)?);
            Some(format!("{}: {}", setting.child(Rule::setting_name)?.text(), serde_json::Value::from(value)))
        })
        .collect();
    if pairs.is_empty() { "{}".to_string() } else { format!("{{ {} }}", pairs.join(", ")) }
}

fn values(node: Node) -> String {
    match node.child(Rule::list) {
        Some(list) => flow_list(list.all(Rule::expression).map(phrase)),
        None => {
            let words = phrase(node);
            scalar(words.split_once(" in ").map_or("", |(_, values)| values))
        }
    }
}

fn write(key: &Key, statements: &[Node], depth: usize, out: &mut String) {
    let Some(first) = statements.first().copied() else { return };
    match key.shape {
        Shape::Words(keyword) => match statements {
            [only] => line(depth, &format!("{}: {}", key.name, scalar(&rest(*only, keyword))), out),
            several => {
                let items = several.iter().map(|node| rest(*node, keyword));
                line(depth, &format!("{}: {}", key.name, flow_list(items)), out);
            }
        },
        Shape::Lines(keyword) => {
            line(depth, &format!("{}:", key.name), out);
            for node in statements {
                line(depth + 1, &format!("- {}", scalar(&rest(*node, keyword))), out);
            }
        }
        Shape::Text(_) => {
            let texts: Vec<String> = statements
                .iter()
                .flat_map(|node| node.all(Rule::string))
                .map(|node| unquote(node.text()))
                .collect();
            match texts.as_slice() {
                [only] => {
                    line(depth, &format!("{}: {}", key.name, serde_json::Value::from(only.as_str())), out)
                }
                _ => line(depth, &format!("{}: {}", key.name, flow_list(texts.into_iter())), out),
            }
        }
        Shape::Commas(_) => {
            const PARTS: [Rule; 5] =
                [Rule::tag, Rule::direction, Rule::constraint, Rule::expression, Rule::measure];
            let parts = statements
                .iter()
                .flat_map(|node| node.children())
                .filter(|part| PARTS.contains(&part.rule()));
            line(depth, &format!("{}: {}", key.name, flow_list(parts.map(phrase))), out);
        }
        Shape::Named(_, rule) => {
            line(depth, &format!("{}:", key.name), out);
            for node in statements {
                let inner = node.children().find(|child| child.rule() == rule);
                line(depth + 1, &format!("{}:", name(*node)), out);
                let before = out.len();
                head(*node, depth + 2, out);
                if let Some(inner) = inner {
                    block(inner, rule, depth + 2, out);
                }
                if out.len() == before {
                    out.pop();
                    out.push_str(" {}\n");
                }
            }
        }
        Shape::NameOrBlock(_, rule) => match first.child(rule) {
            Some(inner) => {
                line(depth, &format!("{}:", key.name), out);
                block(inner, rule, depth + 1, out);
            }
            None => line(depth, &format!("{}: {}", key.name, name(first)), out),
        },
        Shape::Statements(_) => {
            line(depth, &format!("{}:", key.name), out);
            let criteria: Vec<Node> = statements
                .iter()
                .flat_map(|node| match node.child(Rule::expect_block) {
                    Some(block) => block.all(Rule::criterion).collect(),
                    None => vec![*node],
                })
                .collect();
            for criterion in criteria {
                line(depth + 1, &format!("- {}", scalar(&phrase(criterion))), out);
            }
        }
        Shape::Model(keyword) => {
            let block = first.child(Rule::settings);
            let words = rest(first, keyword);
            let model = words.split(['{', ' ']).next().unwrap_or_default();
            match block {
                Some(_) => line(depth, &format!("{}: {{ {model}: {} }}", key.name, settings(block)), out),
                None => line(depth, &format!("{}: {model}", key.name), out),
            }
        }
        Shape::NamedSettings(_) => {
            line(depth, &format!("{}:", key.name), out);
            for node in statements {
                line(depth + 1, &format!("{}: {}", name(*node), settings(node.child(Rule::settings))), out);
            }
        }
        Shape::Settings(_) => {
            line(depth, &format!("{}: {}", key.name, settings(first.child(Rule::settings))), out)
        }
        Shape::Values(_) => {
            line(depth, &format!("{}:", key.name), out);
            for node in statements {
                let ranges: Vec<Node> = node.all(Rule::over_range).collect();
                for range in &ranges {
                    let target = range.child(Rule::target).map(phrase).unwrap_or_default();
                    line(depth + 1, &format!("{target}: {}", values(*range)), out);
                }
                if ranges.is_empty() {
                    line(depth + 1, &format!("{}: {}", name(*node), values(*node)), out);
                }
            }
        }
        Shape::Together => {
            line(depth, &format!("{}:", key.name), out);
            for node in statements {
                let sample = node
                    .child(Rule::sampling)
                    .map(|sampling| format!("sample: {}", scalar(&phrase(sampling))));
                let varied = node.children().filter(|child| child.rule() == Rule::together_block);
                let lines = varied
                    .flat_map(|block| block.all(Rule::varied))
                    .chain((node.rule() == Rule::vary).then_some(*node))
                    .map(|varied| format!("{}: {}", name(varied), values(varied)));
                for (index, text) in sample.into_iter().chain(lines).enumerate() {
                    line(depth + 1, &format!("{} {text}", if index == 0 { "-" } else { " " }), out);
                }
            }
        }
        Shape::Bindings => {
            line(depth, &format!("{}:", key.name), out);
            for node in statements {
                let value = node.child(Rule::expression).map(phrase).unwrap_or_default();
                line(depth + 1, &format!("{}: {}", name(*node), scalar(&value)), out);
            }
        }
        Shape::Flag(_) => line(depth, &format!("{}: true", key.name), out),
        Shape::NotFlag(_) => line(depth, &format!("{}: false", key.name), out),
        Shape::Cases => match first.child(Rule::string) {
            Some(path) => {
                let path = serde_json::Value::from(unquote(path.text()));
                line(depth, &format!("{}: {{ file: {path} }}", key.name), out);
            }
            None => line(depth, &format!("{}: {}", key.name, scalar(&rest(first, "on"))), out),
        },
        Shape::Conditions => {
            let conditions = statements.iter().flat_map(|node| node.all(Rule::evaluated)).map(condition);
            line(depth, &format!("{}: [{}]", key.name, conditions.collect::<Vec<_>>().join(", ")), out);
        }
        Shape::Rows(_) => {
            line(depth, &format!("{}:", key.name), out);
            for row in statements {
                let values = flow_list(row.all(Rule::expression).map(phrase));
                line(depth + 1, &format!("{}: {values}", name(*row)), out);
            }
        }
        Shape::Head => {}
    }
}

/// `"braking as tuned"`, `{ file: "tuned.json", as: saved }` or `{ set: { av.controller.gap: "5 m" }, as: near }`
fn condition(node: Node) -> String {
    let alias = node.child(Rule::alias).map(|alias| format!(", as: {}", name(alias))).unwrap_or_default();
    if let Some(path) = node.child(Rule::string) {
        return format!("{{ file: {}{alias} }}", serde_json::Value::from(unquote(path.text())));
    }
    let Some(set) = node.child(Rule::parameter_set) else {
        return serde_json::Value::from(phrase(node)).to_string();
    };
    let pairs: Vec<_> = set
        .all(Rule::given)
        .filter_map(|given| {
            let value = serde_json::Value::from(phrase(given.child(Rule::expression)?));
            Some(format!("{}: {value}", phrase(given.child(Rule::target)?)))
        })
        .collect();
    let set = if pairs.is_empty() { "{}".to_string() } else { format!("{{ {} }}", pairs.join(", ")) };
    format!("{{ set: {set}{alias} }}")
}

fn head(node: Node, depth: usize, out: &mut String) {
    if let Some(base) = node.child(Rule::base) {
        line(depth, &format!("extends: {}", scalar(phrase(base).trim_start_matches(':').trim())), out);
    }
    if let Some(parameters) = node.child(Rule::parameters) {
        line(depth, "parameters:", out);
        for parameter in parameters.all(Rule::parameter) {
            let default =
                parameter.child(Rule::expression).map(|value| format!(" {}", scalar(&phrase(value))));
            line(depth + 1, &format!("{}:{}", name(parameter), default.unwrap_or_default()), out);
        }
    }
}
