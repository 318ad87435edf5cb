//! A shell: one word of a command that somebody types, or that a script has.

/// As one word of a POSIX shell, which leaves everything alone within single quotes but the quote itself.
pub fn shell_word(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}
