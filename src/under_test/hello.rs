//! The handshake: what a program says of itself, held against what a file declares of it.

use serde::Deserialize;
use serde_json::{Value as Json, json};

use super::start::{StartError, StartProblem};
use super::strict_json;
use super::wire::MoreTables;
use scenario::{Declaration, DeclaredProgram, Dimension, Parameter, ParameterKind};

/// Of the protocol that is spoken.
pub const PROTOCOL: u64 = 1;

/// The most runs that a program may be asked for at once.
pub const MOST_RUNS: usize = 1024;

/// What a program says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Hello {
    /// As it calls itself.
    pub name: Option<String>,
    /// Of the program.
    pub version: Option<String>,
    /// How rows are written.
    pub encoding: Encoding,
    /// How many runs it may be asked for at once.
    pub runs_at_once: usize,
    /// Words for what it is up to, by their index.
    pub modes: Vec<String>,
    /// What frames tell it because it asks for that.
    pub tables: MoreTables,
    pub(super) parameters: Option<Vec<Said>>,
    pub(super) gives: Option<Vec<String>>,
}

/// How rows are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Lines of JSON.
    Json,
    /// Frames of doubles.
    F64,
}

impl Encoding {
    /// As programs say it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::F64 => "f64",
        }
    }
}

/// A parameter that the program has and the file does not declare.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KnowsMore {
    /// As the program calls it.
    pub name: String,
    /// Such as `5 .. 80`.
    pub values: String,
}

#[derive(Deserialize)]
struct Line {
    hello: SaidHello,
}

#[derive(Deserialize)]
struct SaidHello {
    protocol: Json,
    name: Option<String>,
    version: Option<String>,
    encoding: Option<String>,
    runs_at_once: Option<u64>,
    gives: Option<Vec<String>>,
    modes: Option<Vec<String>>,
    parameters: Option<Vec<Said>>,
    tables: Option<Vec<String>>,
}

/// A parameter as the program says it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Said {
    name: String,
    unit: Option<String>,
    default: Option<Json>,
    low: Option<f64>,
    high: Option<f64>,
    options: Option<Vec<String>>,
    /// Whether it takes whole numbers alone.
    whole: Option<bool>,
}

/// What the runner says first.
pub fn own_hello(program: &DeclaredProgram) -> Json {
    json!({"hello": {
        "protocol": PROTOCOL,
        "runner": env!("CARGO_PKG_VERSION"),
        "controller": program.name,
        "encodings": ["f64", "json"],
        "gives": program.gives.word(),
        "period": program.period,
        "columns": {
            "runs": super::wire::RUNS,
            "pedestrians": super::wire::PEDESTRIANS,
            "vehicles": super::wire::VEHICLES,
            "lanes": super::wire::LANES,
            "curvature_ahead": super::wire::CURVATURE_AHEAD,
            "kinds": super::wire::KINDS,
            "crossings": super::wire::CROSSINGS,
        },
    }})
}

/// What a program answers to it.
///
/// # Errors
/// What is wrong with the answer, in words.
pub fn read(line: &str) -> Result<Hello, String> {
    let said = strict_json::read(line.as_bytes()).map_err(|wrong| format!("its hello {wrong}"))?;
    let Line { hello } =
        serde_json::from_value(said).map_err(|error| format!("its hello does not read: {error}"))?;
    if hello.protocol.as_u64() != Some(PROTOCOL) {
        return Err(format!("it speaks protocol {}, and this runner speaks {PROTOCOL}", hello.protocol));
    }
    let encoding = match hello.encoding.as_deref() {
        None | Some("json") => Encoding::Json,
        Some("f64") => Encoding::F64,
        Some(other) => return Err(format!("it wants the encoding `{other}`; there are `f64` and `json`")),
    };
    let runs_at_once = hello.runs_at_once.unwrap_or(1);
    if runs_at_once == 0 || runs_at_once > MOST_RUNS as u64 {
        return Err(format!("it wants {runs_at_once} runs at once; it may be 1 .. {MOST_RUNS}"));
    }
    Ok(Hello {
        name: hello.name,
        version: hello.version,
        encoding,
        runs_at_once: runs_at_once as usize,
        modes: hello.modes.unwrap_or_default(),
        tables: MoreTables::named(&hello.tables.unwrap_or_default()),
        parameters: hello.parameters,
        gives: hello.gives,
    })
}

