//! What commands a reader's program instead of being read, shown as what it is.

/// Whether a character is not read but obeyed, or is no character at all: control characters (line ends and tabs among
/// them), what changes the direction of text, separators of lines and paragraphs, byte order marks, interlinear
/// marks, tags and noncharacters.
pub fn is_command(letter: char) -> bool {
    letter.is_control()
        || matches!(letter,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{206f}'
            | '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}'
            | '\u{fdd0}'..='\u{fdef}')
        || u32::from(letter) & 0xfffe == 0xfffe
}

/// The text as JSON in which nothing is obeyed: read back it is the same.
pub fn json_text(text: &str) -> String {
    let mut shown = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => shown.extend(['\\', letter]),
            letter if is_command(letter) => {
                let mut units = [0; 2];
                let units = letter.encode_utf16(&mut units).iter();
                shown.extend(units.map(|unit| format!("\\u{unit:04x}")));
            }
            letter => shown.push(letter),
        }
    }
    shown + "\""
}

/// The text with commands shown as what they are, but for those that may stay.
pub(super) fn visible(text: &str, may_stay: impl Fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for letter in text.chars() {
        push_visible(&mut shown, letter, &may_stay);
    }
    shown
}

pub(super) fn push_visible(shown: &mut String, letter: char, may_stay: &impl Fn(char) -> bool) {
    if is_command(letter) && !may_stay(letter) {
        // `\n` and the like by their letters, others by their numbers.
        match letter {
            '\n' => shown.push_str("\\n"),
            '\r' => shown.push_str("\\r"),
            '\t' => shown.push_str("\\t"),
            _ => shown.extend(letter.escape_unicode()),
        }
    } else {
        shown.push(letter);
    }
}

/// Line ends and tabs, of which text is made.
pub(super) fn is_layout(letter: char) -> bool {
    matches!(letter, '\n' | '\t')
}
