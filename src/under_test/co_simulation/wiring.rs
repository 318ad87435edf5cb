//! What a file says of a unit's variables, held against what the unit says of them.

use std::collections::HashSet;

use ::fmu::{Causality, Description, Kind, Scalar, Variability};
use serde_json::{Value as Json, json};

use super::wired::Wired;
use crate::start::{StartError, StartProblem};
use scenario::{
    DeclaredFmu, DeclaredProgram, Dimension, STEERS, WiredVariable, input_signals, output_signals,
};

/// By which two that say the same may differ, since they say it in other words.
const TOLERANCE: f64 = 1e-9;

/// The variables that are set and asked.
#[derive(Debug, Clone, PartialEq)]
pub struct FmuWiring {
    /// By the place of the signal.
    pub inputs: Vec<(usize, Wired)>,
    /// In the order of the answer, the curvature last if there is one.
    pub outputs: Vec<Wired>,
    pub parameters: Vec<Wired>,
    /// What the unit says of its parameters, and of inputs that nobody wires.
    pub said: Vec<Json>,
}

/// What each variable is for.
///
/// # Errors
/// The first that is wrong, with the others as notes.
pub fn wiring(
    program: &DeclaredProgram,
    declared: &DeclaredFmu,
    description: &Description,
) -> Result<FmuWiring, StartError> {
    let mut found =
        FmuWiring { inputs: Vec::new(), outputs: Vec::new(), parameters: Vec::new(), said: Vec::new() };
    let mut wrong: Vec<StartError> = Vec::new();
    let mut taken = HashSet::new();
    let error = |message: String, hint: &str| StartError::new(StartProblem::NotWired, program, message, hint);
    let mut wired = |wire: &WiredVariable, wanted: Wanted, wrong: &mut Vec<StartError>| {
        let known = find(wire, wanted, description).and_then(|scalar| {
            if !taken.insert((scalar.kind, scalar.reference)) {
                return Err((
                    format!(
                        "`{}` is another name of a variable that stands for something already",
                        wire.variable
                    ),
                    "remove one of the two".to_string(),
                ));
            }
            let (numerator, denominator) = unit(wire, scalar, description)?;
            let kind = scalar.kind.expect("it was looked at");
            let (name, variable) = (wire.name.clone(), wire.variable.clone());
            let items = if wanted == Wanted::Parameter { scalar.items.clone() } else { Vec::new() };
            Ok((
                scalar,
                Wired { name, variable, reference: scalar.reference, kind, numerator, denominator, items },
            ))
        });
        match known {
            Ok(known) => Some(known),
            Err((message, hint)) => {
                let origin = Box::new(wire.origin.clone());
                wrong.push(StartError { origin, ..error(message, &hint) });
                None
            }
        }
    };
    let signals: Vec<_> = input_signals().collect();
    for wire in &declared.inputs {
        let Some(place) = signals.iter().position(|(name, _)| *name == wire.name) else { continue };
        let wanted = if signals[place].1.is_flag { Wanted::Flag } else { Wanted::Input };
        found.inputs.extend(wired(wire, wanted, &mut wrong).map(|(_, wired)| (place, wired)));
    }
    for known in output_signals(program.gives).iter().chain([&STEERS]) {
        for wire in declared.outputs.iter().filter(|wire| wire.name == known.name) {
            found.outputs.extend(wired(wire, Wanted::Output, &mut wrong).map(|(_, wired)| wired));
        }
    }
    for wire in &declared.parameters {
        if let Some((scalar, wired)) = wired(wire, Wanted::Parameter, &mut wrong) {
            found.said.push(said(wire, scalar, &wired));
            found.parameters.push(wired);
        }
    }
    for input in description.variables.iter().filter(|one| one.causality == Causality::Input) {
        if taken.contains(&(input.kind, input.reference)) {
            continue;
        }
        match &input.start {
            Some(start) => {
                let start: Json = start.parse::<f64>().map_or_else(|_| json!(start), |number| json!(number));
                found.said.push(json!({"name": input.name, "default": start}));
            }
            None if wrong.is_empty() => wrong.push(error(
                format!("nothing is told to its input `{}`, which has no start value either", input.name),
                "wire it: `input SIGNAL = \"…\"`, or `parameter … as \"…\"` for what stays as it is",
            )),
            None => {}
        }
    }
    wrong.extend(step(program, description).map(|(message, hint)| error(message, &hint)));
    let mut wrong = wrong.into_iter();
    match wrong.next() {
        None => Ok(found),
        Some(first) => {
            let others = wrong.map(|other| format!("also: {}", other.message)).collect();
            Err(first.with_notes(others))
        }
    }
}

