//! The corrected Table 8, and designs whose answer is known.

use super::*;
use crate::spring::EndLoadedBeam;

fn thor() -> ActuatorSpec {
    ActuatorSpec::preset("thor-linear").expect("preset")
}

fn request(bandwidth_hz: f64) -> DesignRequest {
    DesignRequest {
        amplitude_n: 200.0,
        bandwidth_hz,
        current_limit_a: 10.0,
        sprung_mass_kg: 0.6461,
        spring_side: Configuration::SprungMotorHousing,
    }
}

fn near(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() <= relative, "{value} against {expected}");
}

#[test]
fn published_table_8_corrected() {
    let table = table_8(&thor(), 10.0, 200.0);
    // Pure force source by column; printed in ascending order instead.
    for (column, hz) in table.iter().zip([135.4, 65.3, 179.7, 86.6]) {
        near(column.pure_force_source_hz, hz, 1e-3);
        assert!((column.increase_decades - 0.6151).abs() < 1e-4);
        assert_eq!(column.limited_by, Criterion::ControlledBandwidth);
        assert!(column.bound_holds);
    }
    for (column, [natural, half_power, bound, simulated]) in
        table.iter().skip(1).step_by(2).zip([[5.653, 6.808, 28.06, 25.69], [7.501, 10.174, 41.94, 34.32]])
    {
        near(column.natural_frequency_hz, natural, 1e-3);
        near(column.plant_bandwidth_hz, half_power, 1e-3);
        near(column.bound_hz, bound, 1e-3);
        near(column.simulated_hz.expect("a band"), simulated, 5e-3);
    }
    // The spring's side changes the plant by less than 0.1 %.
    near(table[0].natural_frequency_hz, 5.658, 1e-3);
    near(table[2].natural_frequency_hz, 7.508, 1e-3);
}

#[test]
fn published_the_stiff_setting_is_what_34_3_hz_needs() {
    let design = design(&thor(), &request(34.32)).expect("a linear actuator");
    near(design.min_stiffness_n_m.expect("reached"), 655e3, 5e-3);
    assert_eq!(design.limited_by, Criterion::ControlledBandwidth);
    // The bound promises the same band from a softer spring.
    assert!(design.bound_min_stiffness_n_m.expect("reached") < 500e3);
    near(design.pure_force_source_min_stiffness_n_m, 135.2 * 0.6461 * 34.32 * 34.32, 1e-3);
    near(design.bound_fails_below_n_m.expect("somewhere"), 283e3, 0.01);
    let at = design.at_min_stiffness.expect("reached");
    near(at.simulated_hz.expect("a band"), 34.32, 1e-6);

    let [saffir, thor] = &design.beams[..] else { panic!("two beams") };
    // 655 kN/m is past SAFFiR's shortest pivot (524.8 kN/m at 65 mm).
    assert!(!saffir.in_range && saffir.available.is_none());
    near(thor.length_m.expect("a length"), 0.055, 5e-3);
    assert_eq!(thor.available.as_ref().map(|a| a.setting.as_str()), Some("stiff"));
    near(thor.peak_stress_pa.expect("a beam"), 463.7e6, 1e-3);
    near(thor.safety_factor.expect("a beam"), 1.7855, 1e-3);
    near(thor.deflection_m, 200.0 / 655e3, 5e-3);
}

#[test]
fn a_heavy_sprung_mass_makes_the_force_source_the_limit() {
    let heavy = DesignRequest { sprung_mass_kg: 20.0, ..request(20.0) };
    let design = design(&thor(), &heavy).expect("a linear actuator");
    assert_eq!(design.limited_by, Criterion::PureForceSource);
    near(design.min_stiffness_n_m.expect("reached"), 135.2 * 20.0 * 400.0, 1e-3);
    let at = design.at_min_stiffness.expect("reached");
    near(at.usable_hz, 20.0, 1e-9);
    assert_eq!(at.limited_by, Criterion::PureForceSource);
}

#[test]
fn a_softer_wish_is_met_by_a_pivot_of_saffir() {
    let saffir = ActuatorSpec::preset("saffir-linear").expect("preset");
    let wish = DesignRequest { sprung_mass_kg: saffir.sprung_mass_kg, ..request(40.0) };
    let design = design(&saffir, &wish).expect("a linear actuator");
    let k = design.min_stiffness_n_m.expect("reached");
    let choice = &design.beams[0];
    let pivot = choice.length_m.expect("a pivot");
    near(EndLoadedBeam::saffir(pivot).stiffness_n_m(), k, 1e-9);
    assert_eq!(choice.in_range, (0.065..=0.110).contains(&pivot));
    assert!(choice.available.as_ref().is_none_or(|a| a.stiffness_n_m >= k * (1.0 - 1e-9)));
}

#[test]
fn a_force_beyond_the_motor_has_no_design_and_bad_numbers_are_errors() {
    let design_of = |request: &DesignRequest| design(&thor(), request);
    let strong = design_of(&DesignRequest { amplitude_n: 5000.0, ..request(10.0) }).expect("an answer");
    assert_eq!((strong.min_stiffness_n_m, strong.beams.len()), (None, 0));
    for bad in [
        DesignRequest { amplitude_n: 0.0, ..request(10.0) },
        DesignRequest { bandwidth_hz: f64::NAN, ..request(10.0) },
        DesignRequest { current_limit_a: -1.0, ..request(10.0) },
        DesignRequest { sprung_mass_kg: f64::INFINITY, ..request(10.0) },
        DesignRequest { spring_side: Configuration::Lumped, ..request(10.0) },
    ] {
        assert!(matches!(design_of(&bad), Err(ActuatorError::Value { .. })), "{bad:?}");
    }
    let rotary = ActuatorSpec::preset("rmd-x8-rotary-sea").expect("preset");
    assert!(design(&rotary, &request(10.0)).expect_err("rotary").to_string().contains("linear"));
}
