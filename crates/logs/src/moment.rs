//! Dates and times of day in text, as whole nanoseconds.

use jiff::Timestamp;
use jiff::civil::{DateTime, Time};
use jiff::tz::TimeZone;

/// What a column of dates holds; a date without a time zone is taken for one of UTC.
pub(crate) const DATES: &str = "dates, in nanoseconds since 1970";
/// What a column of times of day holds.
pub(crate) const TIMES: &str = "times of day, in nanoseconds since midnight";

/// Nanoseconds of a date with its time (`2026-05-01 09:30:00.125`, with `T` or slashes, with or without a time zone) or of a time
/// of day (`09:30:00.125`), and what a column of such holds; `None` if the text is neither.
pub(crate) fn nanoseconds(text: &str) -> Option<(i64, &'static str)> {
    if !text.contains(':') || !text.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let text = text.replace('/', "-");
    let zoned = || text.parse::<Timestamp>().ok();
    let plain = || Some(text.parse::<DateTime>().ok()?.to_zoned(TimeZone::UTC).ok()?.timestamp());
    if let Some(stamp) = zoned().or_else(plain) {
        return Some((stamp.as_nanosecond().try_into().ok()?, DATES));
    }
    let time = text.parse::<Time>().ok()?.duration_since(Time::midnight());
    Some((time.as_nanos().try_into().ok()?, TIMES))
}

#[cfg(test)]
mod tests {
    use super::{DATES, TIMES, nanoseconds};

    #[test]
    fn dates_and_times_are_read_in_the_shapes_that_people_write() {
        // 20 574 days after 1970-01-01.
        let day = 20_574 * 86_400 * 1_000_000_000;
        let at = day + 34_200_125_000_000;
        for text in ["2026-05-01 09:30:00.125", "2026-05-01T09:30:00.125Z", "2026/05/01 09:30:00,125"] {
            assert_eq!(nanoseconds(text), Some((at, DATES)), "{text}");
        }
        assert_eq!(nanoseconds("2026-05-01 11:30:00.125000+02:00"), Some((at, DATES)));
        assert_eq!(nanoseconds("09:30:00.125"), Some((at - day, TIMES)));
        for text in ["2026-05-01", "1.5", "x:y", "12:61:00", "9:3", ""] {
            assert_eq!(nanoseconds(text), None, "{text}");
        }
    }
}
