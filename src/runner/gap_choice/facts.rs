//! What people of CrossCDR did, read from a file of facts, `crosscdr_fit.json`.

use serde_json::Value;
use thiserror::Error;

use results::{GapCondition, GapMeasure, PEOPLE_GROUPS, PeopleAtGaps, PeopleNumber, PeopleNumbers};

/// As the file calls the groups of people, in the order of [`PEOPLE_GROUPS`].
const GROUPS: [&str; PEOPLE_GROUPS.len()] = ["GER", "JPN", "both"];

/// Gaps (s) that people met alone after short ones of [`BEFORE_ALONE`].
const ALONE: [f64; 5] = [3.5, 4.5, 5.5, 6.5, 7.5];
/// s
const BEFORE_ALONE: f64 = 2.0;

/// Gaps that people met with others, and those before them, s.
const WITH_OTHERS: [(f64, f64); 2] = [(4.0, 3.0), (6.5, 2.5)];

/// Why a file does not say what people did.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FactsError {
    /// It is not JSON.
    #[error("{file}: {error}")]
    Json {
        /// The file.
        file: String,
        /// Line, column and what was expected.
        error: String,
    },
    /// A field is not there.
    #[error("{file}: there is no {field}: it is no file of facts such as crosscdr_fit.json")]
    Missing {
        /// The file.
        file: String,
        /// Which, from the top of the file on.
        field: String,
    },
    /// A field says what cannot be.
    #[error("{file}: {field} is {found}, and it is {expected}")]
    Wrong {
        /// The file.
        file: String,
        /// Which, from the top of the file on.
        field: String,
        /// What stands there.
        found: String,
        /// What could.
        expected: &'static str,
    },
}

/// Reads what people did from the `targets` of a file of facts.
///
/// # Errors
/// The first field that is missing or says what cannot be.
pub fn read_people_at_gaps(file: &str, text: &str) -> Result<PeopleAtGaps, FactsError> {
    let json = serde_json::from_str(text)
        .map_err(|error| FactsError::Json { file: file.to_string(), error: error.to_string() })?;
    let facts = Facts { file, json };
    let alone = ALONE.iter().map(|gap| {
        let share = facts.shares(&format!("alone, single gap {gap:.1} s, mean over persons"))?;
        Ok(GapCondition { gap: *gap, before: BEFORE_ALONE, with_others: false, share, pairs: None })
    });
    let with_others = WITH_OTHERS.iter().map(|(gap, before)| {
        let share = facts.shares(&format!("pivot {gap:.1} s, share"))?;
        let pairs = Some(facts.shares(&format!("pivot {gap:.1} s, pair share"))?);
        Ok(GapCondition { gap: *gap, before: *before, with_others: true, share, pairs })
    });
    let conditions = alone.chain(with_others).collect::<Result<_, _>>()?;
    let mut measures =
        vec![(GapMeasure::ShortTaken(BEFORE_ALONE), facts.shares("2.0 s alone, share of gaps offered")?)];
    for (gap, before) in WITH_OTHERS {
        let name = format!("{before:.1} s before pivot {gap:.1} s, share of gaps offered");
        measures.push((GapMeasure::ShortTaken(before), facts.shares(&name)?));
    }
    for (gap, _) in WITH_OTHERS {
        let name = format!("entry after previous front, pivot {gap:.1} s, q50");
        measures.push((GapMeasure::EntryAfterPrevious(gap), facts.numbers(&name)?));
    }
    for (gap, _) in WITH_OTHERS {
        let name = format!("left on leaving the near lane < 1 s, pivot {gap:.1} s");
        measures.push((GapMeasure::LittleLeft(gap), facts.shares(&name)?));
    }
    measures.push((GapMeasure::MeanSpeed, facts.numbers("mean speed on the near lane, mean")?));
    for (gap, _) in WITH_OTHERS {
        let name = format!("mean speed on the near lane, pivot {gap:.1} s, median");
        measures.push((GapMeasure::SpeedInGap(gap), facts.numbers(&name)?));
    }
    measures.push((GapMeasure::Collision, facts.shares("collision")?));
    measures.push((GapMeasure::NeverAcross, facts.shares("nobody within 60 s")?));
    measures.push((GapMeasure::StepBack, facts.shares("step back")?));
    Ok(PeopleAtGaps { what: facts.what()?, conditions, measures })
}

