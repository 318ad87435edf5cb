//! Plain tables for the terminal.

/// Rows in columns, the first to the left, the others to the right, after an indent of two. Rows may be of different
/// lengths; colours must not be in them.
pub fn columns(lines: &[Vec<String>]) -> String {
    let count = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = lines.iter().filter_map(|line| line.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..count).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let mut drawn = String::new();
        for (column, (cell, &width)) in line.iter().zip(&widths).enumerate() {
            drawn += &if column == 0 { format!("  {cell:<width$}") } else { format!("  {cell:>width$}") };
        }
        text += drawn.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_rows_leave_the_rest_empty() {
        let line = |cells: &[&str]| cells.iter().map(|cell| (*cell).to_string()).collect::<Vec<_>>();
        let table = columns(&[line(&["", "pet", "s"]), line(&["–"]), line(&["default", "2.5", "83 %"])]);
        assert_eq!(table, "           pet     s\n  –\n  default  2.5  83 %\n");
    }
}
