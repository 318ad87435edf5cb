//! `input`, `output` and `as` of a controller that is a functional mock-up unit. The unit itself is not looked at.

use std::collections::HashSet;

use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::{Sources, Span};
use crate::syntax::ast;
use crate::units::unit_of;
use scenario::{
    Answer, DeclaredFmu, Dimension, Notation, Parameter, ParameterKind, STEERS, SignalEntry, WiredVariable,
    input_signals, output_signals,
};

/// Of a variable's name, bytes.
const LONGEST_NAME: usize = 1024;

/// What the variables of the unit in `file` are for, as a block says it. Without `parameters`, which have mistakes, only mistakes are
/// looked for.
pub fn wired(
    file: String,
    block: ast::ControllerBlock,
    gives: Answer,
    parameters: Option<&[Parameter]>,
    sources: &Sources,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredFmu> {
    let before = report.len();
    let mut wiring = Wiring { sources, taken: HashSet::new(), report };
    let told: Vec<(String, SignalEntry)> = input_signals().collect();
    let mut inputs = Vec::new();
    for said in block.inputs() {
        let (name, wire) = (said.signal(), (said.variable(), said.unit()));
        match told.iter().find(|(known, _)| known == name.text()) {
            Some((known, entry)) => inputs.extend(wiring.variable(known, Some(entry.dimension), wire)),
            None => wiring.unknown(name, "is told to a controller", told.iter().map(|(known, _)| &**known)),
        }
    }
    let given = output_signals(gives);
    if let Some(said) = block.gives().filter(|_| given.is_empty()) {
        wiring.wrong(
            said.span(),
            format!("no output of an `fmu` is a `{}`", gives.word()),
            "give `acceleration`, `pedals` or `speed`",
        );
    }
    let mut outputs: Vec<WiredVariable> = Vec::new();
    for said in block.outputs() {
        let (name, wire) = (said.signal(), (said.variable(), said.unit()));
        match given.iter().chain([&STEERS]).find(|known| known.name == name.text()) {
            Some(known) if outputs.iter().any(|other| other.name == known.name) => {
                wiring.wrong(name.span(), format!("`{}` is said twice", known.name), "remove one of them");
            }
            Some(known) => outputs.extend(wiring.variable(known.name, Some(known.dimension), wire)),
            None => wiring.unknown(
                name,
                &format!("is given by a controller that gives `{}`", gives.word()),
                given.iter().chain([&STEERS]).map(|known| known.name),
            ),
        }
    }
    let is_whole = wiring.report.len() == before && !block.has_bad();
    let missing = given.iter().find(|known| outputs.iter().all(|said| said.name != known.name));
    if let Some((missing, said)) = missing.filter(|_| is_whole).zip(block.fmu()) {
        let unit = missing.dimension.si_unit();
        let unit = if unit.is_empty() { unit } else { format!(" in {unit}") };
        wiring.wrong(
            said.span(),
            format!("nothing says which variable of the `fmu` is `{}`", missing.name),
            format!("write `output {} = \"…\"{unit}`", missing.name),
        );
    }
    let mut own = Vec::new();
    for said in block.parameters() {
        let name = said.name();
        let known = parameters.and_then(|all| all.iter().find(|one| one.name == name.text()));
        let dimension = known.and_then(|known| match known.kind {
            ParameterKind::Number { dimension, .. } => Some(dimension),
            ParameterKind::Whole { .. } => Some(Dimension::NUMBER),
            _ => None,
        });
        if let (Some(known), Some(unit)) = (known, said.wired().and_then(ast::Wired::unit))
            && dimension.is_none()
        {
            wiring.wrong(unit.span(), format!("`{}` is no number", known.name), "leave its unit out");
        } else if let Some(wired) = said.wired() {
            // Where the parameter is declared wrongly, its dimension is not known.
            let dimension = known.map(|_| dimension.unwrap_or(Dimension::NUMBER));
            own.extend(wiring.variable(name.text(), dimension, (wired.variable(), wired.unit())));
        } else {
            own.extend(wiring.named(name.text(), dimension, (name.text().to_string(), name.span()), None));
        }
    }
    (report.len() == before && parameters.is_some()).then_some(DeclaredFmu {
        file,
        inputs,
        outputs,
        parameters: own,
    })
}

/// Says of each statement about variables that there is no `fmu` that could have any.
pub fn reject_wiring(block: ast::ControllerBlock, report: &mut Vec<Diagnostic>) {
    let inputs = block.inputs().map(|said| ("input", said.span()));
    let outputs = block.outputs().map(|said| ("output", said.span()));
    let names = block.parameters().filter_map(|said| Some(("as", said.wired()?.span())));
    for (word, span) in inputs.chain(outputs).chain(names) {
        let message = format!("`{word}` names a variable of an `fmu`, and there is none");
        report.push(
            unwired(span, message).hint("other programs are told everything and by name: leave it out"),
        );
    }
}

fn unwired(span: Span, message: impl Into<String>) -> Diagnostic {
    Diagnostic::new(Code::NotWired, span, message).label("cannot be wired")
}

/// What has been wired.
struct Wiring<'a> {
    sources: &'a Sources,
    /// The names of variables.
    taken: HashSet<String>,
    report: &'a mut Vec<Diagnostic>,
}

