//! Tests of the actuator file: presets, round trip, and one clear message for each kind of bad input.

use std::path::Path;

use sealegs_model::{Parameter, Scale};

use super::*;

fn thor() -> ActuatorSpec {
    ActuatorSpec::preset("thor-linear").expect("preset")
}

/// The preset's text with one line replaced.
fn edited(from: &str, to: &str) -> Result<ActuatorSpec, ActuatorError> {
    let text = ActuatorSpec::preset_text("thor-linear").expect("preset");
    assert!(text.contains(from), "{from} is not in the preset");
    ActuatorSpec::from_toml(&text.replacen(from, to, 1), "mine.toml")
}

fn message(from: &str, to: &str) -> String {
    edited(from, to).expect_err("bad input").to_string()
}

#[test]
fn every_preset_loads_and_survives_a_round_trip() {
    for name in ActuatorSpec::preset_names() {
        let spec = ActuatorSpec::preset(name).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(spec.id, name);
        let again = ActuatorSpec::from_toml(&spec.to_toml(), "again.toml").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again, spec, "{name}");
    }
}

#[test]
fn published_table_5_follows_from_the_preset() {
    let c = thor().coefficients();
    assert_eq!(c.stiffness, 655e3);
    assert!((thor().ratio() - 1.061033e-4).abs() < 1e-10);
    assert!((c.total_mass() - 294.9).abs() < 1e-3, "{}", c.total_mass());
    assert!((c.reflected_inertia - 294.254).abs() < 1e-3);
    assert!((c.damping - 11658.0).abs() < 0.01, "{}", c.damping);
    assert!((c.force_constant - 240.33).abs() < 0.005);
    // eq 3-2 with SAFFiR's screw and belt: 2.0213e-4 m.
    let saffir = ActuatorSpec::preset("saffir-linear").expect("preset");
    assert!((saffir.ratio() / 2.0213e-4 - 1.0).abs() < 1e-4);
    assert!((saffir.coefficients().stiffness / 429.67e3 - 1.0).abs() < 1e-4);
}

#[test]
fn published_no_load_speeds_are_just_above_table_2() {
    // 0.3805 and 0.1997 m/s; Table 2 rates 0.35 and 0.19.
    let speed = |name| ActuatorSpec::preset(name).expect("preset").no_load_speed().expect("a supply");
    assert!((speed("saffir-linear") / 0.3805 - 1.0).abs() < 1e-3);
    assert!((speed("thor-linear") / 0.1997 - 1.0).abs() < 1e-3);
}

#[test]
fn a_spring_setting_drops_the_stiffness_measured_at_the_old_one() {
    let compliant = thor().with_spring_setting("compliant").expect("a setting of THOR");
    assert!((compliant.coefficients().stiffness / 371.64e3 - 1.0).abs() < 1e-3);
    let stiffness = &compliant.base_parameters()[0];
    assert!((stiffness.prior_std.expect("tolerance") / (0.03 * 371.64e3) - 1.0).abs() < 1e-3);
    assert!(stiffness.min < stiffness.value && stiffness.value < stiffness.max);
    assert!(thor().with_spring_setting("sitff").expect_err("misspelt").to_string().contains("'stiff'"));
}

#[test]
fn base_parameters_carry_units_priors_and_bounds() {
    let names: Vec<String> = thor().base_parameters().into_iter().map(|p| p.name).collect();
    let of_a_spring: Vec<&str> =
        BASE_PARAMETERS.map(|(name, ..)| name).into_iter().filter(|n| *n != "winding_resistance").collect();
    assert_eq!(names, of_a_spring);
    let [k, inertia, damping, constant, gain, mass, ..] = &thor().base_parameters()[..] else {
        panic!("six")
    };
    assert_eq!((k.unit.as_str(), k.prior_std, k.fixed), ("N/m", Some(0.03 * 655e3), false));
    assert!((inertia.prior_std.expect("tolerance") / inertia.value - 0.06).abs() < 1e-12);
    assert!((damping.prior_std.expect("tolerance") / damping.value - 0.10).abs() < 1e-12);
    assert!((constant.prior_std.expect("tolerance") / constant.value - 0.02).abs() < 1e-12);
    assert!(gain.fixed && mass.fixed);
    for p in thor().base_parameters() {
        assert!(p.min <= p.value && p.value <= p.max && p.typical > 0.0, "{p:?}");
    }

    let rotary = ActuatorSpec::preset("rmd-x8-rotary-sea").expect("preset");
    let parameters = rotary.base_parameters();
    assert_eq!(parameters.len(), 8);
    assert_eq!((parameters[0].unit.as_str(), parameters[0].value), ("N m/rad", 2500.0));
    assert_eq!((parameters[1].scale, parameters[1].prior_std), (Scale::Logarithmic, None));
    assert!((parameters[3].value - 1.393).abs() < 1e-4);
    assert!(!parameters[4].fixed);
}

