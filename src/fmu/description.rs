//! `modelDescription.xml`: what a unit says of itself, as far as co-simulation needs it.

use std::collections::HashMap;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::element::Element;

/// Which edition of the standard a unit is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FmiVersion {
    /// 2.0
    Two,
    /// 3.0
    Three,
}

/// What a unit says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Of the standard.
    pub version: FmiVersion,
    /// Of the model.
    pub name: String,
    /// Of the model.
    pub model_version: Option<String>,
    /// By which the library knows that this is its description: `guid` or `instantiationToken`.
    pub token: String,
    /// Of the library's file.
    pub identifier: String,
    /// `canBeInstantiatedOnlyOncePerProcess`
    pub is_once_per_process: bool,
    /// The step that it works in where it says that it has one, s: of this, communication steps are a multiple.
    pub fixed_step: Option<f64>,
    /// By name, with what each is in base units where that is said.
    pub units: HashMap<String, Option<BaseUnit>>,
    /// In the order of the file.
    pub variables: Vec<Scalar>,
}

/// A unit as powers of base units: a number `n` of it is `factor * n + offset` of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseUnit {
    /// Of metre, second and radian.
    pub exponents: (i8, i8, i8),
    /// Whether it has other base units.
    pub has_others: bool,
    /// Larger than 0 for units that make sense.
    pub factor: f64,
    /// Other than 0 for temperatures.
    pub offset: f64,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Scalar {
    /// As the unit calls it.
    pub name: String,
    /// By which functions know it.
    pub reference: u32,
    /// What it is for.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// What its values are; `None` for binary values and clocks.
    pub kind: Option<Kind>,
    /// The name of its unit.
    pub unit: Option<String>,
    /// What it is at first.
    pub start: Option<String>,
    /// Its least value.
    pub low: Option<f64>,
    /// Its largest value.
    pub high: Option<f64>,
    /// Of an enumeration: names and numbers.
    pub items: Vec<(String, i64)>,
    /// Whether it has dimensions.
    pub is_array: bool,
}

/// What a variable is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set once, before it is run.
    Parameter,
    /// Set before each step.
    Input,
    /// Asked after each step.
    Output,
    /// Something else: local, calculated, independent, structural.
    Other,
}

/// When a variable may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Never.
    Constant,
    /// At any other time, if only before it is run.
    Settable,
}

/// What the values of a variable are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Kind {
    /// `Real` of 2.0, `Float64`
    Float64,
    /// `Float32`
    Float32,
    /// `Int8`
    Int8,
    /// `UInt8`
    UInt8,
    /// `Int16`
    Int16,
    /// `UInt16`
    UInt16,
    /// `Integer` and enumerations of 2.0, `Int32`
    Int32,
    /// `UInt32`
    UInt32,
    /// Enumerations of 3.0, `Int64`
    Int64,
    /// `UInt64`
    UInt64,
    /// `Boolean`
    Boolean,
    /// `String`
    Text,
}

impl Kind {
    /// Whether its values are numbers with fractions.
    pub fn is_float(self) -> bool {
        matches!(self, Self::Float64 | Self::Float32)
    }

    /// The whole numbers that it can hold exactly and a double, too; `None` where it is none.
    pub fn whole_range(self) -> Option<(f64, f64)> {
        // 2^53
        const MOST: f64 = 9_007_199_254_740_992.0;
        Some(match self {
            Self::Int8 => (f64::from(i8::MIN), f64::from(i8::MAX)),
            Self::UInt8 => (0.0, f64::from(u8::MAX)),
            Self::Int16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Self::UInt16 => (0.0, f64::from(u16::MAX)),
            Self::Int32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::UInt32 => (0.0, f64::from(u32::MAX)),
            Self::Int64 => (-MOST, MOST),
            Self::UInt64 => (0.0, MOST),
            Self::Float64 | Self::Float32 | Self::Boolean | Self::Text => return None,
        })
    }
}

