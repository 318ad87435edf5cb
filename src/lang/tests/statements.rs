//! Every statement of the table is known to all who take their statements from it.

use std::collections::BTreeSet;

use super::*;
use crate::syntax::words::{BlockEntry, BlockKind, StatementEntry};
use crate::syntax::{Node, words};

/// A file in which the block of a kind says `inside`.
fn around(kind: BlockKind, inside: &str) -> String {
    match kind {
        BlockKind::File => inside.to_string(),
        BlockKind::Road => format!("road street {{\n  {inside}\n}}\n"),
        BlockKind::Path => around(BlockKind::Road, &format!("path {{\n    {inside}\n  }}")),
        BlockKind::Controller => format!("controller own {{\n  {inside}\n}}\n"),
        BlockKind::Scenario => format!("scenario a {{\n  {inside}\n}}\n"),
        BlockKind::Vehicle => around(BlockKind::Scenario, &format!("vehicle av {{\n    {inside}\n  }}")),
        BlockKind::Stream => around(BlockKind::Scenario, &format!("stream cars {{\n    {inside}\n  }}")),
        BlockKind::Pedestrian => {
            around(BlockKind::Scenario, &format!("pedestrian walker {{\n    {inside}\n  }}"))
        }
        BlockKind::Expect => around(BlockKind::Scenario, &format!("expect {{\n    {inside}\n  }}")),
        BlockKind::Together => around(BlockKind::Scenario, &format!("vary together {{\n    {inside}\n  }}")),
        BlockKind::Suite => format!("suite s {{\n  {inside}\n}}\n"),
        BlockKind::Gate => around(BlockKind::Suite, &format!("gate g {{\n    {inside}\n  }}")),
        BlockKind::Rating => around(BlockKind::Suite, &format!("rating r {{\n    {inside}\n  }}")),
        BlockKind::ExpectPoints => around(BlockKind::Rating, &format!("expect {{\n    {inside}\n  }}")),
        BlockKind::Search => format!("search s {{\n  {inside}\n}}\n"),
        BlockKind::Tune => format!("tune t {{\n  {inside}\n}}\n"),
        BlockKind::Evaluate => format!("evaluate e {{\n  {inside}\n}}\n"),
        BlockKind::Calibrate => format!("calibrate c {{\n  {inside}\n}}\n"),
        BlockKind::Estimate => format!("estimate e {{\n  {inside}\n}}\n"),
        BlockKind::Statement => format!("statement t {{\n  {inside}\n}}\n"),
    }
}

/// Every example of every statement in a file of its own.
fn examples() -> impl Iterator<Item = (&'static BlockEntry, &'static StatementEntry, String)> {
    BlockKind::ALL.into_iter().map(BlockKind::block).flat_map(|block| {
        block.statements.iter().flat_map(move |statement| {
            let usages = statement.usages().map(|usage| usage.replace('…', ""));
            usages.map(move |usage| (block, statement, around(block.kind, &usage)))
        })
    })
}

fn parsed(text: &str) -> Tree {
    let (tree, found) = Tree::parse(Sources::default().add("a.scn", text), text.into());
    assert!(found.is_empty(), "{text}: {found:?}");
    tree
}

fn says(tree: &Tree, block: &BlockEntry, statement: &StatementEntry) -> bool {
    let blocks = tree.nodes().filter(|node| node.block().is_some_and(|known| known.kind == block.kind));
    blocks.flat_map(Node::children).any(|said| statement.is(said))
}

#[test]
fn it_is_read_and_formatted_into_the_same() {
    for (block, statement, text) in examples() {
        let source = Sources::default().add("a.scn", &*text);
        assert!(says(&parsed(&text), block, statement), "{text}");
        let once = format(source, &text).unwrap();
        assert!(says(&parsed(&once), block, statement), "{once}");
        assert_eq!(format(source, &once).unwrap(), once);
    }
}