impl Hello {
    /// What the program does not say as the file does.
    pub fn disagreements(&self, program: &DeclaredProgram, declaration: &Declaration) -> Vec<StartError> {
        let error =
            |message: String, hint: &str| StartError::new(StartProblem::Disagreement, program, message, hint);
        let mut found = Vec::new();
        let gives = program.gives.word();
        if let Some(other) = self.gives.as_ref().filter(|known| known.iter().all(|one| one != gives)) {
            found.push(error(
                format!("`{}` gives {gives}, but its program gives {}", program.name, listed(other)),
                "say what the program gives: `gives …`",
            ));
        }
        let Some(said) = &self.parameters else { return found };
        for parameter in &declaration.parameters {
            let name = &*parameter.name;
            let wrong = match said.iter().find(|one| one.name == name) {
                None => {
                    let nearest = said
                        .iter()
                        .map(|one| (strsim::jaro_winkler(&one.name, name), &one.name))
                        .max_by(|one, other| one.0.total_cmp(&other.0))
                        .filter(|(likeness, _)| *likeness > 0.7);
                    let nearest =
                        nearest.map_or_else(String::new, |(_, near)| format!(" (nearest: `{near}`)"));
                    Some(format!("the program of `{}` has no parameter `{name}`{nearest}", program.name))
                }
                Some(one) => disagreement(parameter, one),
            };
            found.extend(wrong.map(|message| {
                error(message, "change the declaration, or the program").of_parameter(program, name)
            }));
        }
        found
    }

    /// What the program has besides what the file declares.
    pub fn more(&self, declaration: &Declaration) -> Vec<KnowsMore> {
        let more = self.parameters.iter().flatten().filter(|one| declaration.parameter(&one.name).is_none());
        more.map(|one| KnowsMore { name: one.name.clone(), values: one.values() }).collect()
    }

    /// What it says of a parameter, such as `5 .. 80`; nothing where it says none of its own, or not this one.
    pub fn values_of(&self, name: &str) -> Option<String> {
        self.parameters.iter().flatten().find(|one| one.name == name).map(Said::values)
    }

    /// As reports say it: name and version.
    pub fn title(&self) -> String {
        let parts = [self.name.as_deref(), self.version.as_deref()];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" ")
    }
}

impl Said {
    fn values(&self) -> String {
        let unit = self
            .unit
            .as_deref()
            .filter(|unit| !unit.is_empty())
            .map_or_else(String::new, |unit| format!(" {unit}"));
        match (&self.options, self.low, self.high) {
            (Some(options), _, _) => listed(options),
            (None, Some(low), Some(high)) => format!("{low} .. {high}{unit}"),
            _ => self.default.as_ref().map_or_else(String::new, ToString::to_string),
        }
    }
}

