//! Suites: which scenarios belong to them.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::blocks::{Gathered, gather};
use super::check::{self, TextPlaces};
use super::codes::{Code, Severity};
use super::diagnostic::{Diagnostic, Remedy};
use super::file_kind::{FileKind, file_kind};
use super::source::Span;
use super::syntax::ast;
use super::texts::{FileId, NameDefinition, Texts, join};
use super::value;
use scenario::registry::Registry;
use scenario::{Dimension, Scenario, Suite};

/// The seed of a suite that names none, and of a scenario file that is run by itself.
pub const DEFAULT_SEED: u64 = 1;

const MOST_FILES: usize = 20_000;

/// So many files are parsed side by side and held until they are opened.
const AHEAD: usize = 1024;

/// The suite that the file is: what it declares, or all scenarios of a scenario file.
pub fn suite(
    files: &mut Texts,
    file: FileId,
    path: &Path,
    kind: FileKind,
    report: &mut Vec<Diagnostic>,
) -> Option<Suite> {
    match kind {
        FileKind::Scenarios => bare(files, file, path, report),
        FileKind::Yaml if files.tree(file).file().suites().next().is_none() => {
            bare(files, file, path, report)
        }
        FileKind::Suite | FileKind::Yaml => declared(files, file, path, report),
    }
}

fn own_scenarios(files: &Texts, file: FileId) -> Vec<NameDefinition> {
    let mut found: Vec<ast::Scenario> = Vec::new();
    for node in files.tree(file).root().parts::<ast::HoldsScenarios>() {
        match node {
            ast::HoldsScenarios::Scenario(scenario) => found.push(scenario),
            ast::HoldsScenarios::Suite(suite) => found.extend(suite.block().scenarios()),
        }
    }
    let own = found.into_iter().filter(|scenario| !scenario.is_template());
    own.map(|node| NameDefinition { file, node: node.index(), span: node.name().span() }).collect()
}

fn bare(files: &Texts, file: FileId, path: &Path, report: &mut Vec<Diagnostic>) -> Option<Suite> {
    let root = files.tree(file).file();
    for suite in root.suites() {
        report.push(
            Diagnostic::new(Code::MisplacedSuite, suite.name().span(), "a suite stands in a scenario file")
                .label("not here")
                .hint("put it into a file ending in `.suite`"),
        );
    }
    let mut definitions = own_scenarios(files, file);
    let blocks = gather(files, &[file], &definitions);
    if definitions.is_empty() && blocks.is_empty() && !super::texts::has_errors(report) {
        report.push(no_scenario(Span::beginning(root.span().source), files));
    }
    definitions.extend(&blocks.measured);
    let scenarios = check_all(files, &definitions, None, report);
    warn_of_nothing_expected(files, &definitions, scenarios.iter(), &blocks, report);
    let supporting = supporting(files, &blocks, report);
    let tested = check::tested(&TextPlaces { files }, scenarios.iter().chain(&supporting), report);
    check_definitions(files, report);
    definitions.extend(&blocks.supporting);
    let declared = declared_names(files, &definitions, &blocks, &[]);
    let blocks = blocks.check(files, &definitions, [&scenarios, &supporting], report);
    let name = path.file_stem().map_or_else(|| "scenarios".into(), |stem| stem.to_string_lossy());
    let suite = Suite {
        name: name.into_owned(),
        apart: String::new(),
        doc: None,
        seed: DEFAULT_SEED,
        set: Vec::new(),
        tested,
        time_limit: None,
        scenarios,
        supporting,
        searches: blocks.searches,
        tunes: blocks.tunes,
        evaluates: blocks.evaluates,
        calibrates: blocks.calibrates,
        estimates: blocks.estimates,
        statements: blocks.statements,
        gates: Vec::new(),
        ratings: Vec::new(),
        controllers: Vec::new(),
        notations: Vec::new(),
        texts: Vec::new(),
        origin: files.sources.origin(Span::beginning(root.span().source)),
    };
    reject_lost(&declared, &suite, report);
    Some(suite)
}

