//! The files of a small actuator, as they stand in `golden/`. `SEALEGS_WRITE_GOLDEN=1` writes them anew, for a look at what
//! changed.

mod common;

use common::is_golden;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig};
use sealegs_export::{ExportError, Fate, Format, bench, leg};
use sealegs_leg::scenario::Scenario;

/// Round numbers: r = 1 mm/rad, m_J = 100 kg, b = 2000 N s/m, k = 500 kN/m, K = 200 N/A.
const SMALL: &str = "id = \"small\"
kind = \"linear\"
sprung_mass_kg = 0.5

[motor]
torque_constant_nm_a = 0.2
rotor_inertia_kg_m2 = 1e-4
rotor_damping_nm_s = 2e-3

[transmission]
type = \"direct\"

[spring]
type = \"constant\"
stiffness_n_m = 500e3

[parameters.reflected_inertia]
value = 100.0

[parameters.damping]
value = 2000.0

[parameters.force_constant]
value = 200.0

[parameters.travel_per_rad]
value = 0.001
";

fn model(effects: &[(&str, &[(&str, f64)])], bench: Bench) -> BenchModel {
    let mut text = SMALL.to_owned();
    for (id, parameters) in effects {
        let inner: Vec<String> = parameters.iter().map(|(name, v)| format!("{name} = {v:?}")).collect();
        text.push_str(&format!("\n[[effect]]\nid = \"{id}\"\nparameters = {{ {} }}\n", inner.join(", ")));
    }
    let spec = ActuatorSpec::from_toml(&text, "small.toml").unwrap_or_else(|e| panic!("{e}"));
    BenchModel::new(spec, bench).unwrap_or_else(|e| panic!("{e}"))
}

fn pendulum() -> Bench {
    Bench::Pendulum(PendulumRig { arm_m: 0.1, length_m: 0.5, mass_kg: 2.0, rod_mass_kg: 0.0 })
}

#[test]
fn regress_a_locked_bench_in_every_format() {
    let model = model(
        &[
            ("coulomb-friction", &[("force_n", 30.0)]),
            ("current-saturation", &[("limit_a", 4.0)]),
            ("transport-delay", &[("delay_s", 0.003)]),
            ("hardening-spring", &[("cubic_n_m3", 1e10)]),
        ],
        Bench::Locked,
    );
    for (format, ending) in
        [(Format::Mjcf, "xml"), (Format::Urdf, "urdf"), (Format::Sdf, "sdf"), (Format::IsaacLab, "py")]
    {
        let done = bench(format, &model, "current_a", "locked").unwrap();
        is_golden(&format!("locked.{ending}"), &done.text);
        if ending != "py" {
            roxmltree::Document::parse(&done.text).unwrap_or_else(|e| panic!("{ending}: {e}"));
        }
    }
}

#[test]
fn regress_a_pendulum_with_callbacks_and_tendons() {
    let model = model(
        &[
            (
                "stribeck-friction",
                &[("coulomb_n", 20.0), ("static_n", 40.0), ("stribeck_velocity_m_s", 0.004)],
            ),
            ("voltage-saturation", &[("bus_v", 24.0), ("resistance_ohm", 2.0)]),
            ("backlash", &[("gap_m", 4e-5)]),
            ("series-compliance", &[("stiffness_n_m", 1e7), ("unsprung_mass_kg", 0.1)]),
            ("sensor-lag@force_1_n", &[("cutoff_hz", 200.0)]),
        ],
        pendulum(),
    );
    let done = bench(Format::Mjcf, &model, "current_a", "my-pendulum").unwrap();
    is_golden("pendulum.xml", &done.text);
    assert_eq!(done.beside.len(), 1);
    assert_eq!(done.beside[0].0, "my_pendulum.py");
    is_golden("pendulum_beside.py", &done.beside[0].1);
    is_golden("pendulum_isaaclab.py", &bench(Format::IsaacLab, &model, "current_a", "p").unwrap().text);
    assert!(done.notes.iter().all(|n| n.fate != Fate::Lost), "{:?}", done.notes);
    // A joint's drive cannot hold the half of it, and says so of each.
    let urdf = bench(Format::Urdf, &model, "current_a", "p").unwrap();
    let lost: Vec<&str> =
        urdf.notes.iter().filter(|n| n.fate == Fate::Lost).map(|n| n.what.as_str()).collect();
    for what in ["spring", "backlash", "series-compliance", "sensor-lag@force_1_n"] {
        assert!(lost.contains(&what), "{what} in {lost:?}");
    }
}

#[test]
fn analytic_inertia_and_losses_at_the_lever() {
    let plain = model(&[("coulomb-friction", &[("force_n", 30.0)])], pendulum());
    let done = bench(Format::Urdf, &plain, "current_a", "p").unwrap();
    // 100 kg at 0.1 m; 2000 N s/m and 30 N there.
    assert!(
        done.text.contains("iyy=\"1\"") || done.text.contains("iyy=\"1.0000000000000002\""),
        "{}",
        done.text
    );
    assert!(done.text.contains("friction=\"3\""), "{}", done.text);
    assert!(
        done.text.contains("damping=\"20\"") || done.text.contains("damping=\"20.000000000000004\""),
        "{}",
        done.text
    );
}

#[test]
fn benches_and_names_that_nobody_can_write_are_refused() {
    let free = model(&[], Bench::Masses { link_1_kg: f64::INFINITY, link_2_kg: 5.0 });
    let refused = |result: Result<_, ExportError>| result.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(refused(bench(Format::Mjcf, &free, "current_a", "a")).contains("free masses"));
    let rod = PendulumRig { arm_m: 0.1, length_m: 0.5, mass_kg: 2.0, rod_mass_kg: 0.4 };
    let rod = model(&[], Bench::Pendulum(rod));
    assert!(refused(bench(Format::Mjcf, &rod, "current_a", "a")).contains("whose rod has no mass"));
    let locked = model(&[], Bench::Locked);
    assert!(refused(bench(Format::Mjcf, &locked, "current_a", "..")).contains("names no file"));
    let unknown = "collada".parse::<Format>().err().map(|e| e.to_string()).unwrap_or_default();
    assert!(unknown.contains("mjcf, urdf, isaaclab, sdf"), "{unknown}");
}

#[test]
fn a_leg_in_every_format_is_well_formed_and_says_what_it_lacks() {
    let scenario = Scenario::load("thor-drop", &[]).unwrap_or_else(|e| panic!("{e}"));
    for format in Format::ALL {
        let done = leg(format, &scenario, "leg").unwrap_or_else(|e| panic!("{e}"));
        if format == Format::IsaacLab {
            assert!(done.text.contains("ImplicitActuatorCfg") && done.beside[0].0 == "leg.urdf");
        } else {
            let parsed = roxmltree::Document::parse(&done.text).unwrap_or_else(|e| panic!("{format}: {e}"));
            let joints = parsed
                .descendants()
                .filter(|n| n.has_tag_name("joint") && n.attribute("name") == Some("knee"));
            assert_eq!(joints.count(), 1, "{format}");
        }
        assert!(done.notes.iter().any(|n| n.fate == Fate::Lost || n.fate == Fate::Approximate), "{format}");
    }
}
