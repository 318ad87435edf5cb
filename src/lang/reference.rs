//! Every statement of the language, block by block, in Markdown: `docs/words.md`. What is said of each is what editors show of it.

use super::syntax::words::{BlockEntry, BlockKind, StatementEntry};
use super::units::UNITS;
use scenario::{AGGREGATES, AggregateOf, DISTRIBUTIONS, DistributionOf};

const BEFORE: &str = "\
# Every statement

What may stand in a block, with an example of each. [The language](language.md) says what it means; [metrics](metrics.md) have a page of their own, and so has each
[model and controller](models/README.md). A statement stands once in its block unless it may be repeated. *Needed* ones have to be said, in the block or
in what it builds on. What `--set` takes is given another value [on the command line](running.md#other-values). In YAML the key stands in the place of the
words that a statement begins with.
";

/// The page.
pub fn reference() -> String {
    let mut text = BEFORE.to_string();
    for block in BlockKind::ALL.map(BlockKind::block) {
        push_block(&mut text, block);
    }
    push_units(&mut text);
    push_aggregates(&mut text);
    push_distributions(&mut text);
    text
}

fn push_block(text: &mut String, block: &BlockEntry) {
    text.push_str(&format!("\n## In {}\n\n", block.name));
    text.push_str("| statement | what it says | | in YAML |\n|---|---|---|---|\n");
    for statement in block.heads.iter().chain(block.statements) {
        let key = if statement.key.is_empty() { String::new() } else { format!("`{}`", statement.key) };
        let (usage, doc) = (cell(statement.usage), cell(statement.doc));
        text.push_str(&format!("| `{usage}` | {doc} | {} | {key} |\n", remarks(statement)));
    }
}

fn remarks(statement: &StatementEntry) -> String {
    let opened = statement.opens.map(|kind| {
        let name = kind.block().name;
        format!("[{name}](#{})", anchor(&format!("In {name}")))
    });
    let said = [
        statement.is_needed().then(|| "needed".to_string()),
        statement.repeats.then(|| "may be repeated".to_string()),
        statement.set.map(|_| "`--set`".to_string()),
        opened.map(|opened| format!("opens {opened}")),
    ];
    said.into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// What links to a heading end in.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

/// Text within a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn push_units(text: &mut String) {
    text.push_str("\n## Units\n\n| unit | of | one of it is | |\n|---|---|---|---|\n");
    for unit in UNITS {
        let (si, symbol) = (unit.to_si(1.0), unit.dimension.si_unit());
        let one = if symbol == unit.symbol { String::new() } else { format!("{si} {symbol}") };
        let of = unit.dimension.name();
        text.push_str(&format!("| `{}` | {of} | {} | {} |\n", unit.symbol, one.trim_end(), cell(unit.doc)));
    }
}

fn push_aggregates(text: &mut String) {
    text.push_str("\n## What is said of several runs\n\n| | |\n|---|---|\n");
    for aggregate in AGGREGATES {
        let given = match aggregate.of {
            AggregateOf::Values(_) => "METRIC",
            AggregateOf::Level(_) => "LEVEL, METRIC",
            AggregateOf::Runs(..) => "CONDITION",
        };
        text.push_str(&format!("| `{}({given})` | {} |\n", aggregate.word, cell(aggregate.doc)));
    }
}

fn push_distributions(text: &mut String) {
    text.push_str("\n## Distributions\n\nFor `draw` and `vary`; [what they are](language.md#draws).\n\n| | numbers without a unit |\n|---|---|\n");
    for distribution in DISTRIBUTIONS {
        let (given, plain) = match distribution.of {
            DistributionOf::Numbers(numbers, _) => {
                let plain = numbers.iter().filter(|number| number.is_plain).map(|number| number.name);
                let all = numbers.iter().map(|number| number.name).collect::<Vec<_>>().join(", ");
                (all, plain.collect::<Vec<_>>().join(", "))
            }
            DistributionOf::Values => ("a, b, …)` or `choice(a: 30 %, b: 70 %".to_string(), String::new()),
        };
        text.push_str(&format!("| `{}({given})` | {plain} |\n", distribution.word));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_statement_has_a_row_and_every_link_a_heading() {
        let page = reference();
        for block in BlockKind::ALL.map(BlockKind::block) {
            let heading = format!("\n## In {}\n", block.name);
            let (_, after) = page.split_once(&heading).unwrap_or_else(|| panic!("{heading}"));
            let section = after.split("\n## ").next().unwrap();
            let rows = section.lines().filter(|line| line.starts_with("| `")).count();
            assert_eq!(rows, block.heads.len() + block.statements.len(), "{}", block.name);
        }
        let headings: Vec<String> =
            page.lines().filter_map(|line| line.strip_prefix("## ")).map(anchor).collect();
        for link in page.split("](#").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            assert!(headings.iter().any(|heading| heading == link), "{link}");
        }
    }

    #[test]
    fn no_row_has_more_or_fewer_cells_than_its_table() {
        let mut wanted = 0;
        for line in reference().lines() {
            let cells = line.replace("\\|", "").matches('|').count();
            wanted = if line.starts_with('|') && wanted > 0 { wanted } else { cells };
            assert_eq!(cells, wanted, "{line}");
        }
    }
}