fn no_scenario(span: Span, files: &Texts) -> Diagnostic {
    let name = &files.sources.get(span.source).name;
    Diagnostic::new(Code::NoScenario, span, format!("`{name}` declares no scenario"))
        .label("nothing to run")
        .hint("add `scenario NAME { … }`; files with only roads and templates are for `use`")
}

fn declared(files: &mut Texts, file: FileId, path: &Path, report: &mut Vec<Diagnostic>) -> Option<Suite> {
    let source = files.tree(file).source;
    let suites: Vec<_> = files.tree(file).file().suites().collect();
    if let [first, others @ ..] = suites.as_slice() {
        let first = first.name().span();
        for other in others {
            report.push(
                Diagnostic::new(Code::SeveralSuites, other.name().span(), "a file holds one suite")
                    .label("a second one")
                    .context(first, "the first one")
                    .hint("put it into a file of its own"),
            );
        }
    } else if !files.tree(file).root().has_bad() && report.is_empty() {
        report.push(
            Diagnostic::new(Code::MissingSuite, Span::beginning(source), "this file declares no suite")
                .label("nothing to run")
                .hint("add `suite NAME { scenarios \"../scenarios/*.scn\" }`"),
        );
    }
    let patterns = patterns(*suites.first()?);
    let included = open_all(files, path, &patterns, report);
    let mut definitions = own_scenarios(files, file);
    for (included, asked) in &included {
        let own = own_scenarios(files, *included);
        let root = files.tree(*included).root();
        let has_blocks = !gather(files, &[*included], &[]).is_empty();
        if own.is_empty() && !has_blocks && !root.has_bad() {
            let diagnostic = no_scenario(Span::beginning(root.span().source), files);
            report.push(diagnostic.context(*asked, "included here"));
        }
        definitions.extend(own);
    }

    files.tests.suite = Some(file);
    let files = &*files;
    let all_files: Vec<FileId> =
        std::iter::once(file).chain(included.iter().map(|(file, _)| *file)).collect();
    let blocks = gather(files, &all_files, &definitions);
    definitions.extend(&blocks.measured);
    let all_definitions = [definitions.as_slice(), &blocks.supporting].concat();
    reject_duplicates(files, &all_definitions, report);
    let node = files.tree(file).file().suites().next()?;
    let (name, block) = (node.name(), node.block());
    check::reject_repeats(*block, report);
    if definitions.is_empty() && patterns.is_empty() && blocks.is_empty() && !block.has_bad() {
        report.push(
            Diagnostic::new(
                Code::EmptySuite,
                name.span(),
                format!("suite `{}` has no scenarios", name.text()),
            )
            .label("tests nothing")
            .hint("add `scenarios \"../scenarios/*.scn\"` or a `scenario`"),
        );
    }
    let seed = match block.seed() {
        Some(seed) => check::whole(seed.number(), report),
        None => Some(DEFAULT_SEED),
    };
    let time_limit = block.time_limit().map(|limit| {
        let (limit, what) = (limit.value(), "the time limit");
        value::constant_in(limit, Dimension::TIME, (0.001, 86_400.0), what, files.scope(file), report)
    });
    let criteria: Vec<ast::Criterion> =
        block.expects().flat_map(|expect| expect.block().criteria()).collect();
    let added = check::SuiteCriteria { nodes: &criteria, scope: files.scope(file) };
    let mut scenarios = check_all(files, &definitions, Some(added), report);
    let earning: Vec<&str> = block
        .ratings()
        .flat_map(|rating| rating.block().points())
        .flat_map(ast::Points::each)
        .map(|one| one.tag().text())
        .collect();
    let rated = |scenario: &Scenario| scenario.tags.iter().any(|tag| earning.contains(&tag.as_str()));
    warn_of_nothing_expected(
        files,
        &definitions,
        scenarios.iter().filter(|one| !rated(one)),
        &blocks,
        report,
    );
    let supporting = supporting(files, &blocks, report);
    let tested = check::tested(&TextPlaces { files }, scenarios.iter().chain(&supporting), report);
    let tags = check::tags(block.tags());
    for scenario in &mut scenarios {
        for tag in &tags {
            if !scenario.tags.contains(tag) {
                scenario.tags.push(tag.clone());
            }
        }
    }
    let gate_nodes: Vec<ast::Gate> = block.gates().collect();
    let declared = declared_names(files, &all_definitions, &blocks, &gate_nodes);
    let blocks = blocks.check(files, &all_definitions, [&scenarios, &supporting], report);
    let drivers: Vec<String> = scenarios.iter().flat_map(check::drivers).collect();
    let cast = everybody(&scenarios, &drivers, &files.registry);
    let mut gate_names: HashMap<&str, Span> = HashMap::new();
    let gates: Vec<_> = gate_nodes
        .into_iter()
        .map(|node| {
            reject_duplicate(node.name(), &mut gate_names, report);
            check::gate(node, &cast, files.scope(file), &TextPlaces { files }, report)
        })
        .collect();
    let complete = !super::texts::has_errors(report);
    let rated = check::RatedScenarios { scenarios: &scenarios, definitions: &definitions, complete };
    let mut rating_names: HashMap<&str, Span> = HashMap::new();
    let ratings: Vec<_> = block
        .ratings()
        .map(|node| {
            reject_duplicate(node.name(), &mut rating_names, report);
            let rating = check::rating(node, &rated, &cast, files.scope(file), &TextPlaces { files }, report);
            // Whatever the reason, one that is declared is judged or is an error.
            if rating.is_none() && !super::texts::has_errors(report) {
                let (name, span) = (node.name().text(), node.name().span());
                let message = format!("rating `{name}` cannot be read");
                report.push(Diagnostic::new(Code::BadRating, span, message).label("not understood"));
            }
            rating
        })
        .collect();
    if !super::texts::has_errors(report) {
        let before = report.len();
        reject_idle_criteria(files, &criteria, &scenarios, report);
        if !files.overrides.is_empty() {
            check::set_aside(&mut report[before..]);
        }
    }
    check_definitions(files, report);
    let suite = Suite {
        name: name.text().to_string(),
        apart: String::new(),
        doc: check::doc(block.doc()),
        seed: seed?,
        set: Vec::new(),
        tested,
        time_limit: match time_limit {
            Some(limit) => Some(limit?),
            None => None,
        },
        scenarios,
        supporting,
        searches: blocks.searches,
        tunes: blocks.tunes,
        evaluates: blocks.evaluates,
        calibrates: blocks.calibrates,
        estimates: blocks.estimates,
        statements: blocks.statements,
        gates: gates.into_iter().flatten().collect(),
        ratings: ratings.into_iter().flatten().collect(),
        controllers: Vec::new(),
        notations: Vec::new(),
        texts: Vec::new(),
        origin: files.sources.origin(name.span()),
    };
    reject_lost(&declared, &suite, report);
    Some(suite)
}

