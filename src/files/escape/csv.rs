//! Cells of CSV files that people open with a spreadsheet.

use super::visible::visible;

/// A cell that no spreadsheet runs: what begins like a formula begins with an apostrophe, which spreadsheets take as a sign
/// that text follows. Numbers are cells of their own and must not come here. The writer of CSV quotes.
///
/// Source: OWASP, "CSV injection"; among the beginnings are those of full width, which some spreadsheets take as well.
pub fn csv_cell(text: &str) -> String {
    let text = visible(text, |_| false);
    let begins = |letter| matches!(letter, '=' | '+' | '-' | '@' | '＝' | '＋' | '－' | '＠');
    if text.trim_start().starts_with(begins) { format!("'{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::escape::hostile;

    #[test]
    fn formulas_are_text() {
        for (cell, safe) in [
            ("=1+1", "'=1+1"),
            ("@SUM(A1)", "'@SUM(A1)"),
            (" +1", "' +1"),
            ("\t=1", "\\t=1"),
            ("－1", "'－1"),
            ("zebra/tta=6s", "zebra/tta=6s"),
            ("", ""),
        ] {
            assert_eq!(csv_cell(cell), safe);
        }
    }

    proptest! {
        #[test]
        fn a_reader_of_csv_reads_the_cells(cells in proptest::collection::vec(hostile::text(), 1..5)) {
            let safe: Vec<String> = cells.iter().map(|cell| csv_cell(cell)).collect();
            let mut writer = ::csv::Writer::from_writer(Vec::new());
            writer.write_record(&safe).unwrap();
            let text = writer.into_inner().unwrap();
            let mut reader = ::csv::ReaderBuilder::new().has_headers(false).from_reader(&text[..]);
            let read = reader.records().next().unwrap().unwrap();
            prop_assert_eq!(read.iter().map(str::to_string).collect::<Vec<_>>(), safe.clone());
            for cell in &safe {
                prop_assert!(!cell.trim_start().starts_with(['=', '+', '-', '@']), "{cell:?}");
            }
        }
    }
}
