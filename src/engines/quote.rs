//! Words for a shell.

use super::error::EngineError;
use files::escape::shell_word;

/// A word as a POSIX shell reads it back, on one line.
///
/// # Errors
/// If it has a line break or a zero byte: it could be none.
pub fn quoted(word: &str) -> Result<String, EngineError> {
    if word.contains(['\n', '\r', '\0']) {
        return Err(EngineError::Refused(format!(
            "{word:?} has a line break or a zero byte, which no task of Slurm may have"
        )));
    }
    Ok(shell_word(word))
}

#[cfg(all(test, unix))]
mod tests {
    use std::process::Command;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]
        #[test]
        fn a_shell_reads_back_what_was_quoted(word in "[^\n\r\0]{0,24}") {
            let script = format!("printf %s {}", quoted(&word).unwrap());
            let output = Command::new("sh").args(["-c", &script]).output().unwrap();
            prop_assert_eq!(String::from_utf8(output.stdout).unwrap(), word);
        }
    }

    #[test]
    fn what_would_be_two_lines_is_refused() {
        assert!(quoted("a\nb").is_err() && quoted("a\0").is_err());
    }
}