impl Description {
    /// Reads the text of `modelDescription.xml`.
    ///
    /// # Errors
    /// What is wrong with it, in words that go on from its name.
    pub fn read(text: &str) -> Result<Self, String> {
        let root = Element::read(text)?;
        if root.name != "fmiModelDescription" {
            return Err(format!("describes no FMU: it begins with `{}`", root.name));
        }
        let said = root.text("fmiVersion").unwrap_or_default();
        let version = match said.split('.').next() {
            Some("2") => FmiVersion::Two,
            Some("3") => FmiVersion::Three,
            _ => return Err(format!("is of FMI `{said}`; there are 2.0 and 3.0")),
        };
        let simulation =
            root.child("CoSimulation").ok_or("has no CoSimulation: export the FMU for co-simulation")?;
        let identifier = simulation.text("modelIdentifier").unwrap_or_default();
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if identifier.is_empty() || !identifier.chars().all(is_plain) {
            return Err(format!("has the modelIdentifier `{identifier}`, which is no name of a library"));
        }
        let token = match version {
            FmiVersion::Two => root.text("guid"),
            FmiVersion::Three => root.text("instantiationToken"),
        };
        let default_step = root.child("DefaultExperiment").and_then(|one| one.number("stepSize"));
        let is_variable = simulation.is("canHandleVariableCommunicationStepSize");
        let fixed_step = simulation.number("fixedInternalStepSize").or(default_step.filter(|_| !is_variable));
        let types = Types::of(&root);
        let scalars = root.inside("ModelVariables").iter();
        if scalars.len() > MOST_VARIABLES {
            return Err(format!("has {} variables, more than {MOST_VARIABLES}", scalars.len()));
        }
        let variables: Result<Vec<Scalar>, String> = match version {
            FmiVersion::Two => scalars.map(|one| two(one, &types)).collect(),
            FmiVersion::Three => scalars.map(|one| three(one, &types)).collect(),
        };
        let variables = variables.map_err(|message| format!("has variables that do not read: {message}"))?;
        Ok(Self {
            version,
            name: root.text("modelName").unwrap_or_default().to_string(),
            model_version: root.text("version").filter(|said| !said.is_empty()).map(str::to_string),
            token: token.ok_or("has no guid or instantiationToken")?.to_string(),
            identifier: identifier.to_string(),
            is_once_per_process: simulation.is("canBeInstantiatedOnlyOncePerProcess"),
            fixed_step: fixed_step.filter(|step| step.is_finite() && *step > 0.0),
            units: root.inside("UnitDefinitions").iter().filter_map(unit).collect::<Result<_, _>>()?,
            variables,
        })
    }

    /// The variable of that name.
    pub fn variable(&self, name: &str) -> Option<&Scalar> {
        self.variables.iter().find(|one| one.name == name)
    }
}

/// What types say of the variables that refer to them.
struct Types<'x>(HashMap<&'x str, &'x Element>);

impl<'x> Types<'x> {
    fn of(root: &'x Element) -> Self {
        let named = |one: &'x Element| Some((one.text("name")?, one));
        Self(root.inside("TypeDefinitions").iter().filter_map(named).collect())
    }

    /// What the type of a variable says under that name of an attribute. In 2.0 it is said by the only element in the type.
    fn text(&self, variable: &Element, attribute: &str) -> Option<&'x str> {
        let said = self.element(variable)?;
        said.text(attribute).or_else(|| said.children.first()?.text(attribute))
    }

    fn element(&self, variable: &Element) -> Option<&'x Element> {
        self.0.get(variable.text("declaredType")?).copied()
    }

    fn items(&self, variable: &Element) -> Vec<(String, i64)> {
        let Some(said) = self.element(variable) else { return Vec::new() };
        let listed = said.children.iter().chain(said.children.iter().flat_map(|one| &one.children));
        let item = |one: &Element| Some((one.text("name")?.to_string(), one.text("value")?.parse().ok()?));
        listed.filter(|one| one.name == "Item").filter_map(item).collect()
    }
}

/// Variables of a unit, at most.
const MOST_VARIABLES: usize = 100_000;

/// A unit with its base units; an error where they are said in numbers that are none.
fn unit(said: &Element) -> Option<Result<(String, Option<BaseUnit>), String>> {
    let name = said.text("name")?.to_string();
    let base = said.child("BaseUnit").map(|base| base_unit(&name, base)).transpose();
    Some(base.map(|base| (name, base)))
}

