//! The critical instants of a run in formats of bytes: names once, and of each instant a few numbers. Formats that people read have them
//! as they are.

use std::sync::Arc;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::critical::{ByMetric, Critical};

/// Metric, time, and of vehicle, pedestrian and whatever else which name it is.
type Packed = (usize, Option<f64>, [Option<usize>; 3]);

pub fn serialize<S: Serializer>(all: &ByMetric<Critical>, serializer: S) -> Result<S::Ok, S::Error> {
    if serializer.is_human_readable() {
        return all.serialize(serializer);
    }
    let mut names: Vec<&Arc<str>> = Vec::new();
    let mut packed: Vec<Packed> = Vec::with_capacity(all.known().len());
    for (metric, Critical { time, vehicle, pedestrian, other }) in all.known() {
        let numbers = [vehicle, pedestrian, other].map(|name| {
            let name = name.as_ref()?;
            let known = names.iter().position(|known| *known == name);
            Some(known.unwrap_or_else(|| {
                names.push(name);
                names.len() - 1
            }))
        });
        packed.push((*metric, *time, numbers));
    }
    (names, packed).serialize(serializer)
}

pub fn deserialize<'d, D: Deserializer<'d>>(deserializer: D) -> Result<ByMetric<Critical>, D::Error> {
    if deserializer.is_human_readable() {
        return ByMetric::deserialize(deserializer);
    }
    let (names, packed): (Vec<Arc<str>>, Vec<Packed>) = Deserialize::deserialize(deserializer)?;
    let named = |number: Option<usize>| {
        let name =
            |number| names.get(number).cloned().ok_or_else(|| D::Error::custom("there is no such name"));
        number.map(name).transpose()
    };
    let unpack = |(metric, time, [vehicle, pedestrian, other]): Packed| {
        let (vehicle, pedestrian, other) = (named(vehicle)?, named(pedestrian)?, named(other)?);
        Ok((metric, Critical { time, vehicle, pedestrian, other }))
    };
    packed.into_iter().map(unpack).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Written(#[serde(with = "super")] ByMetric<Critical>);

    fn critical(time: Option<f64>, vehicle: &str, pedestrian: Option<&str>, other: Option<&str>) -> Critical {
        let name = |name: &str| Some(Arc::from(name));
        Critical {
            time,
            vehicle: name(vehicle),
            pedestrian: pedestrian.and_then(name),
            other: other.and_then(name),
        }
    }

    fn written() -> Written {
        let all = [
            (0, critical(Some(0.1 + 0.2), "av", Some("walker"), None)),
            (2, critical(None, "van", None, Some("av"))),
            (70_000, critical(Some(f64::INFINITY), "av", Some("walker"), None)),
            (70_001, Critical::default()),
        ];
        Written(all.into_iter().collect())
    }

    #[test]
    fn in_bytes_names_stand_once_and_everything_comes_back() {
        let bytes = rmp_serde::to_vec_named(&written()).unwrap();
        for name in ["av", "van", "walker"] {
            let times = bytes.windows(name.len()).filter(|some| *some == name.as_bytes()).count();
            assert_eq!(times, 1, "{name}");
        }
        assert_eq!(rmp_serde::from_slice::<Written>(&bytes).unwrap(), written());
        let none = Written(ByMetric::default());
        assert_eq!(rmp_serde::from_slice::<Written>(&rmp_serde::to_vec_named(&none).unwrap()).unwrap(), none);
    }

    #[test]
    fn where_people_read_them_they_are_as_they_are() {
        let Written(all) = written();
        let all: ByMetric<Critical> = all.known().iter().filter(|(index, _)| *index < 3).cloned().collect();
        let text = serde_json::to_string(&Written(all)).unwrap();
        assert!(
            text.starts_with(r#"[[0,{"time":0.30000000000000004,"vehicle":"av","pedestrian":"walker"}]"#),
            "{text}"
        );
        assert!(
            text.ends_with(r#"[2,{"time":null,"vehicle":"van","pedestrian":null,"other":"av"}]]"#),
            "{text}"
        );
        assert_eq!(serde_json::to_string(&serde_json::from_str::<Written>(&text).unwrap()).unwrap(), text);
    }

    #[test]
    fn a_number_of_no_name_is_refused() {
        let one: Packed = (0, None, [Some(1), None, None]);
        let bytes = rmp_serde::to_vec(&(["av"], [one])).unwrap();
        let error = rmp_serde::from_slice::<Written>(&bytes).unwrap_err();
        assert!(error.to_string().contains("no such name"), "{error}");
    }
}