/// What files declare to be run or judged: scenarios, blocks and gates, by their names, which no two of them share.
fn declared_names(
    files: &Texts,
    definitions: &[NameDefinition],
    blocks: &Gathered,
    gates: &[ast::Gate],
) -> Vec<(String, Span)> {
    let scenarios = definitions.iter().map(|one| (files.scenario(*one).name().text(), one.span));
    let gates = gates.iter().map(|gate| (gate.name().text(), gate.name().span()));
    let all = scenarios.chain(blocks.names()).chain(gates);
    all.map(|(name, span)| (name.to_string(), span)).collect()
}

/// Whatever the reason, what is declared is in the suite, or there is an error: it would neither run nor fail.
fn reject_lost(declared: &[(String, Span)], suite: &Suite, report: &mut Vec<Diagnostic>) {
    if super::texts::has_errors(report) {
        return;
    }
    let scenarios = suite.scenarios.iter().chain(&suite.supporting).map(|one| one.name.as_str());
    let searches = suite.searches.iter().map(|one| one.name.as_str());
    let tunes = suite.tunes.iter().map(|one| one.name.as_str());
    let evaluates = suite.evaluates.iter().map(|one| one.name.as_str());
    let calibrates = suite.calibrates.iter().map(|one| one.name.as_str());
    let estimates = suite.estimates.iter().map(|one| one.name.as_str());
    let statements = suite.statements.iter().map(|one| one.name.as_str());
    let gates = suite.gates.iter().map(|one| one.name.as_str());
    let blocks = searches.chain(tunes).chain(evaluates).chain(calibrates).chain(estimates).chain(statements);
    let known: HashSet<&str> = scenarios.chain(blocks).chain(gates).collect();
    for (name, span) in declared.iter().filter(|(name, _)| !known.contains(name.as_str())) {
        let message = format!("`{name}` cannot be read");
        let hint = "nothing says why: this is a defect of the program, which should have said it";
        report.push(Diagnostic::new(Code::UnexpectedText, *span, message).label("not understood").hint(hint));
    }
}

