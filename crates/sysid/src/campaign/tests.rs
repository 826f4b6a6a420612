//! The data contract's list of bad input, case by case, and what good input becomes.

use super::*;
use proptest::prelude::*;
use std::fmt::Write;

const HEADER: &str = "time_s,current_a,force_1_n\n";

fn rows(n: usize) -> String {
    (0..n).fold(String::new(), |mut text, i| {
        let _ = writeln!(text, "{:.3},{:.2},{:.2}", i as f64 * 0.001, (i % 7) as f64, (i % 5) as f64);
        text
    })
}

fn description(extra: &str, run: &str) -> String {
    format!("name = \"t\"\nbench = \"locked\"\nactuator = \"a\"\nsample_rate_hz = 1000.0\n{extra}\n{run}")
}

const RUN: &str = "[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n";

fn read(toml: &str, csv: Option<&[u8]>) -> Result<Campaign, Error> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("campaign.toml"), toml).unwrap();
    if let Some(csv) = csv {
        std::fs::write(folder.path().join("r.csv"), csv).unwrap();
    }
    Campaign::read(folder.path())
}

/// The message of a campaign with this table, which must be refused.
fn refused(csv: &str) -> String {
    let message = read(&description("", RUN), Some(csv.as_bytes())).unwrap_err().to_string();
    assert!(message.contains("r.csv"), "{message}");
    assert!(!message.contains('\n'), "one line: {message}");
    message
}

fn toml_refused(toml: &str) -> String {
    let message = read(toml, Some((HEADER.to_owned() + &rows(20)).as_bytes())).unwrap_err().to_string();
    assert!(message.contains("campaign.toml") && !message.contains('\n'), "{message}");
    message
}

#[test]
fn a_run_is_cut_into_windows_that_keep_their_rows_and_their_time() {
    let csv = (0..100).fold("time_s,motor_force_n,position_m\n".to_owned(), |mut text, i| {
        let _ = writeln!(text, "{:.2},{},{}", f64::from(i) * 0.01, i % 7, f64::from(i) * 1e-3);
        text
    });
    let toml = |bench: &str| {
        let keys = format!("bench = \"{bench}\"\nactuator = \"a\"\nmass_kg = 1.0\nwindow_s = 0.4\n");
        keys + "[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\nfrom_s = 0.1\n"
    };
    let campaign = read(&toml("free"), Some(csv.as_bytes())).unwrap();
    let of_run = |r: &Run| (r.record.name.clone(), r.record.time_s[0], r.record.len(), r.scored.clone());
    let runs: Vec<_> = campaign.runs.iter().map(of_run).collect();
    let name = |from: &str| format!("r.csv from {from} s");
    assert_eq!(runs, [(name("0.1"), 0.1, 40, 0..40), (name("0.5"), 0.5, 50, 0..50)]);
    assert_eq!(campaign.runs[1].record.output("position_m").unwrap()[0], 0.05);
    let message = toml_refused(&toml("locked").replace("mass_kg = 1.0\n", ""));
    assert!(message.contains("window_s") && message.contains("begin in motion"), "{message}");
    let message = toml_refused(&toml("free").replace("window_s = 0.4", "gravity_compensated = true"));
    assert!(message.contains("gravity_compensated") && message.contains("robot"), "{message}");
}

#[test]
fn a_good_campaign_is_read_whole() {
    let csv = "\u{feff}time_s, current_a ,force_1_n,housing_position_m,index\r\n".to_owned()
        + &(0..20).map(|i| format!("{},1e0,-2.5,0.1,{i}\r\n", f64::from(i) * 0.001)).collect::<String>();
    let run = "[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\nfrom_s = 0.002\nto_s = 0.018\n";
    let campaign = read(&description("input_hold = \"linear\"\n", run), Some(csv.as_bytes())).unwrap();
    let run = &campaign.runs[0];
    assert_eq!(run.record.len(), 20);
    assert_eq!(run.scored, 2..19);
    assert_eq!(run.record.hold, sealegs_model::InputHold::Linear);
    assert_eq!(run.record.input("current_a").unwrap()[3], 1.0);
    assert_eq!(run.record.output("force_1_n").unwrap()[19], -2.5);
    assert_eq!(run.unknown.len(), 2);
    assert_eq!(campaign.notes.len(), 2, "{:?}", campaign.notes);
    assert!(campaign.require(Role::Fit).is_ok());
    assert!(campaign.require(Role::Holdout).unwrap_err().to_string().contains("holdout"));
}

