//! The reference of filter expressions, from the registry of predicates: what `help filter` prints.

use super::predicate::{PREDICATES, Predicate};

const BEFORE: &str = r#"# Filter expressions

`-E EXPRESSION` says which trials a command is about:

    scenario-runner suites/*.suite -E 'scenario(walker) & tag(paper) - model(jaywalker)'
    scenario-runner suites/*.suite -E 'variation(tta >= 10 s)' --list
    scenario-runner list suites/*.suite -E 'controller(carla_*) | kind(search)'

`-E` may be given several times; what any of them selects is meant. Other words on the command line select by a part of
the trial's name; with both, a trial must be selected by `-E` and by its name. Single quotes keep the shell from
reading the expression.

## Predicates

"#;

const AFTER: &str = r#"
## Patterns

- `=text` is the whole name
- `~text` is a part of the name
- `#glob` is a pattern with `*`, `?` and `[abc]`
- `/regex/` is a regular expression that matches somewhere in the name
- text without a mark is compared as the predicate says above

Upper and lower case differ. A bracket in a pattern is written `\(` or `\)`.

## Operators

- `!a` or `not a`: what `a` does not select; binds most tightly
- `a & b` or `a and b`: what both select
- `a - b`: what `a` selects and `b` does not; binds as `&` does
- `a | b`, `a + b` or `a or b`: what at least one selects; binds least tightly

Round brackets group: `tag(paper) & (model(commotions) | model(jaywalker))`.

A predicate that matches nothing in the files that are loaded gives a warning; an expression that selects nothing ends
the program with exit code 4.
"#;

/// In Markdown, made to be read in a terminal too.
pub fn reference() -> String {
    let mut text = BEFORE.to_string();
    for Predicate { default, example, doc, .. } in PREDICATES {
        let how = match default {
            None => String::new(),
            Some(mark) => format!("; without a mark {}", mark.sign()),
        };
        text.push_str(&format!("- `{example}`{how}  \n  {}\n", doc.replace('\n', "\n  ")));
    }
    text.push_str(AFTER);
    text
}
