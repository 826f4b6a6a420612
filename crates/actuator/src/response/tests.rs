//! The published numbers of chapters 3 and 4 from the formula, and the formula against special cases.

use num_complex::Complex64;

use super::*;
use crate::spec::ActuatorSpec;

/// The pendulum bench of section 3-4-5 with standard gravity.
const PENDULUM: (f64, f64, f64, f64) = (0.0725, 0.300, 4.0, 9.80665);
const WIDE: [f64; 2] = [0.01, 1000.0];

/// THOR by Table 5 at a stiffness in N/m.
fn thor(configuration: Configuration, stiffness: f64) -> Coefficients {
    let c = ActuatorSpec::preset("thor-linear").expect("preset").coefficients();
    let sprung_mass = if configuration == Configuration::SprungBallNut { 0.15 } else { c.sprung_mass };
    Coefficients { configuration, stiffness, sprung_mass, ..c }
}

fn smh() -> Coefficients {
    thor(Configuration::SprungMotorHousing, 655e3)
}

fn lumped() -> Coefficients {
    thor(Configuration::Lumped, 655e3)
}

fn pendulum() -> Link {
    let (arm, radius, mass, gravity) = PENDULUM;
    Link::pendulum(arm, radius, mass, gravity)
}

fn near(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() <= relative, "{value} against {expected}");
}

#[test]
fn analytic_locked_responses_have_the_printed_form() {
    let s = Complex64::new(-3.0, 40.0);
    for c in [smh(), thor(Configuration::SprungBallNut, 372e3), lumped()] {
        let r = ForceResponse::locked(&c);
        let denominator = c.total_mass() * s * s + c.damping * s + c.stiffness;
        let sprung = c.stiffness / denominator;
        let m = if c.configuration == Configuration::Lumped { c.total_mass() } else { c.sprung_mass };
        let unsprung = (m * s * s + c.stiffness) / denominator;
        assert!((r.sprung.at(s) - sprung).norm() < 1e-13 * sprung.norm());
        assert!((r.unsprung.at(s) - unsprung).norm() < 1e-13 * unsprung.norm());
        assert!((r.ratio.at(s) - sprung / unsprung).norm() < 1e-13 * r.ratio.at(s).norm());
    }
}

#[test]
fn analytic_equations_of_motion_hold_between_moving_links() {
    // Solve the equations of motion (4-2 to 4-13 in one sign convention) for the motions at some s and compare.
    let s = Complex64::new(-2.0, 75.0);
    let d = |m: f64, k: f64| m * s * s + k;
    for configuration in
        [Configuration::SprungMotorHousing, Configuration::SprungBallNut, Configuration::Lumped]
    {
        let c = thor(configuration, 655e3);
        let (sprung_link, other) = (Link::free(5.0), Link::Mass { mass_kg: 68.0, stiffness_n_m: 2240.0 });
        let response = ForceResponse::new(&c, sprung_link, other);
        let (d_s, d_u) = (d(5.0, 0.0), d(68.0, 2240.0));
        // Forces on the links follow from the response; from them the motions; then check Newton for the sprung
        // mass and for the motor. Spring link at x_s (pushed by -F_s), other link at x_u (pushed by +F_u).
        let (f_s, f_u) = (response.sprung.at(s), response.unsprung.at(s));
        let (x_s, x_u) = (-f_s / d_s, f_u / d_u);
        let x_m = x_s - f_s / c.stiffness; // spring compressed by f_s: x_s - x_m
        let (m, inertia) = match configuration {
            Configuration::Lumped => (c.total_mass(), 0.0),
            _ => (c.sprung_mass, c.reflected_inertia),
        };
        let newton = m * s * s * x_m - (f_s - f_u);
        assert!(newton.norm() < 1e-10, "{configuration:?}: {newton}");
        let y = x_u - x_m;
        let motor = (inertia * s * s + c.damping * s) * y - (1.0 - f_u);
        assert!(motor.norm() < 1e-10, "{configuration:?}: {motor}");
    }
}