/// Every road user of any scenario.
fn everybody<'a>(
    scenarios: &'a [Scenario],
    drivers: &'a [String],
    registry: &'a Registry,
) -> check::Cast<'a> {
    check::Cast {
        vehicles: drivers.iter().map(String::as_str).collect(),
        pedestrians: scenarios
            .iter()
            .flat_map(|s| &s.pedestrians)
            .map(|person| person.name.as_str())
            .collect(),
        groups: check::groups(scenarios.iter().flat_map(|s| &s.pedestrians)),
        streams: scenarios.iter().flat_map(Scenario::streams).map(|stream| stream.name.as_str()).collect(),
        boxes: scenarios.iter().flat_map(|s| &s.road.boxes).map(|body| body.name.as_str()).collect(),
        individuals: None,
        are_drawn: false,
        metrics: registry.metrics(),
    }
}

/// What a suite gives `scenarios` by, each with its place.
fn patterns(suite: ast::Suite) -> Vec<(String, Span)> {
    let all = suite.block().files().flat_map(ast::SuiteFiles::patterns);
    all.map(|pattern| (pattern.path(), pattern.span())).collect()
}

/// The files that the patterns of a suite match, as far as they can be read.
pub fn included(files: &mut Texts, file: FileId, path: &Path) -> Vec<FileId> {
    let Some(patterns) = files.tree(file).file().suites().next().map(patterns) else { return Vec::new() };
    open_all(files, path, &patterns, &mut Vec::new()).into_iter().map(|(file, _)| file).collect()
}

/// Every file that a suite's patterns match, each once, with the pattern's place.
fn open_all(
    files: &mut Texts,
    path: &Path,
    patterns: &[(String, Span)],
    report: &mut Vec<Diagnostic>,
) -> Vec<(FileId, Span)> {
    let mut opened: Vec<(FileId, Span)> = Vec::new();
    let mut seen: HashSet<FileId> = HashSet::new();
    let texts = files.texts();
    for (pattern, span) in patterns {
        let full = pattern_path(path, pattern);
        let paths = match texts.matching(&full) {
            Ok(paths) => paths,
            Err(error) => {
                report.push(
                    Diagnostic::new(
                        Code::BadPattern,
                        *span,
                        format!("`{pattern}` is no file pattern: {}", error.msg),
                    )
                    .label("malformed")
                    .hint("patterns know `*`, `**`, `?` and `[abc]`"),
                );
                continue;
            }
        };
        let mut matched = 0;
        let (mut scenes, mut others): (Vec<PathBuf>, Vec<PathBuf>) = Default::default();
        let mut too_many = None;
        // Folders count as well: `/**` would go through all there are.
        for (place, found) in paths.enumerate() {
            let is_file = texts.is_file(&found);
            matched += usize::from(is_file);
            if place >= MOST_FILES {
                too_many = Some(
                    Diagnostic::new(
                        Code::TooManyFiles,
                        *span,
                        format!("`{pattern}` matches more than {MOST_FILES} files and folders"),
                    )
                    .label("too many files")
                    .hint("name the folder more closely"),
                );
                break;
            }
            if !is_file {
                continue;
            }
            match file_kind(&found) {
                Some(FileKind::Scenarios | FileKind::Yaml) => scenes.push(join(&found, &file_name(&found))),
                _ => others.push(found),
            }
        }
        for some in scenes.chunks(AHEAD) {
            files.parse_ahead(some.iter().map(PathBuf::as_path));
            for path in some {
                if let Some(file) = files.open(path, Some(*span), report)
                    && seen.insert(file)
                {
                    opened.push((file, *span));
                }
            }
        }
        report.extend(too_many);
        report.extend(no_scenarios(pattern, *span, &others));
        if matched == 0 {
            report.push(
                Diagnostic::new(Code::NothingMatches, *span, format!("`{pattern}` matches no file"))
                    .label("nothing there")
                    .note(format!("looked for {full}"))
                    .hint("patterns are relative to the folder of the suite's file"),
            );
        }
    }
    opened
}

