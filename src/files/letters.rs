//! Bytes as letters: hexadecimal digits, and base64 (RFC 4648, section 4, with padding).

const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// What each letter stands for, and this where it stands for nothing.
const VALUES: [u8; 256] = values();
const NO_LETTER: u8 = 64;

const fn values() -> [u8; 256] {
    let mut values = [NO_LETTER; 256];
    let mut value = 0;
    while value < LETTERS.len() {
        values[LETTERS[value] as usize] = value as u8;
        value += 1;
    }
    values
}

/// Two small digits a byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let mut text = String::with_capacity(2 * bytes.len());
    for byte in bytes {
        text.push(char::from(DIGITS[usize::from(byte >> 4)]));
        text.push(char::from(DIGITS[usize::from(byte & 15)]));
    }
    text
}

/// Four letters for three bytes.
pub fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for some in bytes.chunks(3) {
        let number = (0..3)
            .fold(0, |number, place| number << 8 | u32::from(some.get(place).copied().unwrap_or_default()));
        for place in 0..4 {
            let letter = LETTERS[(number >> (18 - 6 * place) & 63) as usize];
            text.push(if place <= some.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

/// What [`base64`] wrote; `None` for anything else, also for other letters of the same bytes.
pub fn from_base64(text: &str) -> Option<Vec<u8>> {
    let letters = text.as_bytes();
    if !letters.len().is_multiple_of(4) {
        return None;
    }
    let mut bytes = Vec::with_capacity(letters.len() / 4 * 3);
    let last = (letters.len() / 4).saturating_sub(1);
    for (index, four) in letters.chunks(4).enumerate() {
        let whole = [0, 1, 2, 3].map(|place| VALUES[usize::from(four[place])]);
        if whole.iter().all(|value| *value != NO_LETTER) {
            let number = whole.iter().fold(0, |number, value| number << 6 | u32::from(*value));
            bytes.extend_from_slice(&[(number >> 16) as u8, (number >> 8) as u8, number as u8]);
            continue;
        }
        let known = four.iter().rposition(|letter| *letter != b'=').map_or(0, |place| place + 1);
        if known < 2 || known < 4 && index != last {
            return None;
        }
        let mut number = 0;
        for letter in &four[..known] {
            let value = VALUES[usize::from(*letter)];
            if value == NO_LETTER {
                return None;
            }
            number = number << 6 | u32::from(value);
        }
        number <<= 6 * (4 - known);
        let three = [(number >> 16) as u8, (number >> 8) as u8, number as u8];
        if three[known - 1..].iter().any(|rest| *rest != 0) {
            return None;
        }
        bytes.extend_from_slice(&three[..known - 1]);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn it_is_that_of_the_standard() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
            assert_eq!(from_base64(text).unwrap(), bytes.as_bytes());
        }
        for other in ["Zg", "Zg=", "Zh==", "Zm9=", "Z===", "====", "Zg==Zg==", "Zm9v\n", "Zm9\u{e4}"] {
            assert_eq!(from_base64(other), None, "{other}");
        }
    }

    #[test]
    fn hexadecimal_digits_are_small_and_two_a_byte() {
        assert_eq!(hexadecimal(&[0, 10, 255]), "000aff");
    }

    proptest! {
        #[test]
        fn bytes_come_back(bytes: Vec<u8>) {
            prop_assert_eq!(from_base64(&base64(&bytes)), Some(bytes));
        }
    }
}
