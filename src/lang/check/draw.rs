//! `draw …`: what every run draws anew.

use std::collections::{HashMap, HashSet};

use super::block::Layer;
use super::draw_table::{self, ReadTable, WEIGHT};
use super::places::TextPlaces;
use super::variation::{DrawnFrom, drawn_from, varied_names};
use crate::codes::Code;
use crate::diagnostic::{Diagnostic, nearest};
use crate::settings::repeated;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{Binding, Typed, ValueKind};
use scenario::{Criterion, DeclaredDraw, DrawSource, DrawTable, Expression, Variation, VariedValue};

/// Every draw of a scenario, what others depend on first. Their names are added to `bindings`; a variation of an earlier layer is taken
/// out of `variations` where a draw gives its name values, and a draw is left out where a later layer varies its name.
pub fn draws(
    layers: &[Layer<ast::ScenarioBlock>],
    variations: &mut Vec<Variation>,
    bindings: &mut HashMap<String, Binding>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Vec<DeclaredDraw> {
    let mut draws: Vec<DeclaredDraw> = Vec::new();
    for (index, layer) in layers.iter().enumerate() {
        let varied_by = |layers: &[Layer<ast::ScenarioBlock>]| -> HashMap<String, Span> {
            let nodes = layers.iter().flat_map(|layer| layer.block.variations()).flat_map(varied_names);
            nodes.map(|(name, span)| (name.to_string(), span)).collect()
        };
        let here = varied_by(&layers[index..=index]);
        let later = varied_by(&layers[index + 1..]);
        let mut said: HashMap<String, Span> = HashMap::new();
        let tables = layer.block.tables().filter_map(|node| table(node, places, report));
        let tables: Vec<Found> = tables.collect();
        let mut found = tables.into_iter().map(Ok).chain(layer.block.draws().map(Err)).collect::<Vec<_>>();
        for one in found.drain(..) {
            let one = match one {
                Ok(table) => table,
                Err(node) => {
                    // Poisoned unless it turns out well.
                    let name = node.name();
                    let known = bindings.clone();
                    if !later.contains_key(name.text()) {
                        bindings.insert(name.text().to_string(), Binding::new(None, name.span()));
                    }
                    match single(node, layer, &known, places, report) {
                        Some(one) => one,
                        None => continue,
                    }
                }
            };
            let Found { mut draw, columns } = one;
            for column in columns {
                let name = &column.name;
                if let Some(first) =
                    said.insert(name.clone(), column.span).or_else(|| here.get(name).copied())
                {
                    report.push(repeated(name, column.span, first));
                }
                draws.iter_mut().for_each(|earlier| leave_out(earlier, name));
                if later.contains_key(name) {
                    leave_out(&mut draw, name);
                    continue;
                }
                let grouped =
                    variations.iter().find(|one| one.names().len() > 1 && one.names().contains(name));
                if let Some(group) = grouped.filter(|_| !here.contains_key(name)) {
                    let others: Vec<_> = group.names().iter().filter(|other| *other != name).collect();
                    report.push(
                        Diagnostic::new(
                            Code::UnknownVariation,
                            column.span,
                            format!(
                                "drawing `{name}` leaves `{}` without values: they are varied together",
                                others[0]
                            ),
                        )
                        .label("replaces what it is varied together with")
                        .hint(format!("draw `{}` as well, or vary it anew", others[0])),
                    );
                }
                variations.retain(|variation| !variation.names().contains(name));
                let typed = Typed::variable(name, column.kind, column.notation, column.span);
                let mut binding = Binding::new(Some(typed), column.span);
                binding.varied = column.values;
                bindings.insert(name.clone(), binding);
            }
            draws.retain(|earlier| !earlier.names.is_empty());
            draws.push(draw);
        }
    }
    draws.retain(|draw| !draw.names.is_empty());
    in_order(draws, bindings, report)
}

/// A draw with what its names are.
struct Found {
    draw: DeclaredDraw,
    columns: Vec<NamedColumn>,
}

struct NamedColumn {
    name: String,
    span: Span,
    kind: ValueKind,
    notation: Option<scenario::Notation>,
    values: Option<Vec<VariedValue>>,
}

/// Takes a name out of what a draw gives values to.
fn leave_out(draw: &mut DeclaredDraw, name: &str) {
    let Some(index) = draw.names.iter().position(|known| known == name) else { return };
    draw.names.remove(index);
    if let DrawSource::Table(table) = &mut draw.from {
        table.rows.iter_mut().for_each(|row| _ = row.remove(index));
    }
}

/// `draw NAME from normal(5 m, 1 m)` or `draw NAME from "gaps.csv"`
fn single(
    node: ast::Draw,
    layer: &Layer<ast::ScenarioBlock>,
    known: &HashMap<String, Binding>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Found> {
    let (name, span) = (node.name().text().to_string(), node.name().span());
    let origin = places.origin(node.span());
    if let Some(file) = node.file() {
        let (path, table, index) = column(file, (&name, span), places, report)?;
        return Some(of_columns(&path, &table, &[index], span, origin));
    }
    let others: HashMap<String, Binding> = known
        .iter()
        .filter(|(other, _)| **other != name)
        .map(|(other, one)| (other.clone(), one.clone()))
        .collect();
    let DrawnFrom { kind, notation, distribution } =
        drawn_from(node.distribution()?, layer.scope, &others, report)?;
    let unit = match kind {
        ValueKind::Number(dimension) => dimension.si_unit(),
        _ => String::new(),
    };
    let values = distribution.options().map(<[_]>::to_vec);
    let from = DrawSource::Distribution { distribution, unit };
    let draw = DeclaredDraw { names: vec![name.clone()], from, origin };
    Some(Found { draw, columns: vec![NamedColumn { name, span, kind, notation, values }] })
}

/// The table of a file of which one column is wanted, and the place of that column in it.
fn column(
    file: ast::Text,
    (name, span): (&str, Span),
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<(String, ReadTable, usize)> {
    let (path, table) = read(file, |column| column == name || column == WEIGHT, places, report)?;
    refuse_near_weight(file.span(), &table, name, report);
    let Some(index) = table.by_name().get(name).copied() else {
        let names = table.header.iter().map(String::as_str).filter(|column| *column != WEIGHT);
        report.push(
            Diagnostic::new(Code::BadDraw, span, format!("the file has no column `{name}`"))
                .label("not in its header")
                .suggest(name, names),
        );
        return None;
    };
    Some((path, table, index))
}

/// The values of a column of a file, what they are, and the weights of its rows if it has some.
pub fn read_column(
    file: ast::Text,
    name: &str,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<(ValueKind, Vec<VariedValue>, Option<Vec<f64>>)> {
    let (_, table, index) = column(file, (name, file.span()), places, report)?;
    let values = table.of_columns(&[index]).into_iter().flatten().collect();
    let weights = table.header.iter().any(|column| column == WEIGHT).then_some(table.weights);
    Some((table.columns[index].kind, values, weights))
}

/// Of a file of which one column is drawn the others are let off, but for one that can only be meant as the column of weights.
fn refuse_near_weight(span: Span, table: &ReadTable, drawn: &str, report: &mut Vec<Diagnostic>) {
    let others = || table.header.iter().map(String::as_str).filter(|name| *name != drawn);
    if others().any(|name| name == WEIGHT) {
        return;
    }
    // No farther: `height` is another thing.
    let is_meant = |name: &&str| {
        let name = name.to_lowercase();
        let is_near = strsim::damerau_levenshtein(&name, WEIGHT) == 1;
        // Two letters that have changed places count twice in the other distance.
        let is_other_word = name.len() == WEIGHT.len() && strsim::levenshtein(&name, WEIGHT) == 1;
        name.trim_end_matches('s') == WEIGHT || is_near && !is_other_word
    };
    if let Some(near) = others().find(is_meant) {
        report.push(
            Diagnostic::new(Code::BadDraw, span, format!("the column `{near}` gives no row a weight"))
                .label("all rows would be equally likely")
                .hint(format!("did you mean `{WEIGHT}`? Weights stand in a column of that name")),
        );
    }
}

/// `draw together from "exposure.csv"`, perhaps `without id, date`
fn table(node: ast::DrawTogether, places: &TextPlaces, report: &mut Vec<Diagnostic>) -> Option<Found> {
    let file = node.file();
    let is_left_out = |column: &str| node.left_out().any(|name| name.text() == column);
    let (path, table) = read(file, |column| !is_left_out(column), places, report)?;
    for name in node.left_out() {
        if !table.header.iter().any(|column| column == name.text()) {
            report.push(
                Diagnostic::new(
                    Code::BadDraw,
                    name.span(),
                    format!("the file has no column `{}`", name.text()),
                )
                .label("not in its header")
                .suggest(name.text(), table.header.iter().map(String::as_str)),
            );
        }
    }
    if table.columns.is_empty() {
        report.push(
            Diagnostic::new(Code::BadDraw, node.span(), "all columns of the file are left out")
                .label("nothing is drawn")
                .hint("leave out fewer columns"),
        );
        return None;
    }
    let all: Vec<usize> = (0..table.columns.len()).collect();
    Some(of_columns(&path, &table, &all, file.span(), places.origin(node.span())))
}

fn read(
    file: ast::Text,
    wanted: impl Fn(&str) -> bool,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<(String, ReadTable)> {
    let path = places.beside(file.span(), &file.path());
    match draw_table::read(&path, wanted, places) {
        Ok(table) => Some((path, table)),
        Err((message, hint)) => {
            let found = Diagnostic::new(Code::BadDraw, file.span(), message);
            report.push(found.label("cannot be drawn from").hint(hint));
            None
        }
    }
}

fn of_columns(
    path: &str,
    table: &ReadTable,
    columns: &[usize],
    span: Span,
    origin: scenario::Origin,
) -> Found {
    let rows = table.of_columns(columns);
    let named = |(place, index): (usize, &usize)| {
        let column = &table.columns[*index];
        // One of a long table stands for many.
        let values = rows.iter().map(|row| row[place].clone()).collect();
        NamedColumn {
            name: column.name.clone(),
            span,
            kind: column.kind,
            notation: column.notation,
            values: Some(values),
        }
    };
    let columns: Vec<NamedColumn> = columns.iter().enumerate().map(named).collect();
    let draw = DeclaredDraw {
        names: columns.iter().map(|column| column.name.clone()).collect(),
        from: DrawSource::Table(DrawTable {
            file: path.to_string(),
            stream: format!(
                "table/{}",
                columns.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join("+")
            ),
            rows,
            weights: table.weights.clone(),
        }),
        origin,
    };
    Found { draw, columns }
}

/// What a draw depends on stands before it. A later layer may have drawn that anew, and so moved it behind.
fn in_order(
    mut draws: Vec<DeclaredDraw>,
    bindings: &HashMap<String, Binding>,
    report: &mut Vec<Diagnostic>,
) -> Vec<DeclaredDraw> {
    let mut ordered: Vec<DeclaredDraw> = Vec::new();
    while !draws.is_empty() {
        let is_ready = |draw: &DeclaredDraw| {
            let others =
                draws.iter().filter(|other| other.names != draw.names).flat_map(|other| &other.names);
            !others.into_iter().any(|name| draw.depends_on().contains(&name.as_str()))
        };
        let Some(ready) = draws.iter().position(is_ready) else {
            let names: Vec<_> =
                draws.iter().flat_map(|draw| &draw.names).map(|name| format!("`{name}`")).collect();
            let place = draws.last().and_then(|draw| bindings.get(&draw.names[0]));
            report.extend(place.map(|binding| {
                let message = format!("{} depend on each other", names.join(" and "));
                Diagnostic::new(Code::BadDistribution, binding.span, message)
                    .label("in a circle")
                    .hint("let one of them depend on nothing that is drawn")
            }));
            ordered.append(&mut draws);
            break;
        };
        ordered.push(draws.remove(ready));
    }
    ordered
}

/// Refuses criteria whose bounds or conditions depend on what is drawn: they are about all runs of a trial together.
pub fn refuse_in_criteria(
    draws: &[DeclaredDraw],
    criteria: &[(Span, Criterion)],
    report: &mut Vec<Diagnostic>,
) {
    let drawn: HashSet<&str> = draws.iter().flat_map(|draw| &draw.names).map(String::as_str).collect();
    for (span, criterion) in criteria {
        let bounds = criterion.claim.bounds();
        let names = bounds.iter().flat_map(|bound| Expression::variables(bound));
        let names = names.chain(criterion.when.iter().map(|condition| condition.variable.as_str()));
        if let Some(name) = { names }.find(|name| drawn.contains(name)) {
            report.push(
                Diagnostic::new(
                    Code::NotConstant,
                    *span,
                    format!("`{name}` is another one in every run, and a criterion is about all of them"),
                )
                .label(format!("depends on `{name}`, which is drawn"))
                .hint(format!(
                    "write a constant, or `vary {name}` so that every value is a trial of its own"
                )),
            );
        }
    }
}

/// Leaves out draws that nothing depends on any more, of what the scenario builds on, and refuses its own: runs would look different and be
/// the same. So it does with columns of a table of which others are used, unless the table says that it is read without them.
pub fn leave_out_unused(
    draws: &mut Vec<DeclaredDraw>,
    layers: &[Layer<ast::ScenarioBlock>],
    bindings: &HashMap<String, Binding>,
    used: &HashSet<&str>,
    report: &mut Vec<Diagnostic>,
) {
    let own = layers.last().map(|layer| layer.block.span());
    let is_own = |span: Span| {
        own.is_some_and(|own| own.source == span.source && own.start <= span.start && span.end <= own.end)
    };
    for draw in draws.iter() {
        let used = |name: &String| {
            used.contains(name.as_str())
                || draws.iter().any(|draw| draw.depends_on().contains(&name.as_str()))
        };
        let others = draw.names.iter().filter(|name| !used(name));
        for name in others.filter(|_| draw.names.iter().any(used)) {
            let Some(binding) = bindings.get(name) else { continue };
            // One that the scenario builds on may well use it.
            if is_own(binding.span) || !is_mentioned(name, layers) {
                report.push(idle_column(name, binding.span, layers));
            }
        }
    }
    loop {
        let by_others = |name: &String| {
            used.contains(name.as_str())
                || draws.iter().any(|draw| draw.depends_on().contains(&name.as_str()))
        };
        let Some(idle) = draws.iter().position(|draw| !draw.names.iter().any(by_others)) else { return };
        let draw = draws.remove(idle);
        let Some(binding) = bindings.get(&draw.names[0]).filter(|binding| is_own(binding.span)) else {
            continue;
        };
        let names: Vec<_> = draw.names.iter().map(|name| format!("`{name}`")).collect();
        report.push(
            Diagnostic::new(
                Code::IdleDraw,
                binding.span,
                format!("drawing {} changes nothing", names.join(", ")),
            )
            .label("no road user depends on it")
            .hint("use it in a value of a road user, or leave it out"),
        );
    }
}

/// Whether a value in any of the layers is made of the name.
fn is_mentioned(name: &str, layers: &[Layer<ast::ScenarioBlock>]) -> bool {
    layers.iter().flat_map(|layer| layer.block.every::<ast::Word>()).any(|word| word.text() == name)
}

/// A column of a table that nothing uses: perhaps another name was meant.
fn idle_column(name: &str, span: Span, layers: &[Layer<ast::ScenarioBlock>]) -> Diagnostic {
    let values = layers.iter().flat_map(|layer| layer.block.every::<ast::Reference>());
    let known = values.map(|word| word.text()).chain([WEIGHT]).filter(|known| *known != name);
    let finding = Diagnostic::new(Code::IdleDraw, span, format!("nothing uses the column `{name}`"))
        .label("no road user depends on it");
    let finding = match nearest(name, known) {
        Some(near) => finding.hint(format!("did you mean `{near}`?")),
        None => finding,
    };
    finding.hint(format!("if it is to be left out, say so: `draw together from … without {name}`"))
}

/// Says nothing of names that may well be columns of a file that could not be read.
pub fn leave_out_unknown(before: usize, report: &mut Vec<Diagnostic>) {
    if report[before..].iter().any(|finding| finding.code == Code::BadDraw) {
        let mut place = 0;
        report.retain(|finding| {
            place += 1;
            place <= before || finding.code != Code::UnknownName
        });
    }
}
