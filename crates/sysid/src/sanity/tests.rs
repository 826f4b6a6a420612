//! Every fault of a log, put into the log of a closed-form system, and logs without one.

use super::*;
use crate::campaign::{LeftOut, Role};
use crate::toy::{Toy, campaign, run};

const NOISE: (f64, f64) = (0.2, 0.001);

/// Two fit runs and a holdout run of the nominal system, with a gain and a bias.
fn good() -> Campaign {
    of([1.0, 4.0, 400.0])
}

/// The same of a system with these parameters.
fn of(truth: [f64; 3]) -> Campaign {
    let made = |seed| run(&truth, 2000, seed, NOISE, (1.01, 0.5), 1.0);
    campaign(vec![(Role::Fit, made(3)), (Role::Fit, made(4)), (Role::Holdout, made(5))], NOISE)
}

/// The same with every value of an output column changed.
fn with(channel: &str, change: impl Fn(f64) -> f64) -> Campaign {
    let mut campaign = good();
    for run in &mut campaign.runs {
        for signal in run.record.outputs.iter_mut().chain(&mut run.record.inputs) {
            if signal.channel == channel {
                signal.values.iter_mut().for_each(|v| *v = change(*v));
            }
        }
    }
    campaign
}

/// The only finding.
fn only(campaign: &Campaign) -> Finding {
    let found = look(campaign, &Toy::new());
    let [finding] = &found[..] else { panic!("{found:#?}") };
    finding.clone()
}

#[test]
fn nothing_is_said_of_a_good_log() {
    assert_eq!(look(&good(), &Toy::new()), []);
    // Parameters that are ten per cent off move the resonance by a fifth of its width.
    assert_eq!(look(&of([1.05, 4.4, 380.0]), &Toy::new()), []);
}

#[test]
fn a_flipped_sign_is_said_with_its_slope_and_stops() {
    let found = only(&with("force_1_n", |v| -v));
    assert_eq!((found.problem, found.channel.as_str()), (Problem::FlippedSign, "force_1_n"));
    assert!(found.stops());
    assert!(found.evidence.starts_with("`force_1_n` runs against the model with slope -1.01"), "{found:?}");
    assert!(found.evidence.contains("in all 3 runs"), "{found:?}");
    let found = only(&with("motor_force_n", |v| -v));
    assert_eq!((found.problem, found.channel.as_str()), (Problem::FlippedSign, "motor_force_n"));
}

#[test]
fn what_one_piece_of_a_log_shows_and_the_others_do_not_is_no_wiring() {
    let mut campaign = good();
    let negate = |run: &mut crate::campaign::Run| {
        let force = run.record.outputs.iter_mut().find(|s| s.channel == "force_1_n").unwrap();
        force.values.iter_mut().for_each(|v| *v = -*v);
    };
    negate(&mut campaign.runs[1]);
    campaign.runs.iter_mut().for_each(|run| run.path = "log.csv".into());
    assert_eq!(look(&campaign, &Toy::new()), []);
    campaign.runs[1].path = "another.csv".into();
    let found = only(&campaign);
    assert!(found.problem == Problem::FlippedSign && found.evidence.contains("toy-4"), "{found:?}");
    // In most of its pieces.
    campaign.runs[1].path = campaign.runs[0].path.clone();
    negate(&mut campaign.runs[2]);
    assert_eq!(only(&campaign).problem, Problem::FlippedSign);
}

#[test]
fn analytic_a_column_that_hardly_moves_says_nothing_of_its_sign() {
    use against::{Seen, of_line};
    use pair::Pair;
    let predicted: Vec<f64> = (0..2000).map(|i| (0.02 * f64::from(i)).sin()).collect();
    // Correlation -0.89 by an unrelated tone of half its size, whatever the slope.
    let told = |slope: f64| {
        let other = |i: usize| 0.5 * (0.31 * i as f64).sin();
        let measured: Vec<f64> = predicted.iter().enumerate().map(|(i, p)| slope * (p + other(i))).collect();
        let rows = 0..2000;
        let pair = Pair {
            run: 0,
            channel: "elbow.angle_rad",
            noise: 1e-4,
            measured: &measured,
            predicted: &predicted,
            rows: Vec::from([rows]),
        };
        of_line(&Seen { line: pair.line(0, 1), pair, judged: false }).map(|(problem, _)| problem)
    };
    assert_eq!(told(-1.0), Some(Problem::FlippedSign));
    assert_eq!(told(-0.4), Some(Problem::FlippedSign));
    for slope in [-0.003, -0.01, -0.3, -3.5, -40.0, 1.0] {
        assert_eq!(told(slope), None, "{slope}");
    }
}