#[test]
fn a_leg_campaign_is_read() {
    let toml = "bench = \"leg\"\nscenario = \"thor-swing\"\n[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n";
    let csv = "time_s,knee.angle_rad,foot.normal_force_n\n".to_owned() + &rows(20);
    let campaign = read(toml, Some(csv.as_bytes())).unwrap();
    assert_eq!(campaign.bench, Bench::Leg);
    assert_eq!(campaign.scenario.as_deref(), Some("thor-swing"));
    assert_eq!(campaign.runs[0].record.outputs.len(), 2);
    assert!(
        toml_refused("bench = \"leg\"\n[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n").contains("scenario")
    );
}

#[test]
fn a_leg_run_has_its_own_scenario_and_its_inputs() {
    let toml = |inputs: &str, scenario: &str| {
        format!(
            "bench = \"leg\"\nscenario = \"thor-swing\"\n{inputs}\n[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n{scenario}"
        )
    };
    let csv = "time_s,knee.current_a,knee.force_1_n\n".to_owned() + &rows(20);
    let given = |inputs: &str| read(&toml(inputs, "scenario = \"high.toml\"\n"), Some(csv.as_bytes()));
    let run = &given("inputs = [\"knee.current_a\"]").unwrap().runs[0];
    assert_eq!(run.scenario.as_deref(), Some("high.toml"));
    assert!(run.record.input("knee.current_a").is_some() && run.record.outputs.len() == 1);
    let measured = &given("").unwrap().runs[0].record;
    assert!(measured.inputs.is_empty() && measured.output("knee.current_a").is_some());
    assert!(given("inputs = [\"hip.current_a\"]").unwrap_err().to_string().contains("hip.current_a"));
    let bench = "bench = \"locked\"\nactuator = \"thor-linear\"\n";
    let run = "[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n";
    assert!(toml_refused(&format!("{bench}inputs = []\n{run}")).contains("inputs"));
    assert!(toml_refused(&format!("{bench}{run}scenario = \"a.toml\"\n")).contains("scenario"));
}

#[test]
fn missing_and_empty_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(Campaign::read(folder.path()).unwrap_err().to_string().contains("campaign.toml"));
    let message = read(&description("", RUN), None).unwrap_err().to_string();
    assert!(message.contains("line 7") && message.contains("r.csv"), "{message}");
    assert!(refused("").contains("empty"));
    assert!(refused("\n \n").contains("empty"));
    assert!(toml_refused("").contains("empty"));
}

#[test]
fn a_table_without_header_is_refused() {
    assert!(refused(&rows(20)).contains("no header"));
}

#[test]
fn unknown_words_are_refused_with_a_suggestion() {
    let bench =
        toml_refused("bench = \"loked\"\nactuator = \"a\"\n[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n");
    assert!(bench.contains("line 1") && bench.contains("did you mean 'locked'"), "{bench}");
    let role = toml_refused(&description("", "[[run]]\nfile = \"r.csv\"\nrole = \"hold-out\"\n"));
    assert!(role.contains("line 8") && role.contains("did you mean 'holdout'"), "{role}");
    let hold = toml_refused(&description("input_hold = \"foh\"", RUN));
    assert!(hold.contains("input_hold"), "{hold}");
    assert!(
        toml_refused("bench = \"locked\"\n[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n").contains("actuator")
    );
    assert!(toml_refused(&description("", "")).contains("no [[run]]"));
    assert!(toml_refused("bench = locked").contains("line 1"));
    let misspelt = toml_refused("bnch = \"locked\"\nactuator = \"a\"\n");
    assert!(misspelt.contains("missing") && misspelt.contains("did you mean 'bench'"), "{misspelt}");
    assert!(toml_refused(&description("", "[[run]]\nfile = \"r.csv\"\n")).contains("role"));
}

#[test]
fn a_column_that_a_misspelt_map_would_have_named_is_missing_with_that_key() {
    let csv = "stamp,current_a,force_1_n\n".to_owned() + &rows(20);
    let campaign = description("", RUN) + "[colums]\nstamp = { as = \"time_s\", unit = \"ms\" }\n";
    let message = read(&campaign, Some(csv.as_bytes())).unwrap_err().to_string();
    for said in
        ["r.csv", "(found 'stamp')", "[columns]", "in campaign.toml key 'colums'", "did you mean 'columns'"]
    {
        assert!(message.contains(said), "{said}: {message}");
    }
    assert!(
        !read(&description("", RUN), Some(csv.as_bytes())).unwrap_err().to_string().contains("campaign.toml")
    );
}