#[test]
fn the_normalised_mass_spring_damper_resonates_at_30_hz() {
    let c = ActuatorSpec::preset("mass-spring-damper").expect("preset").coefficients();
    let hz = (c.stiffness / c.total_mass()).sqrt() / std::f64::consts::TAU;
    assert!((hz - 30.0).abs() < 0.01);
    assert_eq!((c.force_constant, c.sprung_mass), (1.0, 0.0));
}

#[test]
fn a_model_file_keeps_effects_sensors_and_provenance() {
    let mut text = ActuatorSpec::preset_text("thor-linear").expect("preset").to_owned();
    text.push_str(
        "\n[[effect]]\nid = \"coulomb-friction\"\n[effect.parameters]\nforce_n = { value = 30.0, std = 0.5 }\n\
         [[effect]]\nid = \"torque-ripple\"\n[effect.parameters]\namplitude_n = 22.5\ncycles_per_rev = 7\n\
         [provenance]\ncampaign = \"knee-bench-2014\"\n",
    );
    let spec = ActuatorSpec::from_toml(&text, "model.toml").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(spec.effects[0].parameters["force_n"], EffectValue { value: 30.0, std: Some(0.5) });
    assert_eq!(spec.effects[1].parameters["cycles_per_rev"], EffectValue { value: 7.0, std: None });
    assert_eq!(spec.provenance["campaign"], "knee-bench-2014");
    assert_eq!(spec.sensors["force_1_n"].bias_std, Some(3.0));
    let again = ActuatorSpec::from_toml(&spec.to_toml(), "again.toml").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(again, spec);
}

#[test]
fn bad_text_names_file_line_and_suggestion() {
    let unknown = message("sprung_mass_kg = 0.6461", "sprung_mas_kg = 0.6461");
    assert!(unknown.starts_with("mine.toml:9:"), "{unknown}");
    assert!(unknown.contains("did you mean 'sprung_mass_kg'?"), "{unknown}");
    let nested = message("torque_constant_nm_a", "torque_konstant_nm_a");
    assert!(nested.contains("did you mean 'torque_constant_nm_a'?"), "{nested}");
    let spring = message("lever_arm_m", "lever_am_m");
    assert!(spring.contains("did you mean 'lever_arm_m'?"), "{spring}");
    let material = message("\"titanium-6al-4v\"", "\"titanium-6al4v\"");
    assert!(material.contains("did you mean 'titanium-6al-4v'?"), "{material}");
    let setting = message("setting = \"stiff\"", "setting = \"stif\"");
    assert!(setting.contains("did you mean 'stiff'?"), "{setting}");
    assert!(message("kind = \"linear\"", "kind = linear").starts_with("mine.toml:7:"));
    assert!(message("id = \"thor-linear\"", "").contains("id"));
}

