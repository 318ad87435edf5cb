//! A shell: one word of a command that somebody types, or that a script has.

use super::visible::is_command;

/// As one word of a POSIX shell, which leaves everything alone within single quotes but the quote itself. The word is one line of letters
/// that can be read and copied: what could not is made by `printf`.
pub fn shell_word(text: &str) -> String {
    // A command that is put in place gives no line ends at its end.
    let (text, line_ends) = text.split_at(text.trim_end_matches('\n').len());
    let word = match text.contains(is_command) {
        false => format!("'{}'", text.replace('\'', r"'\''")),
        true => format!("\"$(printf '{}')\"", printed(text)),
    };
    if line_ends.is_empty() { word } else { format!("{word}'{line_ends}'") }
}

/// What `printf` is given within single quotes so that it says the text, and takes it for no option.
fn printed(text: &str) -> String {
    let mut format = String::new();
    for letter in text.chars() {
        match letter {
            '-' if format.is_empty() => format.push_str(r"\055"),
            '%' => format.push_str("%%"),
            '\\' => format.push_str(r"\\"),
            letter if letter == '\'' || is_command(letter) => {
                let mut bytes = [0; 4];
                let octal = letter.encode_utf8(&mut bytes).bytes().map(|byte| format!(r"\{byte:03o}"));
                format.extend(octal);
            }
            letter => format.push(letter),
        }
    }
    format
}

/// The path of a file as one word of a POSIX shell: as it is where nothing in it means anything to a shell. No program takes it for an option.
pub fn shell_path(path: &str) -> String {
    let path = if path.starts_with('-') { format!("./{path}") } else { path.to_string() };
    let is_plain =
        |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '/' | '.' | '_' | '-' | '+' | '@');
    if !path.is_empty() && path.chars().all(is_plain) { path } else { shell_word(&path) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    #[cfg(unix)]
    use crate::escape::hostile;

    #[test]
    fn words_are_one_line_but_for_line_ends_at_their_end() {
        assert_eq!(shell_word("a b"), "'a b'");
        assert_eq!(shell_word("it's $HOME `x` \"y\""), r#"'it'\''s $HOME `x` "y"'"#);
        assert_eq!(shell_word("a\n100%'\\\u{1b}[m"), r#""$(printf 'a\012100%%\047\\\033[m')""#);
        assert_eq!(shell_word("-1\t"), r#""$(printf '\0551\011')""#);
        assert_eq!(shell_word("a\n"), "'a''\n'");
        assert_eq!(shell_word(""), "''");
    }

    #[test]
    fn plain_paths_stay_as_they_are() {
        assert_eq!(shell_path("suites/zebra.suite"), "suites/zebra.suite");
        assert_eq!(shell_path("a;touch HACK/zebra.suite"), "'a;touch HACK/zebra.suite'");
        assert_eq!(shell_path("-x.suite"), "./-x.suite");
        assert_eq!(shell_path("~/x.suite"), "'~/x.suite'");
        assert_eq!(shell_path(""), "''");
    }

    /// What a shell makes of these words, each followed by a NUL.
    #[cfg(unix)]
    fn evaluated(words: &[String]) -> Vec<String> {
        let command = format!("printf '%s\\0' {}", words.join(" "));
        let output =
            std::process::Command::new("sh").arg("-c").arg(&command).output().expect("there is a shell");
        let said = String::from_utf8(output.stdout).expect("it is text");
        said.split_terminator('\0').map(str::to_string).collect()
    }

    #[cfg(unix)]
    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn a_shell_reads_what_was_said(texts in proptest::collection::vec(hostile::text(), 1..8)) {
            // No file and no word of a command has a NUL.
            let texts: Vec<String> = texts.iter().map(|text| text.replace('\0', "")).collect();
            let words: Vec<String> = texts.iter().map(|text| shell_word(text)).collect();
            prop_assert_eq!(&evaluated(&words), &texts);
            for (word, text) in words.iter().zip(&texts) {
                let line = word.trim_end_matches(['\n', '\'']);
                prop_assert!(!line.contains(is_command), "{:?} of {:?}", word, text);
            }
            let paths: Vec<String> = texts.iter().map(|text| shell_path(text)).collect();
            for (path, text) in evaluated(&paths).iter().zip(&texts) {
                let named = if text.starts_with('-') { format!("./{text}") } else { text.clone() };
                prop_assert_eq!(path, &named);
            }
        }
    }
}