/// About files that a pattern matches and that are no scenarios. What lies elsewhere than below the suite is not named.
fn no_scenarios(pattern: &str, span: Span, found: &[PathBuf]) -> Option<Diagnostic> {
    let message = match found {
        [] => return None,
        [one] if !Path::new(pattern).is_absolute() => format!("`{}` is not a scenario file", one.display()),
        _ => format!("`{pattern}` matches {} files that are no scenarios", found.len()),
    };
    let diagnostic = Diagnostic::new(Code::UnknownFileKind, span, message).label("matches it");
    Some(diagnostic.hint("let the pattern end in `.scn` or `.yaml`"))
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// The pattern seen from where the program runs; special characters of the suite's own folder stand for themselves.
fn pattern_path(path: &Path, pattern: &str) -> String {
    let folder = path.parent().map_or_else(String::new, |folder| folder.display().to_string());
    if folder.is_empty() || Path::new(pattern).is_absolute() {
        return pattern.to_string();
    }
    format!("{}/{pattern}", glob::Pattern::escape(&folder))
}

fn reject_duplicates(files: &Texts, definitions: &[NameDefinition], report: &mut Vec<Diagnostic>) {
    let mut names: HashMap<&str, NameDefinition> = HashMap::new();
    for definition in definitions {
        let name = files.scenario(*definition).name();
        if let Some(first) = names.insert(name.text(), *definition)
            && first.file != definition.file
        {
            report.push(
                Diagnostic::new(
                    Code::DuplicateScenario,
                    name.span(),
                    format!("the suite has two scenarios `{}`", name.text()),
                )
                .label("the second one")
                .context(first.span, "the first one")
                .hint("rename one of them: the name is part of the key of every run"),
            );
        }
    }
}

/// Scenarios that blocks know, by name: in whatever order the blocks stand, the suite is the same.
fn supporting(files: &Texts, blocks: &Gathered, report: &mut Vec<Diagnostic>) -> Vec<Scenario> {
    let mut scenarios = check_all(files, &blocks.supporting, None, report);
    scenarios.sort_by(|one, other| one.name.cmp(&other.name));
    scenarios
}

/// Checks scenarios side by side; what several of them would report of the same place is reported once.
fn check_all(
    files: &Texts,
    definitions: &[NameDefinition],
    added: Option<check::SuiteCriteria>,
    report: &mut Vec<Diagnostic>,
) -> Vec<Scenario> {
    let places = TextPlaces { files };
    let mut seen: HashSet<(Code, Span, String)> = HashSet::new();
    let mut scenarios = Vec::with_capacity(definitions.len());
    let check = |definition: &NameDefinition| {
        let mut findings = Vec::new();
        (check::scenario(*definition, &places, added, &mut findings), findings)
    };
    for (scenario, findings) in definitions.par_iter().map(check).collect::<Vec<_>>() {
        scenarios.extend(scenario);
        report.extend(
            findings
                .into_iter()
                .filter(|finding| seen.insert((finding.code, finding.span(), finding.message.clone()))),
        );
    }
    scenarios
}

/// Warns of those of `scenarios` of which nothing is claimed, unless a block is about them.
fn warn_of_nothing_expected<'s>(
    files: &Texts,
    definitions: &[NameDefinition],
    scenarios: impl Iterator<Item = &'s Scenario>,
    blocks: &Gathered,
    report: &mut Vec<Diagnostic>,
) {
    let idle: HashSet<&str> = scenarios
        .filter(|scenario| scenario.criteria.is_empty())
        .map(|scenario| scenario.name.as_str())
        .filter(|name| !blocks.are_about(name))
        .collect();
    for definition in definitions {
        let node = files.scenario(*definition);
        let name = node.name();
        if idle.contains(name.text()) && !node.is_broken() {
            report.push(
                Diagnostic::new(
                    Code::NoCriteria,
                    definition.span,
                    format!("scenario `{}` expects nothing", name.text()),
                )
                .label("run, but not judged")
                .hint("add `expect { no collision }`")
                .remedy(Remedy::SayInside("expect { no collision }".to_string())),
            );
        }
    }
}

