//! Tables of an SQLite database, read row by row from its bytes.
//!
//! The layout is that of "Database File Format" (sqlite.org/fileformat2.html). Only what the bags of ROS 2 have is read:
//! ordinary tables with texts in UTF-8. A library would bring SQLite's C sources along, more than the rest of the logs.

/// A database.
pub(crate) struct Database<'a> {
    bytes: &'a [u8],
    page: usize,
    /// Bytes of a page that hold content.
    usable: usize,
}

/// A value of a row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Null,
    Integer(i64),
    Real,
    Text(String),
    Blob(Vec<u8>),
}

impl Value {
    pub fn integer(&self) -> Option<i64> {
        if let Self::Integer(n) = self { Some(*n) } else { None }
    }

    pub fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }
}

/// A table of the database: where it begins, and its columns.
pub(crate) struct TableAt {
    root: usize,
    columns: Vec<String>,
}

impl TableAt {
    /// The place of a column.
    pub fn column(&self, name: &str) -> Result<usize, String> {
        let at = self.columns.iter().position(|c| c.eq_ignore_ascii_case(name));
        at.ok_or_else(|| format!("a table has no column '{name}'"))
    }
}

/// What a database begins with.
pub(crate) const MAGIC: &[u8] = b"SQLite format 3\0";

const BROKEN: &str = "its pages contradict each other";

/// What is done with every row: its number and its values.
type Visit<'v> = dyn FnMut(i64, Vec<Value>) -> Result<(), String> + 'v;

impl<'a> Database<'a> {
    pub fn open(bytes: &'a [u8]) -> Result<Self, String> {
        if bytes.len() < 100 || !bytes.starts_with(MAGIC) {
            return Err("its header is broken".to_owned());
        }
        // A size of 65536 does not fit into the two bytes, and is written as 1.
        let page = match usize::from(bytes[16]) << 8 | usize::from(bytes[17]) {
            1 => 65_536,
            size => size,
        };
        let usable = page.checked_sub(usize::from(bytes[20])).filter(|&u| u >= 480);
        match usable {
            Some(usable) if page.is_power_of_two() => Ok(Self { bytes, page, usable }),
            _ => Err(format!("its header claims pages of {page} bytes")),
        }
    }

