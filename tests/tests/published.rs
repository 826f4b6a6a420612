//! The dissertation's numbers through the same functions as `sealegs reproduce`: the tolerances of what a simulator must
//! reproduce, and the misses that must stay misses.

use std::sync::OnceLock;

use sealegs_reproduce::{Entry, Reproduction, Row, Verdict, entries, reproduce};

/// Everything, computed once for all tests.
fn everything() -> &'static (Vec<Entry>, Reproduction) {
    static ONCE: OnceLock<(Vec<Entry>, Reproduction)> = OnceLock::new();
    ONCE.get_or_init(|| (entries().expect("embedded"), reproduce().expect("recomputed")))
}

fn row(id: &str) -> &'static Row {
    everything().1.rows.iter().find(|r| r.id == id).unwrap_or_else(|| panic!("no row {id}"))
}

fn ours(id: &str) -> f64 {
    row(id).ours.unwrap_or_else(|| panic!("{id} is not recomputed"))
}

#[track_caller]
fn near(id: &str, expected: f64, relative: f64) {
    let value = ours(id);
    assert!((value / expected - 1.0).abs() <= relative, "{id}: {value}, expected {expected}");
}

#[test]
fn published_beams_safety_factors_lever_arm_force_constant_and_ratio() {
    // 0.1 % on everything that follows from stated dimensions alone.
    for (id, expected) in [
        ("E2-01", 2.0 / 3.0),
        ("E2-02", 6.0),
        ("E2-03", 1.0),
        ("E2-04", 1.0),
        ("E2-05", 1.0),
        ("R2-03", 1.355),
        ("R2-04", 1.355),
        ("H2-03", 33.0),
        ("E4-48", 240.33),
        ("E3-02", 1.061_033e-4),
        ("E2-06a", 429.67),
    ] {
        near(id, expected, 1e-3);
    }
}

#[test]
fn published_thor_pair_from_series_compliance_and_the_lock_out() {
    near("H2-07", 371.64e3, 1e-3);
    near("H2-08", 655.40e3, 1e-3);
    near("H2-09", 2771.5, 1e-3);
    near("S2-01", 1.1295, 1e-3);
    assert!((3.6..=5.1).contains(&ours("H2-10")), "the text says four, 5 to 95 % is 3.6 to 5.1");
}

#[test]
fn published_table_5_to_its_printed_digits() {
    for (id, expected, half_unit) in [
        ("T5-01", 294.9, 0.05),
        ("T5-02", 11658.0, 0.5),
        // 3.3125e-6 lies half a unit beside the print; 3.312 is what truncation prints.
        ("T5-03", 3.312e-6, 0.6e-9),
        ("T5-04", 1.3123e-4, 0.5e-8),
    ] {
        assert!((ours(id) - expected).abs() <= half_unit, "{id}: {}", ours(id));
    }
}

#[test]
fn published_high_impedance_bench() {
    near("S3-04", 7.50, 5e-3);
    near("R3-01", 7.50, 5e-3);
    near("R3-02", 160.25, 5e-3);
    near("S3-01", 6.04, 5e-3);
    assert!((ours("S3-02") - 2.37).abs() < 0.1);
    near("S3-03", 10.17, 1e-3);
    near("R3-04", 0.4194, 1e-3);
}

#[test]
fn published_identification_rehearsal_at_400_hz() {
    // With the hold taken out the coefficients come back; the load cell's +-2 N leave a few hundredths of a per cent.
    for id in ["S3-10", "S3-11", "S3-12"] {
        assert!(ours(id).abs() < 0.05, "{id}: {} %", ours(id));
    }
    // Ignored, half a sample costs about 5 % of the constants and 10 % of the damping term.
    assert!((ours("S3-13") + 5.0).abs() < 1.0 && (ours("S3-14") + 10.0).abs() < 2.0);
}

#[test]
fn published_moving_output_from_the_stated_parameters() {
    near("R3-11", 17.02, 5e-3);
    near("R3-12", 6.80, 5e-3);
    near("R3-14", 0.910, 5e-3);
    // By nonlinear simulation and H1: 1 %; the dip to one line of the estimate.
    near("S3-20", 17.02, 1e-2);
    near("S3-21", 6.80, 1e-2);
    assert!((ours("S3-22") - 0.910).abs() < 400.0 / 8192.0);
    near("R3-13", 2.48, 2e-2);
}

