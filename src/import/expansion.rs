//! Expansion: how many cells a workbook will ask for when it is read, found out before it is.
//!
//! A few bytes can say “this cell a million times”, or “a cell in the last row and one in the last column”; the readers behind fill a rectangle.

use super::archive::{u16_at, u32_at};

/// Cells that the content of an ODS workbook stands for, repeats counted; cells and rows that are empty to the end are not.
pub(super) fn of_ods(content: &[u8]) -> u64 {
    let (mut total, mut row, mut empty, mut repeats, mut empty_rows) = (0_u64, 0_u64, 0_u64, 1_u64, 0_u64);
    let mut widest = 0_u64;
    let mut at = 0;
    while let Some(open) = content[at..].iter().position(|&b| b == b'<').map(|i| at + i) {
        let close = content[open..].iter().position(|&b| b == b'>').map_or(content.len(), |i| open + i);
        let tag = &content[open + 1..close];
        at = (close + 1).min(content.len());
        let named = |name: &[u8]| tag.starts_with(name) && tag.get(name.len()).is_none_or(|b| !b.is_ascii_alphanumeric() && *b != b'-');
        if named(b"table:table-row") {
            (row, empty, repeats) = (0, 0, repeated(tag, b"number-rows-repeated"));
        } else if named(b"table:table-cell") || named(b"table:covered-table-cell") {
            let times = repeated(tag, b"number-columns-repeated");
            // A closed cell without a value is empty; it counts only if something follows it in its row.
            if tag.ends_with(b"/") && !contains(tag, b"office:") && !contains(tag, b"formula") {
                empty = empty.saturating_add(times);
            } else {
                row = row.saturating_add(empty).saturating_add(times);
                empty = 0;
            }
        } else if named(b"/table:table-row") {
            if row == 0 {
                empty_rows = empty_rows.saturating_add(repeats);
            } else {
                widest = widest.max(row);
                // Rows in between are filled as wide as the widest.
                total = total.saturating_add(row.max(widest).saturating_mul(repeats)).saturating_add(widest.saturating_mul(empty_rows));
                empty_rows = 0;
            }
        } else if named(b"/table:table") {
            (empty_rows, widest) = (0, 0);
        }
    }
    total
}

fn contains(text: &[u8], part: &[u8]) -> bool {
    text.windows(part.len()).any(|window| window == part)
}

/// The number that an attribute says; 1 if it is not there.
fn repeated(tag: &[u8], attribute: &[u8]) -> u64 {
    let Some(at) = tag.windows(attribute.len()).position(|window| window == attribute) else { return 1 };
    let digits = tag[at + attribute.len()..].iter().skip_while(|b| !b.is_ascii_digit()).take_while(|b| b.is_ascii_digit());
    digits.fold(0_u64, |number, digit| number.saturating_mul(10).saturating_add(u64::from(digit - b'0')))
}

/// Cells of the largest rectangle that a sheet of an XLS workbook spans.
///
/// # Errors
/// The problem, as a sentence, if the file is damaged.
pub(super) fn of_xls(file: &[u8]) -> Result<u64, String> {
    let broken = || "the workbook is damaged: its parts cannot be found".to_owned();
    let stream = compound::workbook(file).ok_or_else(broken)?;
    let mut sheets = Vec::new();
    for record in records(&stream, 0) {
        match record.kind {
            0x0085 => sheets.push(u32_at(record.data, 0).ok_or_else(broken)? as usize),
            0x000A => break,
            _ => (),
        }
    }
    let mut largest = 0;
    for start in sheets {
        if stream.len() <= start {
            return Err(broken());
        }
        largest = largest.max(sheet(&stream, start).ok_or_else(broken)?);
    }
    Ok(largest)
}

/// Cells of the rectangle that one sheet spans; `None` if a record is cut off.
fn sheet(stream: &[u8], start: usize) -> Option<u64> {
    let (mut rows, mut columns, mut stated) = ([u64::MAX, 0], [u64::MAX, 0], 0);
    let mut seen = |row: u16, column: u64| {
        let row = u64::from(row);
        rows = [rows[0].min(row), rows[1].max(row)];
        columns = [columns[0].min(column), columns[1].max(column)];
    };
    let mut depth = 0_usize;
    for record in records(stream, start) {
        match record.kind {
            0x0809 => depth += 1,
            0x000A if depth <= 1 => break,
            0x000A => depth -= 1,
            // The size that the sheet states; space for it is set aside at once.
            0x0200 => {
                let [first_row, last_row, first, last] = match record.data.len() {
                    10 => [0, 2, 4, 6].map(|at| u16_at(record.data, at).map(u64::from)),
                    _ => [
                        u32_at(record.data, 0).map(u64::from),
                        u32_at(record.data, 4).map(u64::from),
                        u16_at(record.data, 8).map(u64::from),
                        u16_at(record.data, 10).map(u64::from),
                    ],
                };
                stated = last_row?.checked_sub(first_row?)?.saturating_mul(last?.checked_sub(first?)?);
            }
            0x0203 | 0x0204 | 0x00D6 | 0x0205 | 0x027E | 0x00FD | 0x0006 => {
                seen(u16_at(record.data, 0)?, u16_at(record.data, 2)?.into());
            }
            0x00BD => {
                let first = u64::from(u16_at(record.data, 2)?);
                seen(u16_at(record.data, 0)?, first);
                seen(u16_at(record.data, 0)?, first + record.data.len() as u64 / 6);
            }
            _ => (),
        }
    }
    let spanned = if rows[0] == u64::MAX { 0 } else { (rows[1] - rows[0] + 1) * (columns[1] - columns[0] + 1) };
    Some(spanned.max(stated))
}

