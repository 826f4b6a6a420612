//! What a parser says of a file, in the words of who wrote the file.

/// What the parser says and what is meant; the longer of two that begin alike comes first.
const WORDS: [(&str, &str); 12] = [
    ("unknown field", "unknown key"),
    ("missing field", "missing key"),
    ("duplicate field", "repeated key"),
    ("expected f64", "expected a number"),
    ("expected f32", "expected a number"),
    ("expected usize", "expected a whole number"),
    ("expected u64", "expected a whole number"),
    ("expected u32", "expected a whole number"),
    ("expected i64", "expected a whole number"),
    ("expected a map", "expected a table"),
    ("expected a sequence", "expected a list"),
    ("expected a boolean", "expected true or false"),
];

/// A parser's message about a TOML file with a file's words: a key where it says field, a number where it says `f64`.
#[must_use]
pub fn plain(message: &str) -> String {
    WORDS.iter().fold(message.to_owned(), |message, (theirs, ours)| message.replace(theirs, ours))
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn a_key_is_no_field_and_a_number_no_type() {
        assert_eq!(
            plain("unknown field `duraton_s`, expected one of `a`"),
            "unknown key `duraton_s`, expected one of `a`"
        );
        assert_eq!(
            plain("invalid type: string \"fast\", expected f64"),
            "invalid type: string \"fast\", expected a number"
        );
    }
}