#[test]
fn bad_values_name_file_line_and_field() {
    for (from, to, field) in [
        ("rotor_inertia_kg_m2 = 3.3126837e-6", "rotor_inertia_kg_m2 = 0.0", "motor.rotor_inertia_kg_m2"),
        ("torque_constant_nm_a = 0.0255", "torque_constant_nm_a = nan", "motor.torque_constant_nm_a"),
        ("belt_ratio = 3.0", "belt_ratio = inf", "transmission.belt_ratio"),
        ("value = 655000.0", "value = -655000.0", "parameters.stiffness.value"),
        ("thickness_m = 0.005", "thickness_m = -0.005", "spring.thickness_m"),
        ("sprung_mass_kg = 0.6461", "sprung_mass_kg = -1", "sprung_mass_kg"),
        ("peak_force_n = 2225.0", "peak_force_n = 0", "ratings.peak_force_n"),
        ("gain_std = 0.01", "gain_std = nan", "sensors.force_1_n.gain_std"),
        ("setting = \"stiff\"", "setting = -0.05", "spring.setting"),
    ] {
        let text = ActuatorSpec::preset_text("thor-linear").expect("preset");
        let line = text[..text.find(from).expect("in the preset")].matches('\n').count() + 1;
        let message = message(from, to);
        assert!(message.starts_with(&format!("mine.toml:{line}: {field} = ")), "{message}");
    }
    let overflow = message("screw_lead_m = 0.002", "screw_lead_m = 1e-300");
    assert!(overflow.contains("parameters.reflected_inertia = inf: must be finite"), "{overflow}");
    let kind = message("kind = \"linear\"", "kind = \"rotary\"");
    assert!(kind.contains("mine.toml"), "{kind}");
    let parameter = message("[parameters.stiffness]", "[parameters.stifness]");
    assert!(parameter.contains("did you mean 'stiffness'?"), "{parameter}");
    let bounds = message("min = 200e3", "min = 700e3");
    assert!(bounds.contains("parameters.stiffness") && bounds.contains("between min and max"), "{bounds}");
    let channel = message("[sensors.force_1_n]", "[sensors.force_1_lbf]");
    assert!(channel.contains("known unit"), "{channel}");
}

#[test]
fn what_is_known_of_an_effect_replaces_its_guesses() {
    let spec = ActuatorSpec::preset("rmd-x8-rotary-sea").expect("preset");
    let model = crate::bench::BenchModel::new(spec, crate::bench::Bench::Locked).expect("bench");
    // A command in N m, as this rig takes it.
    let range =
        sealegs_model::SignalRange { name: "motor_torque_nm".to_owned(), min: -6.0, max: 6.0, rms: 3.0 };
    let seen = sealegs_model::Excitation { ranges: vec![range], ..sealegs_model::Excitation::default() };
    let cards = sealegs_model::Model::effects(&model, &seen);
    let card = cards.iter().find(|c| c.id == "command-quantisation").expect("offered");
    let (count, rounding) = (&card.parameters[0], &card.parameters[1]);
    assert_eq!((count.value, count.starts.len(), rounding.fixed), (0.02229, 0, true));
    assert!((count.prior_std.expect("a tolerance") - 0.02 * 0.02229).abs() < 1e-12);
    assert!(count.min > 0.85 * 0.02229 && count.max < 1.15 * 0.02229, "{count:?}");
    let other = cards.iter().find(|c| c.id == "coulomb-friction").expect("offered");
    assert!(other.parameters[0].prior_std.is_none());

    let known = |table: &str| message("[sensors.force_1_n]", &format!("{table}\n[sensors.force_1_n]"));
    let effect = known("[known.command-quantization]\ncount = { value = 1.0 }\n");
    assert!(effect.contains("did you mean 'command-quantisation'?"), "{effect}");
    let parameter = known("[known.backlash]\ngap = { value = 1e-5 }\n");
    assert!(parameter.contains("known.backlash.gap") && parameter.contains("gap_m"), "{parameter}");
    let value = known("[known.backlash]\ngap_m = { value = nan }\n");
    assert!(value.contains("known.backlash.gap_m.value = "), "{value}");
    let bounds = known("[known.backlash]\ngap_m = { value = 1e-5, min = 2e-5 }\n");
    assert!(bounds.contains("between min and max"), "{bounds}");
}

#[test]
fn an_unknown_preset_is_suggested_and_a_missing_file_is_named() {
    let unknown = ActuatorSpec::load("thor-liner", None).expect_err("no such preset").to_string();
    assert!(
        unknown.contains("did you mean 'thor-linear'?") && unknown.contains("saffir-linear"),
        "{unknown}"
    );
    let missing = ActuatorSpec::load("no/such.toml", Some(Path::new("campaign"))).expect_err("no file");
    assert!(missing.to_string().contains("such.toml"), "{missing}");
}