struct Facts<'a> {
    file: &'a str,
    json: Value,
}

impl Facts<'_> {
    fn missing(&self, field: &str) -> FactsError {
        FactsError::Missing { file: self.file.to_string(), field: field.to_string() }
    }

    fn wrong(&self, field: &str, found: &Value, expected: &'static str) -> FactsError {
        let (file, field) = (self.file.to_string(), field.to_string());
        FactsError::Wrong { file, field, found: found.to_string(), expected }
    }

    fn what(&self) -> Result<String, FactsError> {
        let what = self.json.get("what").ok_or_else(|| self.missing("`what`"))?;
        Ok(what.as_str().ok_or_else(|| self.wrong("`what`", what, "a sentence"))?.to_string())
    }

    /// One number for each group.
    fn numbers(&self, name: &str) -> Result<PeopleNumbers, FactsError> {
        let targets = self.json.get("targets").ok_or_else(|| self.missing("`targets`"))?;
        let names = targets.get("names").and_then(Value::as_array);
        let names = names.ok_or_else(|| self.missing("list `targets.names`"))?;
        let place = names.iter().position(|one| one.as_str() == Some(name));
        let place = place.ok_or_else(|| self.missing(&format!("`{name}` among `targets.names`")))?;
        let mut numbers = [PeopleNumber { value: 0.0, error: None, at_most: None }; PEOPLE_GROUPS.len()];
        for (number, group) in numbers.iter_mut().zip(GROUPS) {
            let cell = |column: &str| {
                let field = format!("`targets.{group}.{column}` of `{name}`");
                let list = targets.get(group).and_then(|group| group.get(column));
                let cell = list.and_then(|list| list.get(place)).ok_or_else(|| self.missing(&field))?;
                let number = cell.as_f64().filter(|number| *number >= 0.0);
                if !cell.is_null() && number.is_none() {
                    return Err(self.wrong(&field, cell, "a number of at least 0, or null"));
                }
                Ok((number, field))
            };
            let (value, field) = cell("value")?;
            let value = value.ok_or_else(|| self.missing(&field))?;
            *number = PeopleNumber { value, error: cell("se")?.0, at_most: cell("upper_95")?.0 };
        }
        Ok(numbers)
    }

    /// As [`Self::numbers`], which are shares.
    fn shares(&self, name: &str) -> Result<PeopleNumbers, FactsError> {
        let shares = self.numbers(name)?;
        match shares.iter().find(|share| share.value > 1.0) {
            None => Ok(shares),
            Some(share) => Err(self.wrong(&format!("`{name}`"), &share.value.into(), "a share from 0 to 1")),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use results::ALL_PEOPLE;
    use serde_json::json;

    /// All fields that are read: shares of 0.25, other numbers of 1.5, and for Japan twice that.
    pub fn made_up() -> Value {
        let mut names: Vec<String> =
            ALONE.iter().map(|gap| format!("alone, single gap {gap:.1} s, mean over persons")).collect();
        for (gap, before) in WITH_OTHERS {
            names.push(format!("pivot {gap:.1} s, share"));
            names.push(format!("pivot {gap:.1} s, pair share"));
            names.push(format!("{before:.1} s before pivot {gap:.1} s, share of gaps offered"));
            names.push(format!("left on leaving the near lane < 1 s, pivot {gap:.1} s"));
            names.push(format!("entry after previous front, pivot {gap:.1} s, q50"));
            names.push(format!("mean speed on the near lane, pivot {gap:.1} s, median"));
        }
        names.extend(
            ["2.0 s alone, share of gaps offered", "collision", "nobody within 60 s"].map(Into::into),
        );
        names.extend(["step back", "mean speed on the near lane, mean"].map(Into::into));
        let number = |name: &String| if name.contains("q50") || name.contains("speed") { 1.5 } else { 0.25 };
        let values = |times: f64| names.iter().map(|name| times * number(name)).collect::<Vec<_>>();
        let group = |times: f64| json!({ "value": values(times), "se": vec![0.02; names.len()], "upper_95": vec![Value::Null; names.len()] });
        json!({
            "what": "people who were made up",
            "targets": { "names": names, "GER": group(1.0), "JPN": group(2.0), "both": group(1.5) },
        })
    }

    fn read(json: &Value) -> Result<PeopleAtGaps, FactsError> {
        read_people_at_gaps("facts.json", &json.to_string())
    }

    fn complaint(json: &Value) -> String {
        read(json).unwrap_err().to_string()
    }

    #[test]
    fn every_number_stands_where_it_belongs() {
        let mut json = made_up();
        let place = |name: &str, json: &Value| {
            let names = json["targets"]["names"].as_array().unwrap();
            names.iter().position(|one| one == name).unwrap()
        };
        let at = place("pivot 4.0 s, pair share", &json);
        json["targets"]["JPN"]["value"][at] = json!(0.0);
        json["targets"]["JPN"]["se"][at] = Value::Null;
        json["targets"]["JPN"]["upper_95"][at] = json!(0.05);
        let people = read(&json).unwrap();
        let gaps: Vec<_> =
            people.conditions.iter().map(|one| (one.gap, one.before, one.with_others)).collect();
        assert_eq!(gaps[..2], [(3.5, 2.0, false), (4.5, 2.0, false)]);
        assert_eq!(gaps[5..], [(4.0, 3.0, true), (6.5, 2.5, true)]);
        let pairs = people.conditions[5].pairs.unwrap();
        assert_eq!(pairs[1], PeopleNumber { value: 0.0, error: None, at_most: Some(0.05) });
        assert_eq!((pairs[0].value, pairs[ALL_PEOPLE].error), (0.25, Some(0.02)));
        assert!(people.conditions[0].pairs.is_none() && people.measures.len() == 13);
        let speed = people.measures.iter().find(|(measure, _)| *measure == GapMeasure::MeanSpeed);
        assert_eq!(speed.unwrap().1.map(|number| number.value), [1.5, 3.0, 2.25]);
    }

    #[test]
    fn what_is_missing_or_wrong_is_named() {
        let says = |change: &dyn Fn(&mut Value), what: &str| {
            let mut json = made_up();
            change(&mut json);
            let said = complaint(&json);
            assert!(said.starts_with("facts.json: ") && said.contains(what), "{said}");
        };
        says(&|json| *json = json!([]), "there is no `targets`");
        says(&|json| json["targets"]["names"] = Value::Null, "there is no list `targets.names`");
        says(
            &|json| json["targets"]["names"][3] = json!("else"),
            "there is no `alone, single gap 6.5 s, mean over persons` among `targets.names`",
        );
        says(
            &|json| json["targets"]["GER"]["se"] = json!([]),
            "`targets.GER.se` of `alone, single gap 3.5 s",
        );
        says(&|json| json["targets"]["both"]["value"][0] = Value::Null, "`targets.both.value` of");
        says(&|json| json["targets"]["both"]["value"][0] = json!("0.3"), "a number of at least 0, or null");
        says(
            &|json| json["targets"]["JPN"]["value"][1] = json!(1.2),
            "is 1.2, and it is a share from 0 to 1",
        );
        says(&|json| json["what"] = json!(3), "`what` is 3");
        let said = read_people_at_gaps("hiker.json", "{").unwrap_err().to_string();
        assert!(said.starts_with("hiker.json: EOF"), "{said}");
    }
}