#[test]
fn published_locked_bench_resonance_and_peak() {
    let r = ForceResponse::locked(&smh());
    let mode = r.sprung.resonances()[0];
    near(mode.frequency_hz, 7.501, 1e-4);
    near(mode.damping_ratio, 0.4194, 1e-3);
    let peak = peaks(|f| r.sprung.at_hz(f), WIDE)[0];
    near(peak.frequency_hz, 6.04, 1e-3);
    assert!((peak.gain_db - 2.37).abs() < 0.01, "{peak:?}");
    for (hz, gain) in [(20.0, -16.3), (60.0, -36.0), (100.0, -45.0)] {
        assert!((db(r.sprung.at_hz(hz)) - gain).abs() < 0.06, "{hz} Hz: {}", db(r.sprung.at_hz(hz)));
    }
}

#[test]
fn published_sprung_mass_resonances() {
    for (configuration, stiffness, hz) in [
        (Configuration::SprungMotorHousing, 655e3, 160.25),
        (Configuration::SprungMotorHousing, 372e3, 120.8),
        (Configuration::SprungBallNut, 655e3, 332.6),
        (Configuration::SprungBallNut, 372e3, 250.6),
        // Printed 7.47 (section 3-4-3), 0.4 % off what Table 5 gives.
        (Configuration::Lumped, 655e3, 7.501),
    ] {
        let r = ForceResponse::locked(&thor(configuration, stiffness));
        near(r.ratio.resonances()[0].frequency_hz, hz, 1e-3);
        let peak = peaks(|f| r.ratio.at_hz(f), WIDE)[0];
        near(peak.frequency_hz, r.ratio.resonances()[0].frequency_hz, 1e-6);
        let notch = dips(|f| r.unsprung.at_hz(f), [3.0, 1000.0]);
        near(notch[0].frequency_hz, r.unsprung.anti_resonances()[0].frequency_hz, 1e-6);
    }
}

#[test]
fn published_force_on_the_other_link() {
    // Unlumped: plateau m_s/m_T = -53.2 dB. Lumped: below -3 dB from 4.99 to 11.28 Hz (figure 3-7b).
    let r = ForceResponse::locked(&smh());
    assert!((db(r.unsprung.at_hz(1e5)) + 53.2).abs() < 0.05);
    assert!((db(r.ratio.at_hz(15.0)) - 0.08).abs() < 0.005);
    assert!((db(r.ratio.at_hz(60.0)) - 1.31).abs() < 0.005);
    let r = ForceResponse::locked(&lumped());
    let below = crossings(|f| r.unsprung.at_hz(f), HALF_POWER_DB, WIDE);
    assert_eq!(below.len(), 2);
    near(below[0], 4.99, 1e-3);
    near(below[1], 11.28, 1e-3);
}

#[test]
fn published_moving_output_peaks_and_dip() {
    // Printed 15.76, 6.35 and 1 Hz: a known miss of +8.0, +7.1 and -9 %; these follow from the stated parameters.
    for (c, hz, gain, pole_hz, damping) in
        [(smh(), 17.02, 9.28, 17.04, 0.0315), (lumped(), 6.80, 14.8, 6.798, 0.0219)]
    {
        let r = ForceResponse::between(&c, Link::Fixed, pendulum());
        let response = |f| r.force_1().at_hz(f);
        let peak = *peaks(response, [2.0, 100.0]).first().expect("a peak");
        near(peak.frequency_hz, hz, 5e-3);
        assert!((peak.gain_db - gain).abs() < 0.05, "{peak:?}");
        near(dips(response, [0.3, 3.0])[0].frequency_hz, 0.910, 5e-3);
        let mode = *r.force_1().resonances().iter().find(|m| m.damping_ratio < 0.1).expect("an oscillation");
        near(mode.frequency_hz, pole_hz, 1e-3);
        near(mode.damping_ratio, damping, 5e-3);
    }
}

#[test]
fn published_lumped_and_unlumped_agree_where_the_spring_side_moves() {
    let peak = |c: &Coefficients| {
        let r = ForceResponse::between(c, pendulum(), Link::Fixed);
        peaks(|f| r.force_1().at_hz(f), [2.0, 100.0])[0].frequency_hz
    };
    near(peak(&smh()), 17.12, 1e-3);
    near(peak(&lumped()), 17.12, 1e-3);
}