/// What a variable is to be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Input,
    /// An input that is 1 or 0.
    Flag,
    Output,
    Parameter,
}

/// What is wrong, and what to do about it.
type Wrong = (String, String);

fn find<'d>(wire: &WiredVariable, wanted: Wanted, description: &'d Description) -> Result<&'d Scalar, Wrong> {
    let name = &wire.variable;
    let Some(scalar) = description.variable(name) else {
        let likeness = |one: &&Scalar| (strsim::jaro_winkler(&one.name, name) * 1000.0) as u32;
        let nearest = description.variables.iter().max_by_key(likeness).filter(|one| likeness(one) > 700);
        let nearest = nearest.map_or_else(String::new, |near| format!(" (nearest: `{}`)", near.name));
        let hint = "write its name as modelDescription.xml has it".to_string();
        return Err((format!("it has no variable `{name}`{nearest}"), hint));
    };
    let what = match scalar.causality {
        Causality::Input => "an input",
        Causality::Output => "an output",
        Causality::Parameter => "a parameter",
        Causality::Other => "nothing that is set or asked",
    };
    let fits = match wanted {
        Wanted::Input | Wanted::Flag => scalar.causality == Causality::Input,
        Wanted::Output => scalar.causality == Causality::Output,
        // An input that stays as it is in a run.
        Wanted::Parameter => matches!(scalar.causality, Causality::Parameter | Causality::Input),
    };
    if !fits || (scalar.variability == Variability::Constant && wanted != Wanted::Output) {
        let what = if fits { "constant" } else { what };
        let hint = match wanted {
            Wanted::Input | Wanted::Flag => "`input` is told to an input",
            Wanted::Output => "`output` asks an output",
            Wanted::Parameter => "`as` names a parameter, or an input that stays as it is",
        };
        return Err((format!("its variable `{name}` is {what}"), hint.to_string()));
    }
    let Some(kind) = scalar.kind.filter(|_| !scalar.is_array) else {
        let hint = "numbers, truth values and texts are, one by one".to_string();
        return Err((
            format!("its variable `{name}` is an array, binary or a clock, which is not wired"),
            hint,
        ));
    };
    let fits = match wanted {
        Wanted::Input | Wanted::Output => kind.is_float(),
        Wanted::Flag => kind != Kind::Text,
        Wanted::Parameter => true,
    };
    if fits {
        return Ok(scalar);
    }
    let hint = "a quantity needs a variable with fractions, Real or Float64".to_string();
    Err((format!("its variable `{name}` is of the type {kind:?}, and `{}` a quantity", wire.name), hint))
}