#[test]
fn it_goes_to_yaml_and_back() {
    for (_, _, text) in examples() {
        let source = Sources::default().add("a.scn", &*text);
        let yaml = to_yaml(source, &text).unwrap();
        let back = from_yaml(source, &yaml).unwrap_or_else(|found| panic!("{yaml}: {found:?}"));
        let flat = |text: &str| {
            let formatted = format(source, text).unwrap().replace(['\n', ';'], " ");
            formatted.split_whitespace().collect::<Vec<_>>().join(" ")
        };
        assert_eq!(flat(&back), flat(&text), "{yaml}");
    }
}

#[test]
fn its_key_is_in_the_schema() {
    let schema = yaml_schema(&standard());
    for block in BlockKind::ALL.into_iter().map(BlockKind::block) {
        for statement in block.keys() {
            let property = &schema["$defs"][block.word()]["properties"][statement.key];
            assert_eq!(property["description"], statement.doc, "{}.{}", block.word(), statement.key);
        }
    }
}

/// `UPDATE_DOCS=1` adds what is missing to the words that editors colour; what they have besides is theirs.
#[test]
fn editors_colour_its_words_and_all_others() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../editors/vscode/syntaxes/scn.tmLanguage.json");
    let mut colours = std::fs::read_to_string(path).unwrap();
    let keywords = grammar::scn::TEXT.lines().filter_map(|line| line.strip_prefix("kw_")?.split('"').nth(1));
    // Which list a word belongs to is said by one that is there.
    let lists: [(&str, Vec<&str>); 4] = [
        ("speed", words::all().map(StatementEntry::word).filter(|word| !word.is_empty()).collect()),
        ("mean", scenario::AGGREGATES.iter().map(|known| known.word).collect()),
        ("km/h", UNITS.iter().map(|unit| unit.symbol).collect()),
        ("evaluations", keywords.collect()),
    ];
    let written = |word: &str| word.replace('^', r"\\^");
    let mut missing = Vec::new();
    for (beside, wanted) in lists {
        for word in wanted {
            let is_listed = |word: &str| {
                let ends = ["|", ")", "(?="];
                ["|", "("]
                    .iter()
                    .any(|start| ends.iter().any(|end| colours.contains(&format!("{start}{word}{end}"))))
            };
            if !is_listed(&written(word)) {
                let beside = format!("|{beside}|");
                colours = colours.replacen(&beside, &format!("{beside}{}|", written(word)), 1);
                missing.push(word);
            }
        }
    }
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(path, colours).unwrap();
    } else {
        assert!(
            missing.is_empty(),
            "editors do not colour {missing:?}; run the tests once with UPDATE_DOCS=1"
        );
    }
}

#[test]
fn it_is_completed_and_hovered() {
    for (block, statement, text) in examples().filter(|(_, statement, _)| !statement.words.is_empty()) {
        let empty = around(block.kind, "@");
        let at = empty.find('@').unwrap();
        let (path, empty) = (Path::new("nowhere/a.scn"), empty.replace('@', ""));
        let proposals = complete(path, &empty, at, &standard(), &Memory::default());
        let proposed = proposals.iter().find(|proposal| proposal.word == statement.word());
        assert!(proposed.is_some_and(|proposal| !proposal.detail.is_empty()), "{}", statement.words);
        let (_, said) = hover(&parsed(&text), at, &standard()).unwrap();
        assert!(said.starts_with(statement.doc), "{text}: {said}");
    }
}

#[test]
fn it_stands_in_the_page_of_reference() {
    let page =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/language.md")).unwrap();
    let fenced = |language: &str| {
        let fence = format!("```{language}\n");
        let parts = page.split(&fence).skip(1);
        parts.map(|rest| parsed(rest.split("```").next().unwrap())).collect::<Vec<_>>()
    };
    let trees: Vec<Tree> = fenced("scn").into_iter().chain(fenced("suite")).collect();
    let missing: BTreeSet<String> = BlockKind::ALL
        .into_iter()
        .map(BlockKind::block)
        .flat_map(|block| block.statements.iter().map(move |statement| (block, statement)))
        .filter(|(block, statement)| {
            let shown = trees.iter().any(|tree| says(tree, block, statement));
            // What is said beside an example, or of what an example of another block shows.
            let said = page.contains(&format!("`{}", statement.words)) && !statement.words.is_empty();
            let elsewhere = BlockKind::ALL.into_iter().map(BlockKind::block).any(|other| {
                let mut same = other.statements.iter().filter(|one| one.doc == statement.doc);
                same.any(|one| trees.iter().any(|tree| says(tree, other, one)))
            });
            !(shown || said || elsewhere)
        })
        .map(|(block, statement)| format!("{}: {}", block.name, statement.words))
        .collect();
    assert!(missing.is_empty(), "no example shows {missing:#?}");
}

