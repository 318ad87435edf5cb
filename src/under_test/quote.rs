//! Texts of programs as faults quote them.

/// A text that stands in one line; whoever shows it escapes it.
pub fn one_line(text: &str) -> String {
    text.chars().map(|one| if one.is_control() { ' ' } else { one }).collect::<String>().trim().to_string()
}

/// A line of a log, as it is indented: what stands below what is what a traceback says.
pub fn log_line(line: &str) -> String {
    let spaced = line.replace('\t', "    ");
    let plain: String = spaced.chars().map(|one| if one.is_control() { ' ' } else { one }).collect();
    plain.trim_end().to_string()
}

/// The beginning of what a program said.
pub fn quoted(said: &[u8]) -> String {
    const MOST: usize = 80;
    let text = String::from_utf8_lossy(&said[..said.len().min(4 * MOST)]);
    let text = one_line(&text);
    match text.char_indices().nth(MOST) {
        Some((at, _)) => format!("`{}…`", &text[..at]),
        None => format!("`{text}`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_keeps_its_indentation() {
        assert_eq!(log_line("  File \"av.py\", line 3\r"), "  File \"av.py\", line 3");
        assert_eq!(log_line("\tat main\u{1b}[0m"), "    at main [0m");
        assert_eq!(one_line("  a\n b "), "a  b");
    }
}