#[test]
fn an_existing_path_goes_before_a_preset() {
    let folder = tempfile::tempdir().expect("a folder");
    let mine = ActuatorSpec { sprung_mass_kg: 0.7, ..thor() };
    std::fs::write(folder.path().join("thor-linear"), mine.to_toml()).expect("written");
    let loaded = ActuatorSpec::load("thor-linear", Some(folder.path())).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(loaded, mine);
    assert_eq!(ActuatorSpec::load("thor-linear", None).unwrap_or_else(|e| panic!("{e}")), thor());
}

#[test]
fn every_line_of_a_preset_may_be_spoilt_without_a_panic() {
    for name in ActuatorSpec::preset_names() {
        let text = ActuatorSpec::preset_text(name).expect("preset");
        let lines: Vec<&str> = text.lines().collect();
        for (i, line) in lines.iter().enumerate() {
            let key = line.split('=').next().unwrap_or_default().trim();
            let values = ["nan", "-1", "0", "1e400", "\"text\"", "{ value = 1 }", "[1]", "true", ""];
            for spoilt in values.map(|v| format!("{key} = {v}")).into_iter().chain([String::new()]) {
                let mut changed: Vec<&str> = lines.clone();
                changed[i] = &spoilt;
                match ActuatorSpec::from_toml(&changed.join("\n"), "spoilt.toml") {
                    // What is still admitted is an actuator that can be used.
                    Ok(spec) => {
                        let c = spec.coefficients();
                        let stiff = c.stiffness.is_finite() || spec.is_rigid();
                        assert!(c.stiffness > 0.0 && stiff, "{line} -> {spoilt}");
                        assert!(c.total_mass() > 0.0 && c.total_mass().is_finite(), "{line} -> {spoilt}");
                        assert!(c.force_constant.is_finite() && c.damping >= 0.0, "{line} -> {spoilt}");
                        assert!(ActuatorSpec::from_toml(&spec.to_toml(), "again.toml").is_ok());
                    }
                    Err(error) => assert!(error.to_string().starts_with("spoilt.toml:"), "{error}"),
                }
            }
        }
    }
}

#[test]
fn a_stated_value_has_room_on_both_sides_unless_the_bound_is_the_laws_own() {
    let effect = |text: &str| -> EffectSpec { toml::from_str(text).unwrap() };
    let given = EffectValue { value: 30.0, std: Some(0.5) };
    // Guessed for an excitation of 1 N, as nothing is known of the runs.
    let guessed = Parameter { starts: vec![0.5], ..Parameter::new("force_n", "N", 0.03, 0.0, 2.0) };
    let mut friction = guessed.clone();
    effect("id = \"coulomb-friction\"").state(given, &mut friction);
    assert_eq!(
        (friction.value, friction.prior_std, friction.min, friction.max),
        (30.0, Some(0.5), 0.0, 300.0)
    );
    assert!(friction.starts.is_empty());
    // A ratio's bound is the law's.
    let mut asymmetry = Parameter::new("asymmetry", "", 0.2, -1.0, 1.0);
    effect("id = \"direction-dependent-friction\"")
        .state(EffectValue { value: 0.9, std: None }, &mut asymmetry);
    assert_eq!((asymmetry.min, asymmetry.max, asymmetry.prior_std), (-1.0, 1.0, None));
    // A user's own bound was stated.
    let mut own = guessed;
    effect("id = \"mine\"\n[definition]\nlaw = \"a\"").state(EffectValue { value: 1.5, std: None }, &mut own);
    assert_eq!((own.min, own.max), (0.0, 2.0));
}

#[test]
fn published_the_stiff_setting_is_table_5_whether_the_file_or_a_scenario_says_it() {
    // Table 5 has 655 kN/m, equation 2-10 rounded; the file states it at the setting that it has.
    let stiff = thor().with_spring_setting("stiff").expect("a setting of THOR");
    assert_eq!(stiff.coefficients().stiffness, 655e3);
    assert_eq!(stiff, thor());
    let compliant = thor().with_spring_setting("compliant").expect("a setting of THOR");
    assert_ne!(compliant.coefficients().stiffness, 655e3);
}
