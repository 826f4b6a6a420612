//! Whether a column is time, and in which unit.

use super::name::{last_part, without_unit, words};
use crate::table::stated_unit;

const TIME: [&str; 22] = [
    "t",
    // LCM's, in microseconds.
    "utime",
    "time",
    "times",
    "timestamp",
    "timestamps",
    "stamp",
    "ts",
    "sec",
    "secs",
    "seconds",
    "clock",
    "elapsed",
    "millis",
    "micros",
    "nanos",
    "tick",
    "zeit",
    "uptime",
    "epoch",
    "unix",
    "utc",
];

/// Whether a column's name says that it is time.
#[must_use]
pub fn is_time(name: &str) -> bool {
    let (plain, unit) = without_unit(name);
    if unit.is_some() {
        // `T [°C]` is a temperature.
        return false;
    }
    let words = words(last_part(plain));
    if is_temperature(last_part(plain), &words) {
        return false;
    }
    // LabVIEW's only one that goes on.
    words.iter().any(|w| TIME.contains(&w.as_str())) || name == "X_Value"
}

/// Whether a name is a temperature's by its capital letter, `T_winding`, and no time's: `T_ms`.
pub(super) fn is_temperature(name: &str, words: &[String]) -> bool {
    let own =
        |word: &String| !["s", "ms", "us", "ns"].contains(&word.as_str()) && word.parse::<f64>().is_err();
    name.starts_with("T_") && words.first().is_some_and(|w| w == "t") && words[1..].iter().any(own)
}

/// The unit of time stamps, and why.
///
/// Seconds since 1970 are some 1.7e9 today, so that the size of an absolute stamp tells its unit. Of a clock that starts
/// somewhere else, a period above 5 cannot be seconds of a log.
pub(crate) fn time_unit(
    name: &str,
    holds: Option<&str>,
    first: f64,
    period: f64,
) -> (&'static str, &'static str) {
    let words = words(name);
    let has = |list: &[&str]| words.iter().any(|w| list.contains(&w.as_str()));
    // The format's own type says it in words, a row of units below the header by its symbol.
    let held =
        |unit: &str, symbol: &str| holds.is_some_and(|h| h.contains(unit) || stated_unit(h) == Some(symbol));
    if has(&["ns", "nsec", "nanoseconds", "nanos"]) || held("nanoseconds", "ns") {
        return ("ns", "its unit by its name or type");
    }
    if has(&["us", "usec", "utime", "microseconds", "micros"]) || held("microseconds", "us") {
        return ("us", "its unit by its name or type");
    }
    if has(&["ms", "msec", "milliseconds", "millis"]) || held("milliseconds", "ms") {
        return ("ms", "its unit by its name or type");
    }
    match first.abs() {
        a if a > 1e17 => ("ns", "its unit by its size, counted from 1970"),
        a if a > 1e14 => ("us", "its unit by its size, counted from 1970"),
        a if a > 1e11 => ("ms", "its unit by its size, counted from 1970"),
        _ if period >= 5e4 => ("ns", "its unit by its steps"),
        _ if period >= 50.0 => ("us", "its unit by its steps"),
        _ if period >= 1.0 => ("ms", "its unit by its steps"),
        _ => ("s", "in seconds by its steps"),
    }
}

#[cfg(test)]
mod tests {
    use super::time_unit;

    #[test]
    fn the_unit_of_time_is_told_by_name_size_or_steps() {
        assert_eq!(time_unit("t_ms", None, 0.0, 1.0).0, "ms");
        assert_eq!(time_unit("t", Some("in [ms]"), 0.0, 0.5).0, "ms");
        assert_eq!(time_unit("stamp", None, 1.7e18, 1e6).0, "ns");
        assert_eq!(time_unit("stamp", None, 1.7e9, 0.01).0, "s");
        assert_eq!(time_unit("t", None, 0.0, 1e4).0, "us");
        assert_eq!(time_unit("t", Some("time stamps (Timestamp) in microseconds"), 0.0, 0.1).0, "us");
    }
}