    /// The bytes of a page, from 1.
    fn page(&self, number: usize) -> Result<&'a [u8], String> {
        let from = number.checked_sub(1).and_then(|n| n.checked_mul(self.page));
        let bytes = from.and_then(|from| self.bytes.get(from..from.checked_add(self.page)?));
        bytes.map(|b| &b[..self.usable]).ok_or_else(|| format!("page {number} is not in the file"))
    }

    /// The table of this name, if there is one.
    pub fn table(&self, name: &str) -> Result<Option<TableAt>, String> {
        let mut found = None;
        let schema = TableAt { root: 1, columns: Vec::new() };
        self.rows(&schema, &mut |_, values| {
            if let [Value::Text(kind), Value::Text(own), _, Value::Integer(root), Value::Text(sql), ..] =
                &values[..]
                && kind == "table"
                && own == name
            {
                found = Some(TableAt { root: usize::try_from(*root).unwrap_or(0), columns: columns(sql) });
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Gives every row, with its number, in their order.
    pub fn rows(&self, table: &TableAt, visit: &mut Visit) -> Result<(), String> {
        let pages = self.bytes.len() / self.page + 1;
        let mut stack = vec![table.root];
        let (mut seen, mut left) = (0, self.bytes.len());
        while let Some(number) = stack.pop() {
            // A page that is reached twice is one of a circle.
            seen += 1;
            if seen > pages {
                return Err(BROKEN.to_owned());
            }
            let page = self.page(number)?;
            let head = if number == 1 { 100 } else { 0 };
            let cells = short(page, head + 3).ok_or(BROKEN)?;
            let interior = match page.get(head) {
                Some(5) => true,
                Some(13) => false,
                _ => return Err(BROKEN.to_owned()),
            };
            let pointers = head + if interior { 12 } else { 8 };
            let cell = |i: usize| short(page, pointers + 2 * i).ok_or(BROKEN);
            if interior {
                if cells > self.usable / 6 {
                    return Err(BROKEN.to_owned());
                }
                stack.push(long(page, head + 8).ok_or(BROKEN)?);
                for i in (0..cells).rev() {
                    stack.push(long(page, cell(i)?).ok_or(BROKEN)?);
                }
            } else {
                for i in 0..cells {
                    self.row(page, cell(i)?, &mut left, visit)?;
                }
            }
        }
        Ok(())
    }

    /// The row whose cell stands here; all rows together have no more bytes than are `left`, those of the file.
    fn row(&self, page: &[u8], mut at: usize, left: &mut usize, visit: &mut Visit) -> Result<(), String> {
        let size = usize::try_from(varint(page, &mut at).ok_or(BROKEN)?).map_err(|_| BROKEN)?;
        let number = varint(page, &mut at).ok_or(BROKEN)?.cast_signed();
        *left = left.checked_sub(size).ok_or_else(|| format!("row {number} claims {size} bytes"))?;
        let most = self.usable - 35;
        let local = if size <= most {
            size
        } else {
            let least = (self.usable - 12) * 32 / 255 - 23;
            let kept = least + (size - least) % (self.usable - 4);
            if kept <= most { kept } else { least }
        };
        let mut payload = page.get(at..at + local).ok_or(BROKEN)?.to_vec();
        let mut next = if local < size { long(page, at + local).ok_or(BROKEN)? } else { 0 };
        while payload.len() < size {
            let page = self.page(next)?;
            next = long(page, 0).ok_or(BROKEN)?;
            payload.extend(&page[4..(4 + size - payload.len()).min(self.usable)]);
        }
        visit(number, values(&payload).ok_or_else(|| format!("row {number} is broken"))?)
    }
}

fn short(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..at + 2).map(|b| usize::from(b[0]) << 8 | usize::from(b[1]))
}

fn long(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..at + 4).map(|b| b.iter().fold(0, |sum, &b| sum << 8 | usize::from(b)))
}

/// A number of one to nine bytes.
fn varint(bytes: &[u8], at: &mut usize) -> Option<u64> {
    let mut value = 0;
    for i in 0..9 {
        let byte = *bytes.get(*at)?;
        *at += 1;
        if i == 8 {
            return Some(value << 8 | u64::from(byte));
        }
        value = value << 7 | u64::from(byte & 0x7F);
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

/// The values of a row.
fn values(payload: &[u8]) -> Option<Vec<Value>> {
    let mut at = 0;
    let head = usize::try_from(varint(payload, &mut at)?).ok()?;
    let mut body = head;
    let mut values = Vec::new();
    while at < head {
        let kind = varint(payload, &mut at)?;
        let mut take = |count: usize| {
            let bytes = payload.get(body..body.checked_add(count)?);
            body += count;
            bytes
        };
        let integer = |bytes: &[u8]| {
            let unused = 64 - 8 * bytes.len() as u32;
            let bits = bytes.iter().fold(0u64, |sum, &b| sum << 8 | u64::from(b));
            Value::Integer((bits << unused).cast_signed() >> unused)
        };
        values.push(match kind {
            0 => Value::Null,
            1..=4 => integer(take(kind as usize)?),
            5 => integer(take(6)?),
            6 => integer(take(8)?),
            7 => take(8).map(|_| Value::Real)?,
            8 => Value::Integer(0),
            9 => Value::Integer(1),
            10 | 11 => return None,
            blob if blob % 2 == 0 => Value::Blob(take(usize::try_from((blob - 12) / 2).ok()?)?.to_vec()),
            text => {
                let bytes = take(usize::try_from((text - 13) / 2).ok()?)?;
                Value::Text(String::from_utf8_lossy(bytes).into_owned())
            }
        });
    }
    Some(values)
}

/// The names of columns in `CREATE TABLE name(first TYPE, second TYPE)`.
fn columns(sql: &str) -> Vec<String> {
    let inside = sql.split_once('(').map_or("", |(_, rest)| rest);
    let names = inside.split(',').filter_map(|part| part.split_whitespace().next());
    names.map(|name| name.trim_matches(['"', '`', '[', ']', ')']).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_any_length_are_read() {
        for (bytes, value) in [
            (&[0x7F][..], 127),
            (&[0x81, 0x00], 128),
            (&[0xFF; 9], u64::MAX),
            (&[0x81, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x01], (1 << 57) + 1),
        ] {
            assert_eq!(varint(bytes, &mut 0), Some(value));
        }
        assert_eq!(varint(&[0x80], &mut 0), None);
        let row = [5, 1, 2, 19, 16, 0xFF, 0x01, 0x00, b'a', b'b', b'c', 9, 8];
        let expected =
            [Value::Integer(-1), Value::Integer(256), Value::Text("abc".into()), Value::Blob(vec![9, 8])];
        assert_eq!(values(&row).unwrap(), expected);
        assert_eq!(columns("CREATE TABLE t(id INTEGER PRIMARY KEY, \"name\" TEXT)"), ["id", "name"]);
    }
}