#[test]
fn an_unknown_key_is_a_note() {
    let csv = HEADER.to_owned() + &rows(20);
    let campaign = read(&description("input_hld = \"linear\"", RUN), Some(csv.as_bytes())).unwrap();
    let note = campaign.notes.iter().find(|n| n.contains("did you mean 'input_hold'"));
    let line = 1 + description("input_hld = \"linear\"", RUN)
        .lines()
        .position(|l| l.starts_with("input_hld"))
        .unwrap();
    assert!(note.is_some_and(|n| n.contains(&format!("line {line}:"))), "{:?}", campaign.notes);
}

#[test]
fn numbers_of_the_campaign_file_are_checked() {
    let zero = description("[noise_std]\nforce_1_n = 0.0", RUN);
    assert!(toml_refused(&zero).contains("noise_std.force_1_n"));
    assert!(toml_refused(&description("", RUN).replace("1000.0", "-5")).contains("sample_rate_hz"));
    let run = "[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\nfrom_s = 100.0\n";
    assert!(toml_refused(&description("", run)).contains("fewer than 16 rows"));
    let twice = format!("{RUN}{}", RUN.replace("fit", "holdout"));
    assert!(toml_refused(&description("", &twice)).contains("two roles"));
}

#[test]
fn a_cell_that_is_no_finite_number_is_named() {
    for (cell, word) in [("x", "no number"), ("NaN", "not finite"), ("-inf", "not finite"), ("", "empty")] {
        let table = (HEADER.to_owned() + &rows(20)).replace("0.010,3.00,", &format!("0.010,{cell},"));
        let message = refused(&table);
        assert!(message.contains("line 12") && message.contains("'current_a'"), "{message}");
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn too_few_rows_are_refused() {
    assert!(refused(&(HEADER.to_owned() + &rows(15))).contains("15 rows"));
    assert!(read(&description("", RUN), Some((HEADER.to_owned() + &rows(16)).as_bytes())).is_ok());
}

#[test]
fn time_that_repeats_or_goes_back_is_refused() {
    let table = HEADER.to_owned() + &rows(20);
    let repeats = refused(&table.replace("\n0.010,", "\n0.009,"));
    assert!(
        repeats.contains("line 12") && repeats.contains("time_s") && repeats.contains("repeats"),
        "{repeats}"
    );
    assert!(refused(&table.replace("\n0.010,", "\n0.0,")).contains("goes back"));
}

#[test]
fn columns_of_different_length_are_refused() {
    let table = HEADER.to_owned() + &rows(20);
    let short = refused(&table.replace("0.010,3.00,0.00", "0.010,3.00"));
    assert!(short.contains("line 12") && short.contains("'force_1_n'"), "{short}");
    assert!(refused(&table.replace("0.010,3.00,0.00", "0.010,3.00,0.0,1.0")).contains("4 cells"));
}

#[test]
fn inputs_must_be_exactly_one() {
    let table = HEADER.to_owned() + &rows(20);
    assert!(refused(&table.replace("current_a", "voltage_m")).contains("no input column"));
    let two = refused(&table.replace("force_1_n", "motor_force_n"));
    assert!(two.contains("two input columns") && two.contains("line 1"), "{two}");
}

#[test]
fn a_command_that_did_not_change_is_stated_and_not_logged() {
    let table = "time_s,joint_angle_rad,speed_rad_s\n".to_owned() + &rows(20);
    let said = refused(&table);
    // Both columns have a sensor's name: neither is a misspelt command.
    assert!(!said.contains("did you mean"), "{said}");
    assert!(said.contains("constant = 12.0"), "{said}");
    let columns = "[columns]\n\"not logged\" = { as = \"voltage_v\", constant = 12.0 }\n";
    let run = format!("{RUN}{RUN}[run.columns]\nsupply = {{ as = \"voltage_v\", constant = -6.0 }}\n");
    let campaign = read(&description(columns, &run), Some(table.as_bytes())).unwrap();
    let input = |run: usize| campaign.runs[run].record.input("voltage_v").unwrap().to_vec();
    assert_eq!((input(0), input(1)), (vec![12.0; 20], vec![-6.0; 20]));
    assert_eq!(campaign.runs[0].record.output("speed_rad_s").unwrap().len(), 20);
    let both = table.replace("speed_rad_s", "voltage_v");
    let twice = read(&description(columns, RUN), Some(both.as_bytes())).unwrap_err().to_string();
    assert!(twice.contains("'voltage_v' is in the file"), "{twice}");
}

#[test]
fn headers_are_checked() {
    let table = HEADER.to_owned() + &rows(20);
    let unit = refused(&table.replace("force_1_n", "force_1_lbf"));
    assert!(unit.contains("line 1") && unit.contains("'force_1_lbf'"), "{unit}");
    assert!(refused(&table.replace("time_s", "time_ms")).contains("known unit"));
    assert!(refused(&table.replace("time_s", "clock_s")).contains("'time_s'"));
    assert!(refused(&table.replace("force_1_n", "current_a")).contains("twice"));
    assert!(refused(&table.replace("force_1_n", "")).contains("no name"));
    // Separated by semicolons it is the same table.
    assert!(read(&description("", RUN), Some(table.replace(',', ";").as_bytes())).is_ok());
}

#[test]
fn a_run_that_the_model_cannot_predict_is_refused() {
    let table = HEADER.to_owned() + &rows(20);
    let toy = crate::toy::Toy::new();
    let campaign = read(&description("", RUN), Some(table.as_bytes())).unwrap();
    let message = campaign.check_against(&toy).unwrap_err().to_string();
    assert!(message.contains("no input column that toy takes"), "{message}");
    let force = table.replace("current_a", "motor_force_n");
    let campaign = read(&description("", RUN), Some(force.as_bytes())).unwrap();
    assert!(campaign.check_against(&toy).unwrap().is_empty());
    let other = force.replace("force_1_n", "force_2_n");
    let campaign = read(&description("", RUN), Some(other.as_bytes())).unwrap();
    let message = campaign.check_against(&toy).unwrap_err().to_string();
    assert!(message.contains("line 1") && message.contains("force_2_n"), "{message}");
}

#[test]
fn a_million_rows_take_about_a_second() {
    let mut csv = String::from("time_s,current_a,force_1_n,force_2_n\n");
    for i in 0..1_000_000 {
        let _ = writeln!(csv, "{:.4},{:.5},{:.2},{:.2}", f64::from(i) * 1e-3, 0.123, f64::from(i % 100), 5.5);
    }
    let started = std::time::Instant::now();
    let table = parse("big.csv", csv.into_bytes(), said(Bench::Locked)).unwrap();
    assert_eq!(table.time_s.len(), 1_000_000);
    // A generous bound, as other tests share the machine; it takes about 0.3 s alone.
    assert!(started.elapsed().as_secs_f64() < 3.0, "{:?}", started.elapsed());
}

fn said(bench: Bench) -> table::Said<'static> {
    table::Said {
        bench,
        leg_inputs: &[],
        sample_rate_hz: Some(1000.0),
        hold: sealegs_model::InputHold::ZeroOrder,
    }
}

/// A table that has the contract's own names.
fn parse(name: &str, bytes: Vec<u8>, said: table::Said) -> Result<table::Table, Error> {
    let path = Path::new(name);
    table::plain(path, sealegs_logs::parse(path, bytes)?, said)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_table_makes_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = parse("x.csv", bytes, said(Bench::Locked));
    }

    #[test]
    fn no_almost_right_table_makes_the_reader_panic(
        cells in prop::collection::vec("[0-9.,e\\-\n\"NaNif; ]{0,12}", 0..60)
    ) {
        let text = HEADER.to_owned() + &cells.concat();
        if let Err(e) = parse("x.csv", text.into_bytes(), said(Bench::Pendulum)) {
            prop_assert!(!e.to_string().is_empty());
        }
    }

    #[test]
    fn no_campaign_file_makes_the_reader_panic(lines in prop::collection::vec(
        "(name|bench|actuator|role|file|from_s|input_hold|\\[\\[run\\]\\]|\\[noise_std\\]|force_1_n)( = )?(\"[a-z-]{0,8}\"|-?[0-9.]{1,4}|nan)?",
        0..12,
    )) {
        let _ = file::parse(Path::new("campaign.toml"), &lines.join("\n"));
    }
}

