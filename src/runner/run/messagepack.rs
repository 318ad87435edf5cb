//! The one writer and the one reader of MessagePack, in which jobs and results are kept and sent.
//!
//! With a second reader, serde's code of each type would be compiled a second time.

use std::io::ErrorKind;

use rmp_serde::decode::{Deserializer, Error, ReadRefReader};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Reads values from a slice, one after the other.
pub(super) type Reader<'b> = Deserializer<ReadRefReader<'b, [u8]>>;

/// Writes plain data with the names of its fields, which carries every number to its last bit.
pub(crate) fn to_messagepack(data: &impl Serialize) -> Vec<u8> {
    rmp_serde::to_vec_named(data).expect("plain data is encoded, and memory takes it")
}

/// Reads what [`to_messagepack`] wrote.
///
/// # Errors
/// In the words of the decoder, if the bytes are something else or more bytes follow.
pub(super) fn from_messagepack<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    read_last(&mut Reader::from_read_ref(bytes))
}

/// Reads the last value of a slice.
///
/// # Errors
/// In the words of the decoder, if the bytes are something else or more bytes follow.
pub(super) fn read_last<T: DeserializeOwned>(reader: &mut Reader) -> Result<T, String> {
    let value = T::deserialize(&mut *reader).map_err(|error| error.to_string())?;
    // The reader does not say how many bytes are left. Only at the end does it find no marker of another value, of which no part is read.
    match <()>::deserialize(reader) {
        Err(Error::InvalidMarkerRead(error)) if error.kind() == ErrorKind::UnexpectedEof => Ok(value),
        _ => Err("more bytes follow it".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_read_to_its_end_and_no_further() {
        let value = (vec![Some(0.1 + 0.2), None], "av".to_string(), None::<u8>);
        let bytes = to_messagepack(&value);
        assert_eq!(from_messagepack(&bytes), Ok(value.clone()));
        for length in 0..bytes.len() {
            assert!(from_messagepack::<(Vec<Option<f64>>, String, Option<u8>)>(&bytes[..length]).is_err());
        }
        // The value again, the beginning of it, and each single byte, whether or not it begins a value.
        let followed =
            [bytes.clone(), bytes[..9].to_vec()].into_iter().chain((0..=255).map(|byte| vec![byte]));
        for more in followed {
            let longer = [bytes.clone(), more].concat();
            let read = from_messagepack::<(Vec<Option<f64>>, String, Option<u8>)>(&longer);
            assert_eq!(read, Err("more bytes follow it".to_string()), "{longer:?}");
        }
    }
}