fn reject_duplicate<'a>(
    name: ast::Name<'a>,
    names: &mut HashMap<&'a str, Span>,
    report: &mut Vec<Diagnostic>,
) {
    if let Some(first) = names.insert(name.text(), name.span()) {
        report.push(
            Diagnostic::new(Code::DuplicateName, name.span(), format!("`{}` is defined twice", name.text()))
                .label("defined again")
                .context(first, "defined first here")
                .hint("give one of them another name"),
        );
    }
}

/// What a template may lack, or what may depend on the scenario that builds on it.
const IN_TEMPLATES: [Code; 14] = [
    Code::UnknownName,
    Code::UnknownVehicle,
    Code::UnknownPedestrian,
    Code::UnknownVariation,
    Code::MissingStatement,
    Code::NoSuchLane,
    Code::NoStart,
    Code::NobodyThere,
    Code::DoesNotFit,
    Code::NoIndividuals,
    Code::StartBeyondGoal,
    Code::StartContradiction,
    Code::TooFewRuns,
    Code::NotSequential,
];

/// Checks roads and templates that no scenario may have used.
fn check_definitions(files: &Texts, report: &mut Vec<Diagnostic>) {
    let places = TextPlaces { files };
    let mut known: HashSet<(Code, Span, String)> =
        report.iter().map(|finding| (finding.code, finding.span(), finding.message.clone())).collect();
    let mut findings = Vec::new();
    for file in files.ids() {
        for node in files.tree(file).file().roads() {
            let definition = NameDefinition { file, node: node.index(), span: node.name().span() };
            check::check_road(definition, &places, &mut findings);
        }
        for node in files.tree(file).file().scenarios().filter(|one| one.is_template()) {
            let definition = NameDefinition { file, node: node.index(), span: node.name().span() };
            let mut own = Vec::new();
            check::scenario(definition, &places, None, &mut own);
            own.retain(|finding| {
                finding.severity == Severity::Error && !IN_TEMPLATES.contains(&finding.code)
            });
            findings.extend(own);
        }
    }
    report.extend(
        findings
            .into_iter()
            .filter(|finding| known.insert((finding.code, finding.span(), finding.message.clone()))),
    );
}