#[test]
fn a_run_that_alone_is_flipped_is_named() {
    let mut campaign = good();
    campaign.runs[1].record.outputs[0].values.iter_mut().for_each(|v| *v = -*v);
    let found = only(&campaign);
    assert!(found.stops() && found.evidence.contains("in toy-4 only"), "{found:?}");
}

#[test]
fn units_are_found_both_ways_with_the_factor_in_the_cure() {
    let found = only(&with("spring_deflection_m", |v| 1000.0 * v));
    assert_eq!(found.problem, Problem::UnitFactor);
    assert!(found.stops() && found.evidence.contains("millimetres?"), "{found:?}");
    assert!(found.cure.contains("by 1000;"), "{found:?}");
    let found = only(&with("force_1_n", |v| -v / 9.806_65));
    assert!(
        found.evidence.contains("kilograms-force?") && found.evidence.contains("against it"),
        "{found:?}"
    );
    assert!(found.cure.contains("by -0.102;"), "{found:?}");
    let found = only(&with("force_1_n", |v| (v * 217.0).round()));
    assert!(found.evidence.contains("counts?") && found.stops(), "{found:?}");
    let found = only(&with("motor_force_n", |v| 1000.0 * v));
    assert_eq!((found.problem, found.channel.as_str()), (Problem::UnitFactor, "motor_force_n"));
    let found = only(&with("force_1_n", |v| 20.0 * v));
    assert_eq!((found.problem, found.severity), (Problem::OddScale, Severity::Remark));
}

#[test]
fn a_small_delay_is_a_remark_and_rows_that_went_astray_stop() {
    let late = |channel: &str, by: usize| {
        let mut campaign = good();
        for run in &mut campaign.runs {
            let all = run.record.outputs.iter_mut().chain(&mut run.record.inputs);
            for signal in all.filter(|s| s.channel == channel) {
                let first = signal.values[0];
                signal.values.rotate_right(by);
                signal.values[..by].fill(first);
            }
        }
        campaign
    };
    let found = only(&late("force_1_n", 4));
    assert_eq!((found.problem, found.severity), (Problem::Offset, Severity::Remark));
    assert!(found.evidence.contains("`force_1_n` lies 4 samples (20.0 ms) after"), "{found:?}");
    let found = only(&late("force_1_n", 60));
    assert!(found.stops() && found.evidence.contains("60 samples"), "{found:?}");
    let found = only(&late("motor_force_n", 60));
    assert!(found.stops() && found.evidence.contains("60 samples (300 ms) before"), "{found:?}");
    assert_eq!(found.channel, "motor_force_n");
}

#[test]
fn a_shift_that_leaves_much_to_explain_is_a_remark() {
    // A column that lies 60 rows late, with a tone of the size of 0.2 and 0.45 of its own motion that no model has.
    let late = |share: f64| {
        let mut campaign = good();
        for run in &mut campaign.runs {
            let signal = &mut run.record.outputs[0].values;
            let first = signal[0];
            signal.rotate_right(60);
            signal[..60].fill(first);
            let size = crate::stats::std(signal);
            for (i, v) in signal.iter_mut().enumerate() {
                *v += share * size * 2f64.sqrt() * (0.37 * i as f64).sin();
            }
        }
        only(&campaign)
    };
    // What is left of the variance is 0.2^2 / (1 + 0.2^2) = 4 %, and 17 %: 41 % of the motion.
    let found = late(0.2);
    assert!(found.problem == Problem::Offset && found.stops(), "{found:?}");
    let found = late(0.45);
    assert_eq!((found.problem, found.severity), (Problem::Offset, Severity::Remark));
    assert!(found.cure.contains("too far from the rig"), "{found:?}");
}

#[test]
fn a_command_of_something_else_is_no_command() {
    let mut campaign = good();
    let others: Vec<Vec<f64>> = [1_000_011, 2_000_012, 3_000_013]
        .map(|seed| run(&[1.0, 4.0, 400.0], 2000, seed, NOISE, (1.0, 0.0), 1.0).inputs[0].values.clone())
        .into();
    for (run, other) in campaign.runs.iter_mut().zip(others) {
        run.record.inputs[0].values = other;
    }
    let found = only(&campaign);
    assert_eq!((found.problem, found.channel.as_str()), (Problem::ForeignCommand, "motor_force_n"));
    assert!(found.stops(), "{found:?}");
    let found = only(&with("motor_force_n", |_| 0.0));
    assert!(found.problem == Problem::ForeignCommand && found.stops(), "{found:?}");
}

