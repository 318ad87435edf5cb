//! `docs/models/` says what the registries say: fails when a page is missing, empty or out of date.
//!
//! `UPDATE_DOCS=1 cargo test --test repository model_pages` rewrites the generated parts; what a model is and is not is written by
//! hand above them.

use std::fs;
use std::path::{Path, PathBuf};

use models::standard;
use report::{ModelPage, model_pages};

const BEGIN: &str = "<!-- Generated from the registry: change the declaration, then `UPDATE_DOCS=1 cargo test --test repository model_pages`. -->";
const SECTIONS: [&str; 2] = ["## What it is", "## What it is not"];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/models")
}

fn title(page: &ModelPage) -> String {
    format!("# `{}` ({})", page.name, page.kind)
}

fn generated(page: &ModelPage) -> String {
    format!("{BEGIN}\n\n## Declaration\n\n{}", page.reference)
}

/// The overview, which is generated as a whole.
fn index(pages: &[ModelPage]) -> String {
    let mut text = format!("# Models\n\n{BEGIN}\n");
    let kinds = [
        ("pedestrian", "Pedestrian models"),
        ("controller", "Controllers"),
        ("dynamics", "Vehicle dynamics"),
        ("perception", "Perception"),
    ];
    for (kind, heading) in kinds {
        text += &format!("\n## {heading}\n\n");
        for page in pages.iter().filter(|page| page.kind == kind) {
            text += &format!("- [`{}`]({}): {}\n", page.name, page.file_name(), page.summary);
        }
    }
    text
}

/// What is wrong with a page's hand-written part.
fn prose_problem(page: &ModelPage, prose: &str) -> Option<String> {
    if !prose.starts_with(&title(page)) {
        return Some(format!("does not begin with `{}`", title(page)));
    }
    SECTIONS.iter().find_map(|section| {
        let heading = format!("{section}\n");
        let Some((_, after)) = prose.split_once(&heading) else {
            return Some(format!("has no section `{section}`"));
        };
        let written = after.split("\n## ").next().unwrap_or_default().trim();
        (written.len() < 80).then(|| format!("says too little under `{section}`"))
    })
}

#[test]
fn pages_are_there_and_up_to_date() {
    let update = std::env::var_os("UPDATE_DOCS").is_some();
    let pages = model_pages(&standard());
    let mut problems = Vec::new();
    if update {
        fs::create_dir_all(folder()).unwrap();
        fs::write(folder().join("README.md"), index(&pages)).unwrap();
    }
    for page in &pages {
        let path = folder().join(page.file_name());
        let text = fs::read_to_string(&path).unwrap_or_default();
        let prose = text.split(BEGIN).next().unwrap_or_default().trim_end();
        if update {
            let prose = if prose.is_empty() { title(page) } else { prose.to_string() };
            fs::write(&path, format!("{prose}\n\n{}", generated(page))).unwrap();
        }
        if let Some(problem) = prose_problem(page, prose) {
            problems.push(format!("docs/models/{} {problem}", page.file_name()));
        }
        if !update && !text.ends_with(&generated(page)) {
            problems.push(format!("docs/models/{} is not what the registry says", page.file_name()));
        }
    }
    if !update && fs::read_to_string(folder().join("README.md")).unwrap_or_default() != index(&pages) {
        problems.push("docs/models/README.md is not what the registry says".to_string());
    }
    for entry in fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name != "README.md" && !pages.iter().any(|page| page.file_name() == name) {
            problems.push(format!("docs/models/{name} is about nothing that is registered"));
        }
    }
    assert!(
        problems.is_empty(),
        "\n{}\n\nrun `UPDATE_DOCS=1 cargo test --test repository model_pages`, then write {} above the generated part\n",
        problems.join("\n"),
        SECTIONS.map(|section| format!("`{section}`")).join(" and ")
    );
}