struct Record<'a> {
    kind: u16,
    data: &'a [u8],
}

fn records(stream: &[u8], start: usize) -> impl Iterator<Item = Record<'_>> {
    let mut at = start;
    std::iter::from_fn(move || {
        let (kind, length) = (u16_at(stream, at)?, u16_at(stream, at + 2)? as usize);
        let data = stream.get(at + 4..at + 4 + length)?;
        at += 4 + length;
        Some(Record { kind, data })
    })
}

/// Compound files, as far as it takes to find the stream of a workbook ([MS-CFB]).
mod compound {
    use super::{u16_at, u32_at};

    /// Greater sector numbers are marks.
    const LAST: u32 = 0xFFFF_FFFA;

    pub(super) fn workbook(file: &[u8]) -> Option<Vec<u8>> {
        let shift = u16_at(file, 30)?;
        if ![9, 12].contains(&shift) {
            return None;
        }
        let size = 1_usize << shift;
        let sector = |id: u32| {
            let start = (id as usize).checked_add(1)?.checked_mul(size)?;
            // The last sector of a file may be cut short.
            file.get(start..file.len().min(start.checked_add(size)?))
        };
        let most = file.len() / size + 1;
        let words = |bytes: &[u8]| bytes.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect::<Vec<_>>();
        let mut lists = words(file.get(76..512)?);
        let mut next = u32_at(file, 68)?;
        for _ in 0..most {
            if LAST <= next {
                break;
            }
            lists.extend(words(sector(next)?));
            next = lists.pop()?;
        }
        let mut table = Vec::new();
        for &id in lists.iter().filter(|&&id| id < LAST).take(most) {
            table.extend(words(sector(id)?));
        }
        let directory = chain(u32_at(file, 48)?, &table, most, sector)?;
        let entries: Vec<&[u8]> = directory.chunks_exact(128).collect();
        let name = |entry: &[u8]| {
            let units: Vec<u16> = entry[..64].chunks_exact(2).map(|c| u16::from_le_bytes([c[0], c[1]])).take_while(|&c| c != 0).collect();
            String::from_utf16_lossy(&units).to_lowercase()
        };
        let entry = ["workbook", "book"].iter().find_map(|wanted| entries.iter().find(|entry| name(entry) == *wanted))?;
        let (start, length) = (u32_at(entry, 116)?, u32_at(entry, 120)? as usize);
        let mut stream = if length < 4096 {
            let mini = chain(u32_at(entries.first()?, 116)?, &table, most, sector)?;
            let mini_table = words(&chain(u32_at(file, 60)?, &table, most, sector)?);
            let piece = |id: u32| mini.get(id as usize * 64..mini.len().min(id as usize * 64 + 64));
            chain(start, &mini_table, mini.len() / 64 + 1, piece)?
        } else {
            chain(start, &table, most, sector)?
        };
        stream.truncate(length);
        Some(stream)
    }

    fn chain<'a>(start: u32, table: &[u32], most: usize, sector: impl Fn(u32) -> Option<&'a [u8]>) -> Option<Vec<u8>> {
        let (mut bytes, mut id) = (Vec::new(), start);
        for _ in 0..most {
            if LAST <= id {
                return Some(bytes);
            }
            bytes.extend_from_slice(sector(id)?);
            id = *table.get(id as usize)?;
        }
        (LAST <= id).then_some(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_are_counted_and_empty_ends_are_not() {
        let cell = r#"<table:table-cell office:value-type="float" office:value="1"><text:p>1</text:p></table:table-cell>"#;
        let end = r#"<table:table-cell table:number-columns-repeated="16382"/>"#;
        let empty = r#"<table:table-row table:number-rows-repeated="1048570"><table:table-cell table:number-columns-repeated="16384"/></table:table-row>"#;
        let sheet = |rows: &str| of_ods(format!("<table:table table:name=\"a\">{rows}</table:table>").as_bytes());
        assert_eq!(sheet(&format!("<table:table-row>{cell}{cell}{end}</table:table-row>{empty}")), 2);
        assert_eq!(sheet(&format!("<table:table-row>{end}{cell}</table:table-row>")), 16383);
        let bomb = r#"<table:table-cell office:value="1" table:number-columns-repeated="16384"/>"#;
        assert_eq!(sheet(&format!("<table:table-row table:number-rows-repeated=\"1000000\">{bomb}</table:table-row>")), 16_384_000_000);
        assert!(1_048_570 <= sheet(&format!("{empty}<table:table-row>{cell}</table:table-row>")));
    }
}
