//! Remarks with numbers in them: `clips from {onset:.2} Hz`, `peak {high:+.1} dB`, `{1e-3 * k:.0} kN/m`.

/// The text with each `{expression:format}` replaced by the value that `value` gives for it. A format is `.N` for N decimals,
/// with `+` before it for a sign; without one, all digits are shown.
///
/// # Errors
///
/// The error of `value`; nothing if a brace is not closed or a format is not known.
pub(crate) fn filled<E>(
    text: &str,
    mut value: impl FnMut(&str) -> Result<f64, E>,
) -> Result<String, Option<E>> {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('{') {
        let (inside, behind) = after.split_once('}').ok_or(None)?;
        let (expression, format) = inside.split_once(':').unwrap_or((inside, ""));
        out.push_str(before);
        out.push_str(&shown(value(expression)?, format).ok_or(None)?);
        rest = behind;
    }
    out.push_str(rest);
    Ok(out)
}

fn shown(value: f64, format: &str) -> Option<String> {
    if format.is_empty() {
        return Some(format!("{value}"));
    }
    let (signed, digits) = format.strip_prefix('+').map_or((false, format), |rest| (true, rest));
    let digits: usize = digits.strip_prefix('.')?.parse().ok()?;
    Some(if signed { format!("{value:+.digits$}") } else { format!("{value:.digits$}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<String, Option<()>> {
        filled(text, |name| name.parse().map_err(|_| ()))
    }

    #[test]
    fn numbers_take_the_place_of_braces() {
        assert_eq!(of("no number").unwrap(), "no number");
        assert_eq!(of("{2.345:.1} Hz, {1:+.2} dB, {7.47}").unwrap(), "2.3 Hz, +1.00 dB, 7.47");
    }

    #[test]
    fn a_fault_in_braces_is_told() {
        assert_eq!(of("{x:.1}"), Err(Some(())));
        assert_eq!(of("{1:.1"), Err(None));
        assert_eq!(of("{1:5}"), Err(None));
    }
}
