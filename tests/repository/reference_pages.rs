//! `docs/words.md` and `docs/codes.md` are what the language says of itself. `UPDATE_DOCS=1 cargo test --test repository reference_pages`
//! rewrites them.

use std::fmt::Write;

use lang::{Code, Severity};

use crate::generated::stands_in;

const CODES: &str = "\
# Errors and warnings

Every code that a finding may have. `scenario-runner explain E0402` says the same in the terminal. Nothing is run while there is an error; a warning says that
something may not be what was meant.
";

#[test]
fn every_statement_has_its_place_in_the_page_of_statements() {
    stands_in("docs/words.md", &lang::reference());
}

#[test]
fn every_code_has_its_place_in_the_page_of_codes() {
    let mut page = CODES.to_string();
    for (severity, heading) in [(Severity::Error, "Errors"), (Severity::Warning, "Warnings")] {
        writeln!(page, "\n## {heading}").unwrap();
        for code in Code::ALL.iter().filter(|code| code.severity() == severity) {
            writeln!(page, "\n### {code}: {}\n\n{}", code.title(), code.explanation()).unwrap();
        }
    }
    stands_in("docs/codes.md", &page);
}
