//! Time stamps in two columns, whole seconds and the nanoseconds beyond them, as ROS has them.

use crate::parquet_table::STAMPS;
use crate::table::{Column, Table};

const SECONDS: [&str; 2] = ["sec", "secs"];
const NANOSECONDS: [&str; 4] = ["nsec", "nsecs", "nanosec", "nanosecs"];

/// A name's last word and what stands before it, without what separates the two.
fn parted(name: &str) -> (&str, &str) {
    let at = name.rfind(['.', '_', '/']).map_or(0, |at| at + 1);
    (name[..at].trim_end_matches(['.', '_', '/']), &name[at..])
}

/// Puts one column of nanoseconds in the place of every such pair.
pub(crate) fn made_whole(table: &mut Table) {
    let named = |i: usize, words: &[&str], of: Option<&str>| {
        let (before, word) = parted(&table.columns[i].name);
        words.contains(&word.to_lowercase().as_str()) && of.is_none_or(|of| of == before)
    };
    let all = 0..table.columns.len();
    let pair = all.clone().filter(|&i| named(i, &SECONDS, None)).find_map(|seconds| {
        let before = parted(&table.columns[seconds].name).0;
        let rest = all.clone().find(|&i| named(i, &NANOSECONDS, Some(before)))?;
        let whole = |i: usize, below: f64| {
            table.columns[i].values.iter().all(|v| v.fract() == 0.0 && (0.0..below).contains(v))
        };
        // Seconds that a stamp of 64 bits can hold.
        let plain = table.columns[seconds].origin == 0 && table.columns[rest].origin == 0;
        (plain && whole(seconds, 9e9) && whole(rest, 1e9)).then_some((seconds, rest))
    });
    let Some((seconds, rest)) = pair else { return };
    let before = parted(&table.columns[seconds].name).0;
    let name = if before.is_empty() { "stamp" } else { before }.to_owned();
    if table.columns.iter().any(|c| c.name == name) {
        return;
    }
    let mut stamp = Column::named(name);
    stamp.holds = Some(format!("{STAMPS} in nanoseconds"));
    for (s, ns) in table.columns[seconds].values.iter().zip(&table.columns[rest].values) {
        let total = *s as i64 * 1_000_000_000 + *ns as i64;
        stamp.push_whole(total as f64, Some(total));
    }
    table.columns[seconds] = stamp;
    table.columns.remove(rest);
    table.clock = table.clock.map(|clock| if clock > rest { clock - 1 } else { clock });
    made_whole(table);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_and_nanoseconds_become_one_stamp() {
        let columns = |names: [&str; 3], seconds: f64| {
            let values = [vec![seconds, seconds], vec![999_999_999.0, 1_000.0], vec![1.0, 2.0]];
            let columns =
                names.into_iter().zip(values).map(|(name, values)| Column::of(name, values)).collect();
            Table { columns, ..Table::default() }
        };
        let mut table = columns(["header.stamp.sec", "header.stamp.nanosec", "q"], 1_767_225_600.0);
        table.columns[0].values[1] += 1.0;
        made_whole(&mut table);
        let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["header.stamp", "q"]);
        assert_eq!(table.columns[0].values, [0.0, 1_001.0]);
        assert_eq!(table.columns[0].origin, 1_767_225_600_999_999_999);
        let mut other = columns(["a.sec", "b.nanosec", "q"], 1.0);
        made_whole(&mut other);
        assert_eq!(other.columns.len(), 3);
    }
}