/// Everything that somebody else's file may ask for, in one campaign.
const MAPPED: &str = "name = \"t\"\nbench = \"locked\"\nactuator = \"a\"\nsample_rate_hz = 100.0\n[columns]\n\
    \"stamp\" = { as = \"time_s\", unit = \"ms\" }\n\"i\" = { as = \"current_a\", unit = \"mA\", sign = -1 }\n\
    \"f\" = \"force_1_n\"\n\"temp\" = { as = \"temperature_c\", optional = true }\n";

fn other_rows(n: u32) -> String {
    let row = |i: u32| format!("{},{},{},label\n", 5000 + 10 * i, 100 * (i % 7), i % 5);
    "stamp,i,f,what\n".to_owned() + &(0..n).map(row).collect::<String>()
}

#[test]
fn columns_are_mapped_and_runs_have_units() {
    let run = "[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\nunit = \"left\"\n";
    let campaign = read(&format!("{MAPPED}{run}"), Some(other_rows(20).as_bytes())).unwrap();
    let run = &campaign.runs[0];
    assert_eq!(run.unit.as_deref(), Some("left"));
    assert_eq!(run.record.time_s[0], 0.0);
    assert!((run.record.time_s[2] - 0.02).abs() < 1e-12);
    assert!((run.record.input("current_a").unwrap()[3] + 0.3).abs() < 1e-12);
    assert!(campaign.notes.iter().any(|n| n.contains("'what' is left out")), "{:?}", campaign.notes);
}

