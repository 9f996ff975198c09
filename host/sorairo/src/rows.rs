//! The rows of a table (CSV): the only reader of user tables.

use std::path::Path;

use crate::input;

/// Longest line (bytes): a row of cases may say as much as a scene file.
const LONGEST_LINE: usize = 256 << 10;

/// Longest cell (bytes): the longest path of a file.
const LONGEST_CELL: usize = 4096;

/// A row that holds something.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Row {
    /// Its line in the text, from 1.
    pub line: u64,
    /// Its cells, without quotes and the spaces around them.
    pub cells: Vec<String>,
}

impl Row {
    /// A complaint about the row, with its line. Where something else than commas parts the cells, that is what is
    /// wrong.
    pub fn wrong(&self, complaint: &str) -> String {
        match self.parted_by() {
            Some(marks) => {
                format!("line {}: {marks} part the cells; commas are wanted, and points in numbers", self.line)
            }
            None => format!("line {}: {complaint}", self.line),
        }
    }

    /// The same about one of its cells, counted from 0.
    pub fn wrong_in(&self, column: usize, complaint: &str) -> String {
        match self.parted_by() {
            Some(_) => self.wrong(complaint),
            None => format!("line {}, column {}: {complaint}", self.line, column + 1),
        }
    }

    /// What else than commas parts the cells.
    fn parted_by(&self) -> Option<&'static str> {
        let has = |mark| self.cells.iter().any(|cell| cell.contains(mark));
        [(';', "semicolons"), ('\t', "tabs")].into_iter().find(|(mark, _)| has(*mark)).map(|(_, marks)| marks)
    }
}

/// Reads a file of at most `largest` bytes; see [`rows`].
///
/// # Errors
///
/// What is wrong, in words that follow the file's name.
pub fn read(path: &Path, largest: u64) -> Result<String, String> {
    input::read_text(path, largest)
}

/// The rows of a text that hold something. Cells are parted by commas and may be quoted; a byte order mark may come
/// first, and lines may end as on any system. A line that begins with `#` is a comment.
///
/// # Errors
///
/// One sentence with its line: a line or a cell that is too long, a quote that its line does not close.
pub fn rows(text: &str) -> impl Iterator<Item = Result<Row, String>> {
    let lines =
        input::without_mark(text).split('\n').flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'));
    let rows = (1..).zip(lines).filter(|(_, line)| is_row(line)).map(|(line, text)| row(line, text));
    rows.filter(|row| row.as_ref().map_or(true, |row| row.cells.iter().any(|cell| !cell.is_empty())))
}

/// Whether a line is more than a comment, which some programs put into quotes.
fn is_row(line: &str) -> bool {
    let start = line.trim_start();
    !start.is_empty() && !start.trim_start_matches('"').starts_with('#')
}

fn row(line: u64, text: &str) -> Result<Row, String> {
    if text.len() > LONGEST_LINE {
        return Err(format!("line {line}: it is longer than {} KiB, the most that is read", LONGEST_LINE >> 10));
    }
    if !text.matches('"').count().is_multiple_of(2) {
        return Err(format!("line {line}: a quote is opened and not closed"));
    }
    let cells = cells(text);
    match cells.iter().position(|cell| cell.len() > LONGEST_CELL) {
        Some(before) => Err(format!("line {line}: column {} is longer than {LONGEST_CELL} bytes", before + 1)),
        None => Ok(Row { line, cells }),
    }
}

/// The cells of a line. A cell that begins with a quote ends with one: commas between them part no cells, and two
/// quotes stand for one.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    let mut marks = line.chars().peekable();
    while let Some(mark) = marks.next() {
        match mark {
            '"' if is_quoted && marks.next_if_eq(&'"').is_some() => cell.push('"'),
            '"' if is_quoted || cell.trim().is_empty() => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(std::mem::take(&mut cell)),
            other => cell.push(other),
        }
    }
    cells.push(cell);
    cells.into_iter().map(|cell| cell.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Vec<(u64, Vec<String>)> {
        rows(text).map(|row| row.map(|Row { line, cells }| (line, cells)).unwrap()).collect()
    }

    #[test]
    fn whoever_wrote_a_table_its_rows_are_the_same() {
        let row = |line, [first, second]: [&str; 2]| (line, vec![first.to_owned(), second.to_owned()]);
        for text in [
            "a,b\n1,2.5\n",
            "\u{feff}a,b\r\n1,2.5\r\n",
            "a,b\r1,2.5\r",
            "\"a\",\"b\"\r\n\"1\",\"2.5\"",
            " \"a\", \"b\"\n 1 ,\t2.5 ",
            "a,b\n1,2.5\n\n,\n\" \",\n# a comment, \"with a quote\n \"# another, quoted\",\n",
        ] {
            assert_eq!(all(text), [row(1, ["a", "b"]), row(2, ["1", "2.5"])], "{text:?}");
        }
        assert_eq!(
            all("5\" by 6\", \"6, or 7\" , \"\""),
            [(1, ["5\" by 6\"", "6, or 7", ""].map(String::from).into())]
        );
        assert_eq!(all("\n# c\n\n\"a\"\"b,c\",\r\n"), [row(4, ["a\"b,c", ""])]);
    }

    #[test]
    fn a_line_or_a_cell_without_end_is_refused() {
        let long = |count: usize| "9".repeat(count);
        for (text, words) in [
            (format!("1,2\n{}", long(LONGEST_LINE + 1)), "line 2: it is longer than 256 KiB"),
            (",".repeat(LONGEST_LINE + 1), "line 1: it is longer than 256 KiB"),
            (format!("1,2\n3,{}\n", long(LONGEST_CELL + 1)), "line 2: column 2 is longer than 4096 bytes"),
            ("1,2\n\"3,4\n5,6\n".into(), "line 2: a quote is opened and not closed"),
        ] {
            let error = rows(&text).find_map(Result::err).unwrap();
            assert!(error.contains(words) && error.len() < 100, "{error}");
        }
        assert_eq!(all(&format!("1,{}\n", long(LONGEST_CELL)))[0].1[1].len(), LONGEST_CELL);
    }

    #[test]
    fn what_parts_the_cells_is_told() {
        for (text, words) in [
            ("380;0,2\n", "line 1: semicolons part the cells; commas are wanted"),
            ("\n380\t0.2\n", "line 2: tabs part the cells"),
            ("380 0.2\n", "line 1: bad"),
        ] {
            let error = rows(text).next().unwrap().unwrap().wrong("bad");
            assert!(error.starts_with(words), "{error}");
        }
    }
}