#[test]
fn published_moving_output_misses_stay_misses() {
    for (id, per_cent) in [("R3-11", 8.0), ("R3-12", 7.1), ("S3-20", 8.0), ("S3-21", 7.1)] {
        assert_eq!(row(id).verdict, Verdict::Miss, "{id}");
        let deviation = 100.0 * row(id).deviation.expect("both are numbers");
        assert!((deviation - per_cent).abs() < 1.0, "{id}: {deviation} %");
    }
    let dip = 100.0 * row("R3-14").deviation.expect("both are numbers");
    assert!((dip + 9.0).abs() < 0.5, "{dip} %");
    // A missing compliance explains both peaks, more inertia does not.
    let best = &everything().1.explanations[0];
    assert!(best.change.contains("stiffness") || best.change.contains("spring"), "{best:?}");
    let rod = everything().1.explanations.iter().find(|e| e.change.contains("link")).expect("listed");
    assert!(best.misfit < 0.01 && rod.misfit > 3.0 * best.misfit, "{best:?} {rod:?}");
}

#[test]
fn published_table_8_by_column() {
    for (id, expected) in [
        ("T8-wmax-soft-SBN", 135.4),
        ("T8-wmax-soft-SMH", 65.3),
        ("T8-wmax-stiff-SBN", 179.7),
        ("T8-wmax-stiff-SMH", 86.6),
        ("T8-bw3-soft", 6.808),
        ("T8-bw3-stiff", 10.174),
    ] {
        near(id, expected, 1e-3);
    }
    near("T8-bw3-soft", 6.84, 5e-3);
    near("T8-bw3-stiff", 10.19, 5e-3);
    assert!((ours("E4-52") - 0.6151).abs() <= 1e-4);
    near("T8-cmax-soft", 28.2, 5e-3);
    near("T8-cmax-stiff", 42.0, 5e-3);
}

#[test]
fn published_clipped_bandwidth_in_all_rows_and_below_the_bound() {
    let mut rows = 0;
    for p in everything().0.iter().filter(|p| p.id.starts_with("F4-bw-")) {
        near(&p.id, p.independent.expect("recomputed elsewhere"), 5e-3);
        rows += 1;
    }
    assert_eq!(rows, 18);
    for column in &everything().1.table_8 {
        assert!(column.bound_holds, "{column:?}");
    }
    // The bench in small steps confirms the exact steady state.
    assert!(ours("S4-20").abs() < 0.01, "{} dB", ours("S4-20"));
}

#[test]
fn reference_every_row_that_was_recomputed_elsewhere() {
    let mut compared = 0;
    for p in &everything().0 {
        let (Some(independent), Some(value)) = (p.independent, row(&p.id).ours) else { continue };
        let tolerance = match (p.id.as_str(), p.unit.as_str()) {
            // Estimates from noise: another seed, another number.
            ("S3-23", _) => 0.1 * independent,
            ("S3-20" | "S3-21", _) => 0.01 * independent,
            ("S3-22", _) => 400.0 / 8192.0,
            // Zero by proof: rounding.
            _ if independent == 0.0 => 1e-6,
            (_, "dB") => 0.1,
            _ => 5e-3 * independent.abs(),
        };
        assert!((value - independent).abs() <= tolerance, "{}: {value} against {independent}", p.id);
        compared += 1;
    }
    assert!(compared > 120, "{compared}");
}

#[test]
fn verdicts_are_those_of_the_fact_sheet() {
    for (p, r) in everything().0.iter().zip(&everything().1.rows) {
        assert_eq!(p.id, r.id);
        match (r.verdict, p.verdict.as_str()) {
            // Nothing can be computed for the two heights of one robot.
            (Verdict::Statement, verdict) => assert!(verdict == "statement" || p.id == "C1-03", "{}", p.id),
            (Verdict::Miss, verdict) => assert_eq!(verdict, "INCONSISTENT", "{}: {r:?}", p.id),
            (_, verdict) => assert_ne!(verdict, "INCONSISTENT", "{}: {r:?}", p.id),
        }
        assert!(r.verdict == Verdict::Statement || !r.why.is_empty(), "{}: a line of why", p.id);
    }
}