#[test]
fn it_takes_values_from_outside_where_the_table_says_so() {
    for (block, statement, text) in examples().filter(|(_, statement, _)| statement.set.is_some()) {
        let prefix = match block.kind {
            BlockKind::Vehicle => "av.",
            BlockKind::Stream => "cars.",
            BlockKind::Pedestrian => "walker.",
            _ => "",
        };
        let value = if statement.word() == "size" { "3 m x 2 m" } else { "7" };
        let wanted: Override = format!("{prefix}{}={value}", statement.word()).parse().unwrap();
        let mut overrides = overrides::Overrides::new(std::slice::from_ref(&wanted));
        let changed = overrides::apply(&text, &overrides.edits(&parsed(&text), &standard()));
        assert!(overrides.unknown().0.is_empty(), "{text}");
        assert!(changed.contains(value), "{changed}");
    }
}

#[test]
fn what_gives_names_has_one() {
    for statement in words::all().filter(|statement| statement.names) {
        let has_name = |usage: &str| usage.contains("NAME") || usage.contains('=') || usage.contains(" in ");
        assert!(statement.usages().any(has_name), "{}", statement.words);
    }
}

/// A scenario with a road user of each kind; in the block of a kind `said` stands in place of what says the same there.
fn with(kind: BlockKind, said: &str) -> String {
    if let Some(text) = on_another_road(kind, said) {
        return text;
    }
    let words = match said {
        // Beside the first, which has no name.
        other if other.starts_with("crossing school") => "another crossing",
        _ => kind.block().beginning(said).expect("it is one of its statements").words,
    };
    let other = match words {
        "radius" => "size",
        "runs" => "repeat",
        _ => words,
    };
    let block = |own: BlockKind, lines: &[&str]| {
        let kept =
            lines.iter().filter(|line| own != kind || !line.starts_with(words) && !line.starts_with(other));
        let mut lines: Vec<&str> = kept.copied().collect();
        if own == kind {
            lines.push(said);
        }
        lines.join("; ")
    };
    let road = block(
        BlockKind::Road,
        &["lanes forward, forward", "lane_width 3.5 m", "speed_limit 50 km/h", "crossing unmarked"],
    );
    let needed = match said {
        "crosses school" => "; crossing school zebra { at: 40 m }",
        "waits on refuge" => "; median 2 m after lane 0 with refuge",
        _ => "",
    };
    let road = format!("road {{ {road}{needed} }}");
    let car = block(
        BlockKind::Vehicle,
        &["controller carla_behavior", "speed 30 km/h", "start 60 m before crossing"],
    );
    let car = format!("vehicle av {{ {car} }}");
    // What repeats another stream needs that.
    let (stream, other) = match said {
        repeats if repeats.starts_with("repeats") => (
            vec![],
            "stream cars { speed 30 km/h; controller commotions; first 2 s before crossing; gaps 3 s, then 4 s }",
        ),
        _ => (
            vec!["speed 30 km/h", "controller commotions", "first 2 s before crossing", "gaps 3 s, then 4 s"],
            "",
        ),
    };
    let stream = format!("stream traffic {{ {} }}", block(BlockKind::Stream, &stream));
    // What is said of somebody who walks along a lane is not said alone.
    let person: &[&str] = match said {
        along if along.starts_with("meets") && along.contains(" after ") => {
            &["model commotions", "walks with traffic", "goal 40 m further"]
        }
        along if along.starts_with("walks") || along.ends_with("further") => {
            &["model commotions", "start 1 m from kerb", "walks with traffic", "goal 40 m further"]
        }
        _ => &["model commotions", "start 1 m from kerb"],
    };
    let person = block(BlockKind::Pedestrian, person);
    let person = format!("pedestrian walker {{ {person} }}");
    let scenario = block(BlockKind::Scenario, &[&road, &car, other, &stream, &person, "repeat 2"]);
    let street = "road NAME { lanes 1; lane_width 3 m; speed_limit 30 km/h; crossing zebra }\n";
    format!("{street}scenario a {{ {scenario} }}\n")
}

