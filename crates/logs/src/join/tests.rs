//! Clocks, maps and joins, case by case.

use super::*;
use crate::columns::Described;
use crate::parse;
use std::path::Path;

fn file(label: &str, text: &str) -> File {
    let path = Path::new(label).to_owned();
    let log = parse(&path, text.as_bytes().to_vec()).unwrap();
    File { path, label: label.to_owned(), offset_s: 0.0, log }
}

fn map(source: &str, target: &str) -> ColumnMap {
    ColumnMap { source: source.to_owned(), ..ColumnMap::plain(target) }
}

fn request(columns: &[ColumnMap]) -> Request<'_> {
    Request {
        columns,
        sample_rate_hz: None,
        episode: None,
        known: &|name| name == "current_a",
        held: &|name| name == "current_a",
    }
}

fn message(error: JoinError) -> String {
    match error {
        JoinError::Map(index, problem) => format!("map {index}: {problem}"),
        JoinError::Run(problem) => problem,
        JoinError::File(error) => error.to_string(),
    }
}

fn refused(files: Vec<File>, columns: &[ColumnMap]) -> String {
    message(join(files, &request(columns)).unwrap_err())
}

#[test]
fn integer_stamps_start_at_zero_and_keep_their_steps() {
    let a = file("a.csv", "stamp,f,current_a,x\n1700000000000000000,1,5,7\n1700000000001000000,2,6,8\n");
    let stamp = ColumnMap { scale: 1e-9, ..map("stamp", "time_s") };
    let run = join(vec![a], &request(&[stamp, map("f", "force_1_n")])).unwrap();
    assert_eq!(run.time_s[0], 0.0);
    assert!((run.time_s[1] - 1e-3).abs() < 1e-15, "{:?}", run.time_s);
    assert_eq!(run.channels, [("force_1_n".into(), vec![1.0, 2.0]), ("current_a".into(), vec![5.0, 6.0])]);
    assert_eq!(run.others, [("x".into(), vec![7.0, 8.0])]);
}

#[test]
fn the_contracts_own_time_is_left_as_it_is() {
    let a = file("a.csv", "time_s,f\n0.1,1\n0.3,2\n0.7,3\n");
    let run = join(vec![a], &request(&[map("f", "force_1_n")])).unwrap();
    assert_eq!(run.time_s, [0.1, 0.3, 0.7]);
}

#[test]
fn a_second_file_is_interpolated_and_a_command_is_held() {
    let a = file("a.csv", "t,f\n10,0\n11,1\n12,2\n13,3\n14,4\n");
    let mut b = file("b.csv", "t,g,current_a\n100.5,0,1\n102.5,20,2\n103.0,25,3\n");
    b.offset_s = -90.0;
    let columns = [map("t", "time_s"), map("f", "force_1_n"), map("g", "force_2_n")];
    let run = join(vec![a, b], &request(&columns)).unwrap();
    // b covers 10.5 to 13.0 s of a's clock.
    assert_eq!(run.time_s, [0.0, 1.0, 2.0]);
    assert_eq!(run.channels[0].1, [1.0, 2.0, 3.0]);
    assert_eq!(run.channels[1].1, [5.0, 15.0, 25.0]);
    assert_eq!(run.channels[2].1, [1.0, 1.0, 3.0]);
    assert!(run.notes.iter().any(|n| n.contains("2 of 5 rows")), "{:?}", run.notes);
    assert_eq!(run.places.of(0), crate::Place::Line(3));
}

#[test]
fn clocks_that_do_not_meet_are_refused() {
    let a = file("a.csv", "t,f\n0,0\n1,1\n2,2\n");
    let b = file("b.csv", "t,g\n100,0\n101,1\n");
    let columns = [map("t", "time_s"), map("f", "force_1_n"), map("g", "force_2_n")];
    let said = refused(vec![a, b], &columns);
    assert!(said.starts_with("b.csv") && said.contains("offset_s"), "{said}");
}