#[test]
fn published_free_links_of_figure_4_12() {
    let peak = |sprung, unsprung| {
        let r = ForceResponse::new(&smh(), sprung, unsprung);
        peaks(|f| r.sprung.at_hz(f), [2.0, 100.0])[0].frequency_hz
    };
    let link = Link::free(68.49);
    near(peak(Link::Fixed, link), 17.00, 1e-3);
    near(peak(link, Link::Fixed), 17.10, 1e-3);
    near(peak(link, link), 23.10, 1e-3);
}

#[test]
fn published_forces_ratio_when_links_move() {
    // The unsprung link does not matter at all.
    let s = Complex64::new(0.0, 300.0);
    let held = ForceResponse::locked(&smh()).ratio.at(s);
    let moving = ForceResponse::new(&smh(), Link::Fixed, Link::free(3.0)).ratio.at(s);
    assert!((held - moving).norm() < 1e-14 * held.norm());
    // The sprung one does: columns are its mass, low-frequency ratio (dB), resonance and first +3 dB (Hz).
    for (mass, gain, resonance, differ) in [
        (68.5, -0.08, 161.0, 88.0),
        (20.0, -0.28, 162.8, 91.3),
        (5.0, -1.06, 170.3, 104.0),
        (1.0, -4.3, 205.6, 155.2),
    ] {
        let r = ForceResponse::new(&smh(), Link::free(mass), Link::Fixed);
        assert!((db(r.ratio.at_hz(1e-3)) - gain).abs() < 0.05, "{mass} kg");
        near(r.ratio.resonances()[0].frequency_hz, resonance, 1e-3);
        near(crossings(|f| r.ratio.at_hz(f), 3.0, WIDE)[0], differ, 1e-3);
    }
    near(forces_differ_hz(&ForceResponse::locked(&smh()), WIDE).expect("differ"), 86.59, 1e-3);
}

#[test]
fn published_omega_max_by_column_of_table_8() {
    for (configuration, stiffness, hz) in [
        (Configuration::SprungBallNut, 372e3, 135.4),
        (Configuration::SprungMotorHousing, 372e3, 65.26),
        (Configuration::SprungBallNut, 655e3, 179.7),
        (Configuration::SprungMotorHousing, 655e3, 86.59),
    ] {
        let c = thor(configuration, stiffness);
        near(pure_force_source_hz(stiffness, c.sprung_mass), hz, 1e-3);
        near(pure_force_source_min_stiffness(c.sprung_mass, hz), stiffness, 2e-3);
    }
    near(pure_force_source_min_stiffness(1.0, 1.0), 135.20, 3e-4);
}

#[test]
fn published_plant_bandwidth_and_compensator_bound() {
    for (stiffness, bandwidth, printed, bound) in [(372e3, 6.808, 6.84, 28.06), (655e3, 10.174, 10.19, 41.94)]
    {
        let c = thor(Configuration::SprungMotorHousing, stiffness);
        let b = CompensatorBound::new(&c, 10.0, 200.0);
        near(b.plant_bandwidth_hz, bandwidth, 1e-3);
        near(b.plant_bandwidth_hz, printed, 5e-3);
        let found = crossings(|f| plant(&c).at_hz(f), HALF_POWER_DB, WIDE)[0];
        near(b.plant_bandwidth_hz, found, 1e-9);
        assert!((b.increase_decades - 0.61515).abs() < 1e-4);
        assert!((b.max_gain_db - 24.61).abs() < 0.005 && (b.max_gain_fundamental_db - 23.69).abs() < 0.005);
        near(b.bandwidth_hz, bound, 1e-3);
    }
}

#[test]
fn published_table_5_from_eq_3_14() {
    let fit = SecondOrderFit::PRINTED;
    assert!((fit.dc_gain() - 0.9504).abs() < 1e-4);
    let model = fit.extract(655e3, 0.6461, 1.061e-4);
    assert_eq!(format!("{:.1}", model.total_mass_kg), "294.9");
    assert_eq!(format!("{:.0}", model.damping_n_s_m), "11658");
    // Printed 3.312e-6 and 1.3123e-4.
    near(model.rotor_inertia_kg_m2, 3.3125e-6, 1e-4);
    assert_eq!(format!("{:.4e}", model.rotor_damping_nm_s), "1.3123e-4");
}
