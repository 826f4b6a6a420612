//! Texts in other encodings than UTF-8, as spreadsheets and instruments save them.

use std::borrow::Cow;

/// Bytes that tell whether a file is a text: a header and some rows.
const LOOKED_AT: usize = 4096;

/// A text in UTF-16 or Latin-1, as spreadsheets and instruments save it, in UTF-8. UTF-16 begins with a mark; what is no UTF-8, but
/// has no control characters either, is Latin-1.
pub(crate) fn in_utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    let big = match bytes {
        [0xff, 0xfe, ..] => false,
        [0xfe, 0xff, ..] => true,
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            let start = &bytes[..bytes.len().min(LOOKED_AT)];
            let is_text = |b: &u8| matches!(b, b'\t' | b'\n' | b'\r' | 0x20..=0x7e | 0xa0..);
            return match start.iter().all(is_text) && std::str::from_utf8(bytes).is_err() {
                true => Cow::Owned(bytes.iter().map(|&b| char::from(b)).collect::<String>().into_bytes()),
                false => Cow::Borrowed(bytes),
            };
        }
    };
    Cow::Owned(of_utf16(&bytes[2..], big).into_bytes())
}

/// A text of UTF-16, with `big` the high byte first.
pub(crate) fn of_utf16(bytes: &[u8], big: bool) -> String {
    let unit = if big { u16::from_be_bytes } else { u16::from_le_bytes };
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}