/// How a variable's numbers become SI units. Where both name a unit it is the same.
fn unit(wire: &WiredVariable, scalar: &Scalar, description: &Description) -> Result<(f64, f64), Wrong> {
    let (name, of) = (&wire.variable, wire.dimension);
    if !scalar.kind.is_some_and(Kind::is_float) {
        return match wire.unit {
            None if of == Dimension::NUMBER => Ok((1.0, 1.0)),
            _ => Err((
                format!(
                    "its variable `{name}` is of the type {:?}, and `{}` a {}",
                    scalar.kind,
                    wire.name,
                    of.name()
                ),
                "a quantity with a unit needs a variable with fractions, Real or Float64".to_string(),
            )),
        };
    }
    let own = wire.unit.map(|unit| (unit.numerator, unit.denominator));
    let Some(its) = &scalar.unit else {
        let hint = format!("say it: `in {}`", of.si_unit());
        return own.or((of == Dimension::NUMBER).then_some((1.0, 1.0))).ok_or_else(|| {
            (format!("neither file nor FMU says in which unit its variable `{name}` is"), hint)
        });
    };
    let Some(base) = description.units.get(its).copied().flatten() else {
        // Only its name is known.
        let (symbol, hint) = match wire.unit {
            Some(unit) => {
                (unit.symbol.as_str().to_string(), format!("say `in {its}`, or have the FMU define it"))
            }
            None => (of.si_unit(), "say the unit in the file, by the same name".to_string()),
        };
        let is_number = of == Dimension::NUMBER && wire.unit.is_none() && ["1", "-"].contains(&its.as_str());
        return if is_number || plain(&symbol) == plain(its) {
            Ok(own.unwrap_or((1.0, 1.0)))
        } else {
            let symbol = if symbol.is_empty() { "none".to_string() } else { format!("`{symbol}`") };
            Err((
                format!(
                    "the FMU does not define the unit `{its}` of its variable `{name}`; the file means {symbol}"
                ),
                hint,
            ))
        };
    };
    let dimension = Dimension::new(base.exponents.0, base.exponents.1, base.exponents.2);
    if dimension != of
        || base.has_others
        || base.offset != 0.0
        || !(base.factor.is_finite() && base.factor > 0.0)
    {
        let hint = format!("wire a variable that is a {}", of.name());
        return Err((
            format!("its variable `{name}` is in `{its}`, and `{}` a {}", wire.name, of.name()),
            hint,
        ));
    }
    if let Some(meant) = factor_of(its).filter(|meant| (base.factor / meant - 1.0).abs() > ROUNDED) {
        let hint = format!("export the FMU with the factor {meant} for `{its}`");
        return Err((
            format!(
                "the FMU says that its unit `{its}` is {} {}, and it is {meant} {}: its numbers could mean either",
                base.factor,
                of.si_unit(),
                of.si_unit()
            ),
            hint,
        ));
    }
    match own {
        None => Ok((base.factor, 1.0)),
        Some((numerator, denominator))
            if (numerator / denominator / base.factor - 1.0).abs() <= TOLERANCE =>
        {
            Ok((numerator, denominator))
        }
        Some(_) => {
            let said = wire.unit.map_or(String::new(), |unit| unit.symbol.as_str().to_string());
            let hint = "leave the unit out: the FMU says it".to_string();
            Err((format!("the FMU has its variable `{name}` in `{its}`, the file in `{said}`"), hint))
        }
    }
}

/// A factor that is as near to that of its unit is rounded.
const ROUNDED: f64 = 1e-6;

/// The SI value of one unit, for units whose factors are often rounded in descriptions.
fn factor_of(name: &str) -> Option<f64> {
    const KNOWN: [(&str, f64); 9] = [
        ("km/h", 1.0 / 3.6),
        ("kph", 1.0 / 3.6),
        ("kmh", 1.0 / 3.6),
        ("mph", 0.447_04),
        ("deg", std::f64::consts::PI / 180.0),
        ("deg/s", std::f64::consts::PI / 180.0),
        ("ms", 1e-3),
        ("mm", 1e-3),
        ("cm", 1e-2),
    ];
    KNOWN.iter().find(|(known, _)| plain(known) == plain(name)).map(|(_, factor)| *factor)
}

/// `m/s^2`, `m/s²` and `m/s2` are one.
fn plain(unit: &str) -> String {
    unit.replace('²', "2").replace('³', "3").replace(['^', ' '], "")
}

/// As programs say a parameter: in SI units.
fn said(wire: &WiredVariable, scalar: &Scalar, wired: &Wired) -> Json {
    let mut said = json!({"name": wire.name});
    match wired.kind {
        Kind::Boolean => said["default"] = json!(false),
        Kind::Text => said["default"] = json!(""),
        _ if !scalar.items.is_empty() => {
            said["options"] = scalar.items.iter().map(|(word, _)| json!(word)).collect();
        }
        kind => {
            let whole = kind.whole_range();
            let bound = |said: Option<f64>, whole: Option<f64>, beyond: f64| {
                let number = said.or(whole)?;
                let si = wired.to_si(number);
                si.is_finite().then(|| si + beyond * TOLERANCE * si.abs())
            };
            said["unit"] = json!(wire.dimension.si_unit());
            said["whole"] = json!(whole.is_some());
            said["low"] = json!(bound(scalar.low, whole.map(|(low, _)| low), -1.0));
            said["high"] = json!(bound(scalar.high, whole.map(|(_, high)| high), 1.0));
        }
    }
    said
}

/// Whether communication steps are such as the unit can take.
fn step(program: &DeclaredProgram, description: &Description) -> Option<Wrong> {
    let fixed = description.fixed_step?;
    let hint = format!("say a `period` that is a multiple of {fixed} s");
    let Some(period) = program.period else {
        return Some((format!("it works in steps of {fixed} s, and no `period` is said"), hint));
    };
    let steps = (period / fixed).round();
    let fits = steps >= 1.0 && (period - steps * fixed).abs() <= TOLERANCE * period;
    (!fits).then(|| {
        (format!("it works in steps of {fixed} s, of which the period of {period} s is no multiple"), hint)
    })
}
