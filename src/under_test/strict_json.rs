//! JSON as programs say it: no key of an object twice, since one of the two would be lost without a word.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value as Json};

/// A text that a program said.
///
/// # Errors
/// What is wrong with it, to be put after the text: `is no JSON`, or which key it has twice.
pub fn read(text: &[u8]) -> Result<Json, String> {
    let mut reader = serde_json::Deserializer::from_slice(text);
    let read = Strict.deserialize(&mut reader).and_then(|value| reader.end().map(|()| value));
    read.map_err(|error| match error.to_string().split_once(TWICE) {
        Some((_, rest)) => format!("has the key {} twice", rest.split(" at line ").next().unwrap_or(rest)),
        None => "is no JSON".to_string(),
    })
}

/// Stands before the key in the error of the reader.
const TWICE: &str = "twice the key ";

/// Reads a value that has each key of its objects once.
struct Strict;

impl<'de> DeserializeSeed<'de> for Strict {
    type Value = Json;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<Json, D::Error> {
        from.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Strict {
    type Value = Json;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Json, E> {
        Ok(Json::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Json, E> {
        Ok(Json::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Json, E> {
        Ok(Json::from(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Json, E> {
        Ok(Json::from(value))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Json, E> {
        Ok(Number::from_f64(value).map_or(Json::Null, Json::Number))
    }

    fn visit_str<E>(self, value: &str) -> Result<Json, E> {
        Ok(Json::from(value))
    }

    fn visit_string<E>(self, value: String) -> Result<Json, E> {
        Ok(Json::String(value))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<Json, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = from.next_element_seed(Strict)? {
            items.push(item);
        }
        Ok(Json::Array(items))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut from: A) -> Result<Json, A::Error> {
        let mut fields = Map::new();
        while let Some(key) = from.next_key::<String>()? {
            let value = from.next_value_seed(Strict)?;
            if fields.contains_key(&key) {
                return Err(A::Error::custom(format!("{TWICE}`{key}`")));
            }
            fields.insert(key, value);
        }
        Ok(Json::Object(fields))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_once_is_read_as_ever() {
        let text = r#"{"answer":[{"acceleration":-1.5,"mode":"a","more":[null,true,3,-4,1e3,{"x":{}}]}]} "#;
        let plain: Json = serde_json::from_str(text).unwrap();
        assert_eq!(read(text.as_bytes()), Ok(plain));
        for wrong in ["", "{", "{}{}", "nan", "\u{feff}{}"] {
            assert_eq!(read(wrong.as_bytes()), Err("is no JSON".to_string()), "{wrong}");
        }
        assert_eq!(read(b"\"\xff\""), Err("is no JSON".to_string()));
    }

    #[test]
    fn what_is_said_twice_is_refused_wherever_it_stands() {
        let twice = |key: &str| Err(format!("has the key `{key}` twice"));
        assert_eq!(read(br#"{"acceleration":0,"acceleration":-8}"#), twice("acceleration"));
        assert_eq!(read(br#"{"answer":[{"a":{"b":1,"b":1}}]}"#), twice("b"));
        // The same key, differently written.
        assert_eq!(read(br#"{"speed":1,"\u0073peed":2}"#), twice("speed"));
    }
}