/// What is said of a road that lies over another, or of who drives there.
fn on_another_road(kind: BlockKind, said: &str) -> Option<String> {
    const OVER: &str = "over main { at: 20 m }";
    let (over, car) = match (kind, said) {
        (BlockKind::Road, over) if over.starts_with("over") => {
            (over, "on side; start 60 m before junction".into())
        }
        (BlockKind::Vehicle, "on side") => (OVER, "on side; start 60 m before junction".into()),
        (BlockKind::Vehicle, start) if start.ends_with("before junction") => {
            (OVER, format!("on side; {start}"))
        }
        _ => return None,
    };
    Some(format!(
        "road main {{ lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }}
road side {{ {over}; lane_width 3 m; speed_limit 30 km/h }}
scenario a {{
  road main
  vehicle av {{ controller carla_behavior; speed 30 km/h; {car} }}
  pedestrian walker {{ model commotions; start 1 m from kerb }}
  repeat 2
}}
"
    ))
}

/// What the only scenario of a text says, wherever it stands.
fn meaning(text: &str) -> (scenario::Scenario, serde_json::Value) {
    fn forget(value: &mut serde_json::Value) {
        if let Some(fields) = value.as_object_mut() {
            fields.retain(|name, _| name != "origin");
            fields.values_mut().for_each(forget);
        }
        value.as_array_mut().into_iter().flatten().for_each(forget);
    }
    let loaded = load(Path::new("a.scn"), &standard(), &Memory::default().with("a.scn", text));
    let suite = loaded.unwrap_or_else(|failure| panic!("{text}{}", failure.render(Style::default()))).suite;
    let scenario = suite.scenarios.into_iter().next().unwrap();
    let mut value = serde_json::to_value(&scenario).unwrap();
    forget(&mut value);
    // The name of the road is not kept.
    value["road"]["name"] = serde_json::Value::Null;
    (scenario, value)
}

/// The example with its first number one larger, so that it says something else than what is so anyway.
fn unusual(usage: &str) -> String {
    let Some(start) = usage.find(|c: char| c.is_ascii_digit()) else { return usage.to_string() };
    let end = usage[start..].find(|c: char| !c.is_ascii_digit()).map_or(usage.len(), |end| start + end);
    let number: u32 = usage[start..end].parse().unwrap();
    format!("{}{}{}", &usage[..start], number + 1, &usage[end..])
}

#[test]
fn it_is_written_so_that_it_is_read_back() {
    /// What is put in before a scenario is written, or stands in it as a text of its own.
    const PUT_IN: [&str; 6] = ["let", "vary", "vary together", "draw", "draw together from", "expect"];
    let plain = meaning(&with(BlockKind::Scenario, "repeat 2")).1;
    for kind in
        [BlockKind::Road, BlockKind::Scenario, BlockKind::Vehicle, BlockKind::Stream, BlockKind::Pedestrian]
    {
        let statements = kind.block().statements.iter();
        for statement in statements.filter(|one| !PUT_IN.contains(&one.words)) {
            // Gaps that are drawn or in a file are put in, too.
            let is_written =
                |usage: &&str| !usage.contains('…') && !usage.contains("from \"") && !usage.contains("drawn");
            for usage in statement.usages().filter(is_written) {
                let (scenario, said) = meaning(&with(kind, &unusual(usage)));
                assert_ne!(said, plain, "`{usage}` changes nothing");
                let written = write_scenario(&scenario, &[], &[], std::path::Path::new(""));
                assert_eq!(meaning(&written).1, said, "{written}");
            }
        }
    }
}