/// Criteria of the suite that apply to none of its scenarios.
fn reject_idle_criteria(
    files: &Texts,
    criteria: &[ast::Criterion],
    scenarios: &[Scenario],
    report: &mut Vec<Diagnostic>,
) {
    let applied: HashSet<_> = scenarios
        .iter()
        .flat_map(|scenario| &scenario.criteria)
        .map(|criterion| (&*criterion.origin.file, criterion.origin.line, criterion.origin.column))
        .collect();
    for node in criteria {
        let place = files.sources.location(node.span());
        let file = files.sources.get(node.span().source).name.as_str();
        if !applied.contains(&(file, place.line, place.column)) {
            report.push(
                Diagnostic::new(Code::NeverApplies, node.span(), "this applies to no scenario of the suite")
                    .label("never checked")
                    .hint("its `when` must be about something that a scenario varies"),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use files::{Files, Memory};
    use models::standard;

    use super::*;
    use crate::source::Sources;

    #[test]
    fn nothing_that_is_declared_is_lost_without_an_error() {
        let text = "scenario a {\n  road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }\n  vehicle av { controller yielding; speed 30 km/h; start 60 m before crossing }\n  pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }\n  expect { no collision }\n}\n";
        let loaded =
            crate::load(Path::new("a.scn"), &standard(), &Memory::default().with("a.scn", text)).unwrap();
        let mut sources = Sources::default();
        let span = Span::beginning(sources.add("a.scn", text));
        let lost = |names: &[&str], mut report: Vec<Diagnostic>| {
            let declared: Vec<_> = names.iter().map(|name| (name.to_string(), span)).collect();
            let before = report.len();
            reject_lost(&declared, &loaded.suite, &mut report);
            report.split_off(before).into_iter().map(|found| found.message).collect::<Vec<_>>()
        };
        assert_eq!(lost(&["a"], Vec::new()), Vec::<String>::new());
        assert_eq!(lost(&["a", "b"], Vec::new()), ["`b` cannot be read"]);
        // Where something else is an error, that is why.
        let other = Diagnostic::new(Code::UnexpectedText, span, "other");
        assert_eq!(lost(&["b"], vec![other]), Vec::<String>::new());
    }

    #[test]
    fn files_that_are_parsed_ahead_say_what_they_say_one_after_the_other() {
        let whole = "scenario NAME { road { lane_width 4 m; speed_limit 30 km/h; crossing zebra } vehicle av { controller yielding; speed 30 km/h; start 60 m before crossing } pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s } expect { no collision } }";
        let suite = "suite all { scenarios \"s/*.scn\", \"s/a*.scn\", \"s/*.yaml\" }";
        let files = Memory::default()
            .with("all.suite", suite)
            .with("s/a1.scn", whole.replace("NAME", "a1"))
            // Twice, unfinished, nothing in it, a circle, and what uses another that is matched as well.
            .with("s/a2.scn", whole.replace("NAME", "a1"))
            .with("s/b.scn", whole.replace("NAME", "b").replace("30 km/h", "30 kmh"))
            .with("s/c.scn", "scenario c { road {")
            .with("s/d.scn", "")
            .with("s/e.scn", "use \"f.scn\"\n".to_string() + &whole.replace("NAME", "e"))
            .with("s/f.scn", "use \"e.scn\"\n".to_string() + &whole.replace("NAME", "f"))
            .with("s/g.scn", "use \"a1.scn\"\nscenario g like a1 { }")
            .with("s/h.yaml", "scenarios: [");
        let path = Path::new("all.suite");
        let told = |examined: crate::Examined| {
            let style = crate::Style { colour: false };
            let found = examined.found.iter().map(|one| crate::render(one, &examined.sources, style));
            (found.collect::<Vec<_>>(), examined.suite.map(|suite| format!("{suite:?}")))
        };
        let ahead = told(crate::examine(path, &standard(), &files));
        // While a text is edited nothing is parsed ahead.
        assert_eq!(ahead, told(crate::examine_edited(path, suite, &standard(), &files)));
        assert!(ahead.0.len() > 4, "{:#?}", ahead.0);
        let names = ["a1", "g"].map(|name| format!("s/{name}.scn"));
        let sound = names.iter().fold(Memory::default().with("all.suite", suite), |sound, name| {
            sound.with(
                name,
                String::from_utf8(files.read(Path::new(name), &["scn"], 1 << 20).unwrap()).unwrap(),
            )
        });
        let sound = sound.with("s/h.yaml", "scenarios: []");
        let ahead = told(crate::examine(path, &standard(), &sound));
        assert_eq!(ahead, told(crate::examine_edited(path, suite, &standard(), &sound)));
    }
    /// What several scenarios would say of one place is said once, in the order in which they stand.
    #[test]
    fn what_is_found_does_not_depend_on_how_many_look_for_it() {
        let wrong =
            ["speed 30 kmh", "speed fast", "lane 7", "speed pace", "controller nobody", "speed unused"];
        let scenario = |index: usize| {
            format!(
                "scenario s{index} : base(pace: {index} m) {{ let unused = 1 m/s\n vehicle av {{ {} }} expect {{ no collision\n pet > {index} }} }}\n",
                wrong[index % wrong.len()]
            )
        };
        let base = "define base(pace) { road { lane_width 4 m; speed_limit 30 km/h; crossing zebra } vehicle av { controller yielding; speed pace; start 60 m before crossing } pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s } }\n";
        let text: String = std::iter::once(base.to_string()).chain((0..200).map(scenario)).collect();
        let files = Memory::default().with("all.scn", text);
        let examined = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let examined = pool.install(|| crate::examine(Path::new("all.scn"), &standard(), &files));
            format!("{:?} {:?}", examined.found, examined.suite)
        };
        let alone = examined(1);
        assert!(alone.matches("Diagnostic {").count() > 100, "{alone:.2000}");
        assert!([2, 3].into_iter().all(|threads| examined(threads) == alone));
    }
}