fn base_unit(name: &str, said: &Element) -> Result<BaseUnit, String> {
    const OTHERS: [&str; 5] = ["kg", "A", "K", "mol", "cd"];
    fn read<T: FromStr>(unit: &str, said: &Element, attribute: &str, usual: T) -> Result<T, String> {
        let Some(text) = said.text(attribute) else { return Ok(usual) };
        let wrong = || format!("has the unit `{unit}` with the {attribute} `{text}`, which is not a number");
        text.trim().parse().map_err(|_| wrong())
    }
    let power = |attribute: &str| read(name, said, attribute, 0_i8);
    let others: Vec<i8> = OTHERS.iter().map(|other| power(other)).collect::<Result<_, _>>()?;
    Ok(BaseUnit {
        exponents: (power("m")?, power("s")?, power("rad")?),
        has_others: others.iter().any(|power| *power != 0),
        factor: read(name, said, "factor", 1.0)?,
        offset: read(name, said, "offset", 0.0)?,
    })
}

/// Of a variable: what of 2.0 is in an element inside it, and of 3.0 its own.
fn scalar(said: &Element, of: &Element, kind: Option<Kind>, types: &Types) -> Result<Scalar, String> {
    let name = said.text("name").ok_or("one has no name")?.to_string();
    let reference = said.text("valueReference").and_then(|text| text.trim().parse().ok());
    let text = |attribute: &str| of.text(attribute).or_else(|| types.text(of, attribute)).map(str::to_string);
    let number = |attribute: &str| text(attribute).and_then(|text| text.trim().parse().ok());
    Ok(Scalar {
        reference: reference.ok_or_else(|| format!("`{name}` has no valueReference"))?,
        causality: match said.text("causality") {
            Some("parameter") => Causality::Parameter,
            Some("input") => Causality::Input,
            Some("output") => Causality::Output,
            _ => Causality::Other,
        },
        variability: match said.text("variability") {
            Some("constant") => Variability::Constant,
            _ => Variability::Settable,
        },
        kind,
        unit: text("unit").filter(|unit| !unit.is_empty()),
        start: of.text("start").or_else(|| of.child("Start")?.text("value")).map(str::to_string),
        low: number("min"),
        high: number("max"),
        items: types.items(of),
        is_array: said.child("Dimension").is_some(),
        name,
    })
}

fn two(said: &Element, types: &Types) -> Result<Scalar, String> {
    let known = |one: &&Element| kind_of_two(&one.name).is_some();
    let of = said.children.iter().find(known);
    let kind = of.and_then(|of| kind_of_two(&of.name));
    scalar(said, of.unwrap_or(said), kind, types)
}

fn kind_of_two(name: &str) -> Option<Kind> {
    Some(match name {
        "Real" => Kind::Float64,
        "Integer" | "Enumeration" => Kind::Int32,
        "Boolean" => Kind::Boolean,
        "String" => Kind::Text,
        _ => return None,
    })
}