impl Wiring<'_> {
    fn wrong(&mut self, span: Span, message: impl Into<String>, hint: impl Into<String>) {
        self.report.push(unwired(span, message).hint(hint));
    }

    fn unknown<'n>(&mut self, said: ast::Signal, what: &str, known: impl Iterator<Item = &'n str> + Clone) {
        let message = format!("no signal `{}` {what}", said.text());
        self.report.push(unwired(said.span(), message).suggest(said.text(), known));
    }

    /// The variable that stands for a signal or parameter of that dimension.
    fn variable(
        &mut self,
        name: &str,
        dimension: Option<Dimension>,
        (variable, unit): (ast::Text, Option<ast::InUnit>),
    ) -> Option<WiredVariable> {
        let notation = match unit {
            Some(said) => Some(self.unit(name, dimension, said.unit())?),
            None => None,
        };
        self.named(name, dimension, (variable.value(), variable.span()), notation)
    }

    fn named(
        &mut self,
        name: &str,
        dimension: Option<Dimension>,
        (variable, span): (String, Span),
        unit: Option<Notation>,
    ) -> Option<WiredVariable> {
        if variable.trim().is_empty() || variable.contains('\0') || variable.len() > LONGEST_NAME {
            self.wrong(span, "no variable is named", "write its name as modelDescription.xml has it");
            return None;
        }
        if !self.taken.insert(variable.clone()) {
            self.wrong(
                span,
                format!("the variable `{variable}` stands for something already"),
                "remove one of the two",
            );
            return None;
        }
        Some(WiredVariable {
            name: name.to_string(),
            dimension: dimension.unwrap_or(Dimension::NUMBER),
            variable,
            unit,
            origin: self.sources.origin(span),
        })
    }

    fn unit(&mut self, name: &str, dimension: Option<Dimension>, said: ast::Unit) -> Option<Notation> {
        let Some(unit) = unit_of(said.text()) else {
            let meant = crate::units::meant(said.text());
            let hint = meant.map_or_else(
                || format!("units are {}", crate::units::listed()),
                |meant| format!("write `{meant}`"),
            );
            self.wrong(said.span(), format!("there is no unit `{}`", said.text()), hint);
            return None;
        };
        match dimension {
            Some(dimension) if dimension != unit.dimension => {
                let si = dimension.si_unit();
                let hint = if si.is_empty() {
                    "leave the unit out".to_string()
                } else {
                    format!("such as `in {si}`")
                };
                let message = format!(
                    "`{name}` is a {}, and `{}` a unit of {}",
                    dimension.name(),
                    unit.symbol,
                    unit.dimension.name()
                );
                self.wrong(said.span(), message, hint);
                None
            }
            _ => Some(unit.notation()),
        }
    }
}
