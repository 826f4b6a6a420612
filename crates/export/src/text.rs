//! Numbers, names and comments as XML and Python take them.

use crate::{ExportError, Note};

/// A number that reads back to the same bits, as short as can be.
pub fn num(value: f64) -> String {
    // Minus zero reads as a mistake.
    let value = if value == 0.0 { 0.0 } else { value };
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if plain.len() <= exponent.len() + 2 { plain } else { exponent }
}

/// A number with five digits, as a note tells it.
pub fn told(value: f64) -> String {
    num(format!("{value:.4e}").parse().unwrap_or(value))
}

/// Numbers with blanks between them.
pub fn nums(values: &[f64]) -> String {
    values.iter().map(|v| num(*v)).collect::<Vec<_>>().join(" ")
}

/// Text inside an attribute or an element.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// A line of a comment: no control characters, and none of what ends a comment of XML or a Python string.
pub fn comment_line(text: &str) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    plain.replace("--", "- -").replace("\"\"\"", "'''").replace('\\', "/")
}

/// What a file says at its head: what it is, and the notes.
pub fn head(title: &str, notes: &[Note]) -> Vec<String> {
    let mut lines = vec![comment_line(title), String::new()];
    lines.extend(notes.iter().map(|note| comment_line(&note.to_string())));
    lines
}

/// The head as a comment of XML.
pub fn xml_head(title: &str, notes: &[Note]) -> String {
    let body: Vec<String> =
        head(title, notes).iter().map(|l| format!("  {l}").trim_end().to_owned()).collect();
    format!("<!--\n{}\n-->\n", body.join("\n"))
}

/// The name of a Python module beside a file: letters, digits and `_`.
pub fn module(stem: &str) -> String {
    let name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if name.starts_with(|c: char| c.is_ascii_digit()) { format!("_{name}") } else { name }
}

/// Whether files can be named after a stem.
///
/// # Errors
///
/// [`ExportError::Stem`] for one that is empty or has no letter or digit.
pub fn check_stem(stem: &str) -> Result<(), ExportError> {
    if stem.chars().any(|c| c.is_ascii_alphanumeric()) {
        return Ok(());
    }
    Err(ExportError::Stem { stem: stem.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_tells_five_digits() {
        assert_eq!(
            [-0.002_801_805_166, 0.25, 1234567.0, 0.0].map(told),
            ["-0.0028018", "0.25", "1234600", "0"]
        );
    }

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        for value in [655_000.0, 1.061_032_953_945_969e-4, 0.1 + 0.2, -0.0, 294.25, 2.5e10, 1e-12, -3.0] {
            let read: f64 = num(value).parse().unwrap();
            assert_eq!(read, value, "{}", num(value));
        }
        assert_eq!(
            (num(655_000.0).as_str(), num(1e-12).as_str(), num(-0.0).as_str()),
            ("655000", "1e-12", "0")
        );
    }

    #[test]
    fn no_text_ends_a_comment_or_an_attribute() {
        let note = Note::lost("a--b -->", "c\"\"\" \\\n");
        let head = xml_head("t", &[note]);
        assert_eq!(head.matches("--").count(), 2, "{head}");
        assert!(!head.contains("\"\"\"") && !head.contains('\\'));
        assert_eq!(escaped("<a & \"b\">\u{1b}"), "&lt;a &amp; &quot;b&quot;&gt; ");
    }

    #[test]
    fn a_module_has_a_name_that_python_takes() {
        assert_eq!((module("my-bench.v2").as_str(), module("2nd").as_str()), ("my_bench_v2", "_2nd"));
        assert!(check_stem("--").is_err() && check_stem("a").is_ok());
    }
}