fn three(said: &Element, types: &Types) -> Result<Scalar, String> {
    let kind = match said.name.as_str() {
        "Float64" => Some(Kind::Float64),
        "Float32" => Some(Kind::Float32),
        "Int8" => Some(Kind::Int8),
        "UInt8" => Some(Kind::UInt8),
        "Int16" => Some(Kind::Int16),
        "UInt16" => Some(Kind::UInt16),
        "Int32" => Some(Kind::Int32),
        "UInt32" => Some(Kind::UInt32),
        "Int64" | "Enumeration" => Some(Kind::Int64),
        "UInt64" => Some(Kind::UInt64),
        "Boolean" => Some(Kind::Boolean),
        "String" => Some(Kind::Text),
        _ => None,
    };
    scalar(said, said, kind, types)
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Of a unit of 2.0.
    pub const TWO: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Unit" guid="{8c4e}" version="1.2">
  <CoSimulation modelIdentifier="unit" canHandleVariableCommunicationStepSize="false" canBeInstantiatedOnlyOncePerProcess="true"/>
  <UnitDefinitions>
    <Unit name="km/h"><BaseUnit m="1" s="-1" factor="0.25"/></Unit><Unit name="odd"/><Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Speed"><Real unit="km/h" max="100"/></SimpleType>
    <SimpleType name="Profile"><Enumeration><Item name="calm" value="1"/><Item name="brisk" value="4"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <DefaultExperiment stepSize="0.01"/>
  <ModelVariables>
    <ScalarVariable name="v" valueReference="7" causality="input"><Real declaredType="Speed" start="0"/></ScalarVariable>
    <ScalarVariable name="p" valueReference="8" causality="parameter" variability="fixed"><Enumeration declaredType="Profile" start="1"/></ScalarVariable>
    <ScalarVariable name="a" valueReference="9" causality="output"><Real unit="m/s2"/></ScalarVariable>
    <ScalarVariable name="c" valueReference="10" variability="constant"><Boolean start="true"/></ScalarVariable>
  </ModelVariables>
</fmiModelDescription>"#;

    const THREE: &str = r#"<fmiModelDescription fmiVersion="3.0" modelName="Unit" instantiationToken="t">
  <CoSimulation modelIdentifier="unit" canHandleVariableCommunicationStepSize="true" fixedInternalStepSize="0.02"/>
  <TypeDefinitions><Float64Type name="Speed" unit="m/s" min="-1"/></TypeDefinitions>
  <ModelVariables>
    <Float64 name="v" valueReference="1" causality="input" declaredType="Speed" start="0"/>
    <UInt8 name="n" valueReference="2" causality="parameter"/>
    <String name="s" valueReference="3" causality="parameter"><Start value="x"/></String>
    <Float64 name="w" valueReference="4" causality="input"><Dimension start="3"/></Float64>
    <Binary name="b" valueReference="5" causality="input"/>
  </ModelVariables>
</fmiModelDescription>"#;

    #[test]
    fn numbers_of_units_are_numbers_and_variables_are_bounded() {
        for (from, to, words) in [
            (
                "factor=\"0.25\"",
                "factor=\"0,25\"",
                "has the unit `km/h` with the factor `0,25`, which is not a number",
            ),
            ("<BaseUnit m=\"1\" s=\"-1\" factor", "<BaseUnit m=\"one\" s=\"-1\" factor", "with the m `one`"),
        ] {
            assert!(TWO.contains(from), "{from}");
            let error = Description::read(&TWO.replace(from, to)).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
        let more = "<ScalarVariable/>".repeat(MOST_VARIABLES + 1);
        let error = Description::read(&TWO.replace("<ModelVariables>", &format!("<ModelVariables>{more}")))
            .unwrap_err();
        assert!(error.contains("variables, more than 100000"), "{error}");
    }

    #[test]
    fn a_unit_of_two_says_what_it_is() {
        let read = Description::read(TWO).unwrap();
        assert_eq!(
            (read.version, read.token.as_str(), read.fixed_step),
            (FmiVersion::Two, "{8c4e}", Some(0.01))
        );
        assert!(read.is_once_per_process);
        let v = read.variable("v").unwrap();
        assert_eq!((v.reference, v.causality, v.kind), (7, Causality::Input, Some(Kind::Float64)));
        assert_eq!((v.unit.as_deref(), v.high, v.start.as_deref()), (Some("km/h"), Some(100.0), Some("0")));
        assert_eq!(read.units["km/h"].unwrap().factor, 0.25);
        assert!(read.units["odd"].is_none() && read.units["N"].unwrap().has_others);
        assert_eq!(read.variable("p").unwrap().items, [("calm".to_string(), 1), ("brisk".to_string(), 4)]);
        assert_eq!(read.variable("c").unwrap().variability, Variability::Constant);
        assert_eq!(read.variable("a").unwrap().unit.as_deref(), Some("m/s2"));
    }

    #[test]
    fn a_unit_of_three_says_what_it_is() {
        let read = Description::read(THREE).unwrap();
        assert_eq!((read.version, read.fixed_step), (FmiVersion::Three, Some(0.02)));
        let v = read.variable("v").unwrap();
        assert_eq!((v.unit.as_deref(), v.low), (Some("m/s"), Some(-1.0)));
        assert_eq!(read.variable("n").unwrap().kind.and_then(Kind::whole_range), Some((0.0, 255.0)));
        assert_eq!(read.variable("s").unwrap().start.as_deref(), Some("x"));
        assert!(read.variable("w").unwrap().is_array);
        assert_eq!(read.variable("b").unwrap().kind, None);
    }

    #[test]
    fn what_cannot_be_stepped_is_said() {
        for (from, to, words) in [
            ("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\"", "is of FMI `1.0`"),
            ("CoSimulation", "ModelExchange", "has no CoSimulation"),
            ("modelIdentifier=\"unit\"", "modelIdentifier=\"../x\"", "no name of a library"),
            ("guid=\"{8c4e}\"", "", "no guid"),
            ("valueReference=\"9\"", "", "`a` has no valueReference"),
            ("fmiModelDescription", "html", "describes no FMU"),
        ] {
            let error = Description::read(&TWO.replace(from, to)).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