#[test]
fn sources_must_name_one_column() {
    let both = || vec![file("a.csv", "t,force\n0,0\n1,1\n"), file("b.csv", "t,force\n0,0\n1,1\n")];
    let time = map("t", "time_s");
    let said = refused(both(), &[time.clone(), map("force", "force_1_n")]);
    assert!(said.contains("map 1") && said.contains("a.csv:force, b.csv:force"), "{said}");
    let said = refused(both(), &[time.clone(), map("forze", "force_1_n")]);
    assert!(said.contains("did you mean 'force'"), "{said}");
    let run = join(both(), &request(&[time, map("b.csv:force", "force_1_n")])).unwrap();
    assert_eq!(run.channels.len(), 1);
}

#[test]
fn of_known_columns_of_one_name_a_map_chooses() {
    let both = || vec![file("a.csv", "t,current_a\n0,1\n1,2\n"), file("b.csv", "t,current_a\n0,3\n1,4\n")];
    let time = map("t", "time_s");
    let said = refused(both(), std::slice::from_ref(&time));
    assert!(said.contains("stands in b.csv") && said.contains("in a.csv"), "{said}");
    let run = join(both(), &request(&[time, map("b.csv:current_a", "current_a")])).unwrap();
    assert_eq!(run.channels, [("current_a".into(), vec![3.0, 4.0])]);
}

#[test]
fn time_is_made_of_the_rate_only_where_one_is_stated() {
    let a = || vec![file("a.csv", "f,my_time\n1,0\n2,1\n")];
    let columns = [map("f", "force_1_n")];
    let said = refused(a(), &columns);
    assert!(said.contains("time_s") && said.contains("my_time"), "{said}");
    let run = join(a(), &Request { sample_rate_hz: Some(100.0), ..request(&columns) }).unwrap();
    assert_eq!(run.time_s, [0.0, 0.01]);
    assert!(run.notes[0].contains("100 Hz"), "{:?}", run.notes);
}

#[test]
fn faults_are_named_by_file_line_and_column() {
    let text = "t,f,g\n0,0,x\n1,1,2\n\n2,,3\n";
    let time = map("t", "time_s");
    let said = refused(vec![file("a.csv", text)], &[time.clone(), map("f", "force_1_n")]);
    assert_eq!(said, "a.csv, line 5, column 'f': the cell is empty");
    // A column that nobody asks for is left out.
    let run = join(
        vec![file("a.csv", &text.replace(",,", ",2,"))],
        &request(&[time.clone(), map("f", "force_1_n")]),
    );
    assert!(run.unwrap().notes[0].contains("'g' is left out: 'x' is no number in line 2"));
    let back = text.replace("1,1,2", "0,1,2").replace(",,", ",2,");
    let said = refused(vec![file("a.csv", &back)], &[time, map("f", "force_1_n")]);
    assert_eq!(
        said,
        "a.csv, line 3, column 't': time repeats: 0 after 0; delete such rows, or leave the column out and state sample_rate_hz"
    );
}

#[test]
fn an_episode_is_cut_out() {
    let text = "episode_index,t,f\n0,0,1\n0,1,2\n1,0,3\n1,1,4\n1,2,x\n";
    let columns = [map("t", "time_s"), map("f", "force_1_n")];
    let ask =
        |episode| join(vec![file("a.csv", text)], &Request { episode: Some(episode), ..request(&columns) });
    assert_eq!(ask(0).unwrap().channels[0].1, [1.0, 2.0]);
    assert_eq!(message(ask(1).unwrap_err()), "a.csv, line 6, column 'f': 'x' is no number");
    assert!(message(ask(7).unwrap_err()).contains("no episode 7; it has 0 to 1"));
}

#[test]
fn entries_and_described_maps_work_together() {
    let text =
        r#"{"kp": 3, "entries": [{"t": 5.0, "q": 350, "on": true}, {"t": 5.5, "q": 10, "on": false}]}"#;
    let said: Described =
        serde_json::from_str(r#"{"as": "joint_angle_rad", "unit": "deg", "wrap": true, "sign": -1}"#)
            .unwrap();
    let columns =
        [map("entries.t", "time_s"), ColumnMap::new("entries.q", &said).unwrap(), map("on", "enable")];
    let run = join(vec![file("a.json", text)], &request(&columns)).unwrap();
    assert_eq!(run.time_s, [0.0, 0.5]);
    assert!((run.channels[0].1[1] + 370f64.to_radians()).abs() < 1e-12);
    assert_eq!(run.channels[1].1, [1.0, 0.0]);
}