#[test]
fn a_dead_column_stops_and_a_clipped_one_is_a_remark() {
    let found = only(&with("spring_deflection_m", |_| 0.25));
    assert!(found.problem == Problem::DeadColumn && found.stops(), "{found:?}");
    let found = only(&with("force_1_n", |v| v.clamp(-5.0, 5.0)));
    assert_eq!((found.problem, found.severity), (Problem::ClippedColumn, Severity::Remark));
    assert!(found.evidence.contains("stands at 5.00 N"), "{found:?}");
    // Whoever sticks does so in every column.
    let mut stuck = good();
    for signal in stuck.runs.iter_mut().flat_map(|r| &mut r.record.outputs) {
        signal.values.fill(0.1);
    }
    let found = look(&stuck, &Toy::new());
    assert!(
        found.iter().all(|f| f.problem == Problem::DeadColumn && !f.stops()) && found.len() == 2,
        "{found:?}"
    );
}

#[test]
fn missing_and_repeated_rows_spikes_and_runs_without_a_judge_are_said() {
    let mut gap = good();
    for t in &mut gap.runs[0].record.time_s[1000..] {
        *t += 0.2;
    }
    // What was measured then belongs to later times; the model is asked for those.
    let found: Vec<_> =
        look(&gap, &Toy::new()).into_iter().filter(|f| f.problem == Problem::MissingRows).collect();
    assert!(found[0].evidence.starts_with("40 rows are missing in 1 places"), "{found:?}");
    assert!(!found[0].stops() && found[0].channel == "time_s");

    let mut spiked = good();
    for run in &mut spiked.runs {
        for i in (100..2000).step_by(400) {
            run.record.outputs[0].values[i] += 40.0;
        }
        run.left_out = LeftOut::of(&run.record);
    }
    let found = only(&spiked);
    assert!(found.problem == Problem::Spikes && !found.stops(), "{found:?}");
    assert!(found.evidence.starts_with("15 rows are spikes of about 40."), "{found:?}");

    let mut stale = good();
    for run in &mut stale.runs {
        for signal in &mut run.record.outputs {
            for i in (100..2000).step_by(20) {
                signal.values[i] = signal.values[i - 1];
            }
        }
        run.left_out = LeftOut::of(&run.record);
    }
    let found = only(&stale);
    assert!(found.problem == Problem::RepeatedRows && found.evidence.starts_with("4.75 %"), "{found:?}");

    let mut alone = good();
    alone.runs.truncate(2);
    let found = only(&alone);
    assert!(found.problem == Problem::NoHoldout && found.stops());
}

#[test]
fn a_column_that_is_the_command_is_no_measurement() {
    let mut echoed = good();
    for run in &mut echoed.runs {
        let command = run.record.inputs[0].values.clone();
        let copy = run.record.outputs.iter_mut().find(|s| s.channel == "force_1_n").expect("a force");
        copy.values = command.iter().map(|v| 2.0 * v).collect();
    }
    let found = look(&echoed, &Toy::new());
    let found = found.iter().find(|f| f.problem == Problem::EchoedCommand).expect("an echo");
    assert!(found.stops() && found.evidence.contains("`motor_force_n` times 2"), "{found:?}");
    assert!(look(&good(), &Toy::new()).iter().all(|f| f.problem != Problem::EchoedCommand));
}

#[test]
fn exchanged_columns_of_one_unit_are_found() {
    // The toy has one column a unit: a second force is made of the first, at another scale and phase.
    use pair::{Line, Pair};
    let a: Vec<f64> =
        (0..3000).map(|i| (0.02 * f64::from(i)).sin() + 0.3 * (0.11 * f64::from(i)).sin()).collect();
    let b: Vec<f64> =
        (0..3000).map(|i| 0.8 * (0.02 * f64::from(i)).sin() - 0.1 * (0.11 * f64::from(i)).cos()).collect();
    let pairs = |m1, m2| {
        let of = |measured, predicted| {
            let rows = 0..3000;
            let pair =
                Pair { run: 0, channel: "f_n", noise: 1e-3, measured, predicted, rows: Vec::from([rows]) };
            against::Seen { line: pair.line(0, 1), pair, judged: false }
        };
        against::exchange(&of(m1, &a), &of(m2, &b))
    };
    assert!(pairs(&b, &a) > 100.0);
    assert!(pairs(&a, &b) < 1.0);
    assert!(Line::through(a.iter().copied().zip(b.iter().copied())).correlation > 0.8);
}

#[test]
fn one_line_says_why_a_diagnosis_is_not_begun() {
    let mut campaign = with("force_1_n", |v| -v);
    assert_eq!(stop(&look(&good(), &Toy::new())), None);
    let one = stop(&look(&campaign, &Toy::new())).unwrap();
    assert!(
        one.contains("`force_1_n` runs against") && one.contains("Negate") && !one.contains('\n'),
        "{one}"
    );
    campaign.runs.truncate(2);
    assert!(stop(&look(&campaign, &Toy::new())).unwrap().ends_with("One more thing is wrong with the log."));
}