fn listed(words: &[String]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

/// In what a declared parameter differs from the program's.
fn disagreement(declared: &Parameter, said: &Said) -> Option<String> {
    let name = &*declared.name;
    let other = |kind: &str| {
        Some(format!("the program takes {kind} for `{name}`, not {}", declared.kind.expectation()))
    };
    let kind = match (&said.options, &said.default) {
        (Some(_), _) => "one of some words",
        (None, Some(Json::Bool(_))) => "true or false",
        (None, Some(Json::String(_))) => "a text",
        (None, Some(Json::Number(_))) => "a number",
        (None, _) if said.low.is_some() || said.high.is_some() || said.unit.is_some() => "a number",
        // It does not say.
        (None, _) => return None,
    };
    let within = |dimension: Dimension, low: f64, high: f64| {
        if let Some(unit) = said.unit.as_deref().filter(|unit| *unit != dimension.si_unit()) {
            return Some(format!(
                "the program has `{name}` in `{unit}`, the file in `{}`",
                dimension.si_unit()
            ));
        }
        let (least, most) = (said.low.unwrap_or(f64::NEG_INFINITY), said.high.unwrap_or(f64::INFINITY));
        (low < least || high > most).then(|| {
            let unit = dimension.si_unit();
            let unit = if unit.is_empty() { unit } else { format!(" {unit}") };
            format!("the program takes {least} .. {most}{unit} for `{name}`, the file {low} .. {high}{unit}")
        })
    };
    match &declared.kind {
        ParameterKind::Number { .. } if kind == "a number" && said.whole == Some(true) => {
            other("a whole number")
        }
        ParameterKind::Number { dimension, range: (low, high), .. } if kind == "a number" => {
            within(*dimension, *low, *high)
        }
        ParameterKind::Whole { range: (low, high), .. } if kind == "a number" => {
            within(Dimension::NUMBER, *low as f64, *high as f64)
        }
        ParameterKind::Flag { .. } if kind == "true or false" => None,
        ParameterKind::Text { .. } if kind == "a text" => None,
        ParameterKind::Choice { options, .. } => match &said.options {
            Some(known) => {
                let unknown = options.iter().find(|option| known.iter().all(|one| *one != option.name))?;
                Some(format!(
                    "the program has no option `{}` of `{name}`, but {}",
                    unknown.name,
                    listed(known)
                ))
            }
            None if kind == "a text" => None,
            None => other(kind),
        },
        _ => other(kind),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::ChoiceOption;

    fn declaration() -> Declaration {
        Declaration::new("my_av", "")
            .number("gap", Dimension::LENGTH, 5.0, (1.0, 30.0), "")
            .with(Parameter::choice("profile", "a", [ChoiceOption::new("a", "")], "", ""))
            .with(Parameter::flag("yields", true, "", ""))
            .with(Parameter::whole("horizon", 20, (5, 80), "", ""))
    }

    fn said(parameters: &str) -> Vec<String> {
        let line = format!(r#"{{"hello":{{"protocol":1,"parameters":[{parameters}]}}}}"#);
        let hello = read(&line).unwrap();
        let program = super::super::pool::tests::program("true");
        hello.disagreements(&program, &declaration()).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn the_smallest_hello_is_enough() {
        let hello = read(r#"{"hello":{"protocol":1}}"#).unwrap();
        assert_eq!((hello.encoding, hello.runs_at_once), (Encoding::Json, 1));
        assert_eq!(hello.title(), "");
        assert!(read(r#"{"hello":{"protocol":2}}"#).unwrap_err().contains("speaks protocol 2"));
        assert!(read(r#"{"hello":{"protocol":1,"runs_at_once":0}}"#).is_err());
        assert!(read(r#"{"hello":{"protocol":1,"encoding":"xml"}}"#).is_err());
    }

    #[test]
    fn file_and_program_must_agree() {
        let right = r#"{"name":"gap","unit":"m","default":5,"low":0,"high":30},{"name":"profile","default":"a","options":["a","b"]},
            {"name":"yields","default":true},{"name":"horizon","default":3,"low":1,"high":100}"#;
        assert_eq!(said(right), [""; 0]);
        let has = |text: &str, message: &str| {
            let found = said(text);
            assert!(found.iter().any(|one| one.contains(message)), "{message}: {found:#?}");
        };
        has(&right.replace("\"gap\"", "\"gab\""), "has no parameter `gap` (nearest: `gab`)");
        has(&right.replace("\"high\":30", "\"high\":20"), "takes 0 .. 20 m for `gap`, the file 1 .. 30 m");
        has(&right.replace("\"unit\":\"m\"", "\"unit\":\"s\""), "has `gap` in `s`, the file in `m`");
        has(&right.replace("[\"a\",\"b\"]", "[\"b\"]"), "no option `a` of `profile`");
        has(&right.replace("\"default\":true", "\"default\":1"), "takes a number for `yields`");
    }

    #[test]
    fn what_the_program_has_besides_is_known() {
        let line = r#"{"hello":{"protocol":1,"parameters":[{"name":"speed","unit":"m/s","default":5,"low":0,"high":30}]}}"#;
        let more = read(line).unwrap().more(&declaration());
        assert_eq!(more, [KnowsMore { name: "speed".into(), values: "0 .. 30 m/s".into() }]);
    }
}