#[test]
fn a_run_may_map_otherwise_and_have_several_files() {
    let folder = tempfile::tempdir().unwrap();
    let run = "[[run]]\nfiles = [\"r.csv\", { file = \"s.csv\", offset_s = 5.0 }]\nrole = \"fit\"\n[run.columns]\n\
        \"u\" = \"current_a\"\n\"clock\" = \"time_s\"\n\"stamp\" = { as = \"time_s\", unit = \"ms\" }\n";
    std::fs::write(folder.path().join("campaign.toml"), format!("{MAPPED}{run}")).unwrap();
    std::fs::write(folder.path().join("r.csv"), other_rows(30)).unwrap();
    let second: String = (0..10).map(|i| format!("{:.2},{}\n", 0.04 * f64::from(i), i)).collect();
    std::fs::write(folder.path().join("s.csv"), format!("clock,u\n{second}")).unwrap();
    let campaign = Campaign::read(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    let run = &campaign.runs[0];
    assert_eq!(run.record.name, "r.csv+s.csv");
    // A command is held: row 5 is at 0.05 s, and the command of 0.04 s holds.
    assert_eq!(run.record.input("current_a").unwrap()[5], 1.0);
    assert!(
        campaign.notes.iter().any(|n| n.contains("brought to the clock of r.csv")),
        "{:?}",
        campaign.notes
    );
}

#[test]
fn what_is_wrong_with_maps_is_named_by_line_and_column() {
    let run = "[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n";
    let told = |toml: &str, csv: &str| read(toml, Some(csv.as_bytes())).unwrap_err().to_string();
    let good = format!("{MAPPED}{run}");
    let csv = other_rows(20);
    let message = told(&good.replace("\"f\" =", "\"g\" ="), &csv);
    assert!(
        message.contains("campaign.toml, line 8") && message.contains("no column 'g' in r.csv"),
        "{message}"
    );
    let message = told(&good.replace("\"mA\"", "\"deg\""), &csv);
    assert!(message.contains("line 7") && message.contains("'columns.i'"), "{message}");
    assert!(told(&good.replace("sign = -1", "sing = -1"), &csv).contains("sing"));
    let message = told(&good, &csv.replace("5030,", "5020,"));
    assert!(message.contains("r.csv, line 5") && message.contains("'stamp'"), "{message}");
    let message = told(&good, &csv.replace("5030,300,", "5030,,"));
    assert!(
        message.contains("r.csv, line 5") && message.contains("'i'") && message.contains("empty"),
        "{message}"
    );
    assert!(told(&good.replace("file =", "files = []\nfile ="), &csv).contains("'files'"));
    assert!(told(&good.replace("role =", "episode = 3\nrole ="), &csv).contains("episode_index"));
}

#[test]
fn episodes_of_one_file_are_runs_of_their_own() {
    let toml = |second: u32| {
        format!(
            "{MAPPED}[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\nepisode = 0\n\
             [[run]]\nfile = \"r.csv\"\nrole = \"holdout\"\nepisode = {second}\n"
        )
    };
    let rows: String =
        (0..40).map(|i| format!("{},{},{},{}\n", i / 20, 10 * (i % 20), 100 * (i % 7), i)).collect();
    let csv = format!("episode_index,stamp,i,f\n{rows}");
    let campaign = read(&toml(1), Some(csv.as_bytes())).unwrap();
    assert_eq!(campaign.runs[1].record.name, "r.csv#1");
    assert_eq!(campaign.runs[1].record.output("force_1_n").unwrap()[0], 20.0);
    assert_eq!(campaign.runs[1].record.time_s[0], 0.0);
    assert!(read(&toml(0), Some(csv.as_bytes())).unwrap_err().to_string().contains("two roles"));
}
