//! Recordings side by side in one file, a group for each (`data/demo_0/obs/q`, `data/demo_1/obs/q`): they are put one under another,
//! as in LeRobot's tables, with a column that says to which one a row belongs.

use crate::arrays::Array;
use std::collections::{BTreeMap, BTreeSet};

/// The column that says to which recording a row belongs, as LeRobot names it.
pub const EPISODE: &str = "episode_index";

/// What groups of recordings are called. `joint_0` and `joint_1` are none.
const RECORDINGS: [&str; 12] = [
    "demo",
    "demonstration",
    "ep",
    "episode",
    "experiment",
    "recording",
    "rep",
    "rollout",
    "run",
    "traj",
    "trajectory",
    "trial",
];

/// Where an array is: what its name is without the recording, and the recording's number.
fn place(name: &str) -> Option<(String, u32)> {
    let parts: Vec<&str> = name.split('.').collect();
    let (groups, at) = (parts.len() - 1, |i: usize| number(parts[i], i.checked_sub(1).map(|i| parts[i])));
    let (i, number) = (0..groups).find_map(|i| Some((i, at(i)?)))?;
    let rest: Vec<&str> = parts[..i].iter().chain(&parts[i + 1..]).copied().collect();
    Some((rest.join("."), number))
}

/// The number of a recording: of a group `demo_12`, or of `12` in a group `demos`.
fn number(group: &str, inside: Option<&str>) -> Option<u32> {
    let stem = group.trim_end_matches(|c: char| c.is_ascii_digit());
    let named = |name: &str| {
        let name = name.trim_end_matches(['_', '-', ' ']).to_lowercase();
        RECORDINGS.iter().any(|r| name == *r || name.strip_suffix('s') == Some(*r))
    };
    let is_one = if stem.is_empty() { inside.is_some_and(named) } else { named(stem) };
    if is_one { group[stem.len()..].parse().ok() } else { None }
}

/// Arrays with those of two recordings and more one under another: what every recording has, row by row as often as most of its arrays
/// have rows. All others stay as they are.
pub(crate) fn stacked(mut arrays: Vec<Array>) -> Vec<Array> {
    let mut recordings: BTreeMap<u32, Vec<(String, usize)>> = BTreeMap::new();
    for (i, array) in arrays.iter().enumerate() {
        if let Some((name, number)) = place(&array.name).filter(|_| !array.first_fastest) {
            recordings.entry(number).or_default().push((name, i));
        }
    }
    if recordings.len() < 2 {
        return arrays;
    }
    let rows_of = |i: usize| arrays[i].shape.first().copied().unwrap_or(1);
    let most = |of: &Vec<(String, usize)>| {
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        of.iter()
            .filter(|(_, i)| rows_of(*i) > 1)
            .for_each(|(_, i)| *counts.entry(rows_of(*i)).or_default() += 1);
        counts.into_iter().max_by_key(|(rows, count)| (*count, *rows)).map_or(0, |(rows, _)| rows)
    };
    let rows: BTreeMap<u32, usize> = recordings.iter().map(|(n, of)| (*n, most(of))).collect();
    let mut members: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (number, of) in &recordings {
        for (name, i) in of.iter().filter(|(_, i)| rows_of(*i) == rows[number] && rows[number] > 1) {
            members.entry(name).or_default().push(*i);
        }
    }
    let alike = |of: &[usize]| of.iter().all(|&i| arrays[i].shape[1..] == arrays[of[0]].shape[1..]);
    members.retain(|_, of| of.len() == recordings.len() && alike(of));
    let Some(all) = members.values().next().map(|_| rows.values().sum::<usize>()) else { return arrays };
    let index =
        rows.iter().flat_map(|(number, rows)| std::iter::repeat_n(f64::from(*number), *rows)).collect();
    let mut out = vec![Array {
        name: EPISODE.to_owned(),
        shape: vec![all],
        first_fastest: false,
        values: index,
        holds: None,
    }];
    for (name, of) in &members {
        let shape = [&[all], &arrays[of[0]].shape[1..]].concat();
        let values = of.iter().flat_map(|&i| std::mem::take(&mut arrays[i].values)).collect();
        let holds = arrays[of[0]].holds.clone();
        out.push(Array { name: (*name).to_owned(), shape, first_fastest: false, values, holds });
    }
    let taken: BTreeSet<usize> = members.into_values().flatten().collect();
    out.extend(arrays.into_iter().enumerate().filter(|(i, _)| !taken.contains(i)).map(|(_, array)| array));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(name: &str, shape: &[usize], first: f64) -> Array {
        let values = (0..shape.iter().product::<usize>()).map(|n| first + n as f64).collect();
        Array { name: name.to_owned(), shape: shape.to_vec(), first_fastest: false, values, holds: None }
    }

    #[test]
    fn recordings_of_any_length_are_put_one_under_another_in_the_order_of_their_numbers() {
        let out = stacked(vec![
            array("data.demo_10.obs.q", &[2, 2], 100.0),
            array("data.demo_10.t", &[2], 0.0),
            array("data.demo_2.obs.q", &[3, 2], 0.0),
            array("data.demo_2.t", &[3], 0.0),
            array("data.demo_2.only_here", &[3], 0.0),
            array("mask.train", &[7], 0.0),
        ]);
        let of =
            |name: &str| out.iter().find(|a| a.name == name).map(|a| (a.shape.clone(), a.values.clone()));
        assert_eq!(of(EPISODE), Some((vec![5], vec![2.0, 2.0, 2.0, 10.0, 10.0])));
        assert_eq!(of("data.t"), Some((vec![5], vec![0.0, 1.0, 2.0, 0.0, 1.0])));
        let q = vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 100.0, 101.0, 102.0, 103.0];
        assert_eq!(of("data.obs.q"), Some((vec![5, 2], q)));
        assert!(of("data.demo_2.only_here").is_some() && of("mask.train").is_some() && out.len() == 5);
    }

    #[test]
    fn joints_are_no_recordings_and_one_alone_is_none() {
        for names in [["joint_0.q", "joint_1.q"], ["demo_0.q", "demo_0.v"], ["run_1", "run_2"]] {
            let out = stacked(names.iter().map(|name| array(name, &[4], 0.0)).collect());
            assert_eq!(out.iter().map(|a| a.name.as_str()).collect::<Vec<_>>(), names);
        }
        assert_eq!(place("episodes.7.q"), Some(("episodes.q".to_owned(), 7)));
        assert_eq!(place("joints.7.q"), None);
    }
}
