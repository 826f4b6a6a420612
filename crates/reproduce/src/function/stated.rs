//! What is stated of actuators, materials and beams, and what closed forms make of it.

use sealegs_actuator::bench::PendulumRig;
use sealegs_actuator::response::Link;
use sealegs_actuator::spring::{BeamLaw, ClampSetting, EndLoadedBeam, Material, MomentLoadedBeam};

use super::{Call, Function};
use crate::ReproduceError;
use crate::setup::Setup;
use crate::thor::{STIFF_N_M, pendulum_link};

pub(super) const FUNCTIONS: [Function; 14] = [
    Function { name: "printed", usage: "row id: its printed value, in the row's unit", law: printed },
    Function { name: "actuator", usage: "thor or saffir, field: of the preset", law: actuator },
    Function { name: "material", usage: "name, field: of Table 3 and section 2-4-1", law: material },
    Function { name: "saffir_beam", usage: "pivot in mm, field", law: saffir_beam },
    Function {
        name: "saffir_stiffness",
        usage: "law, pivot in mm: N/m by eq 2-3 to 2-6",
        law: saffir_stiffness,
    },
    Function {
        name: "saffir_stress_pa",
        usage: "pivot in mm, force in N: greatest bending stress",
        law: saffir_stress,
    },
    Function {
        name: "saffir_safety",
        usage: "load or deflection, pivot in mm, force in N: factor",
        law: saffir_safety,
    },
    Function {
        name: "measured_law_ends_mm",
        usage: "length beyond which eq 2-6 is softer than the fixed-pinned model, mm",
        law: |_, _| Ok(measured_law_ends_mm()),
    },
    Function {
        name: "thor_design_stiffness",
        usage: "free length in m: EI/(h^2 l), N/m",
        law: thor_design_stiffness,
    },
    Function { name: "thor_beam", usage: "clamp setting, field", law: thor_beam },
    Function { name: "thor_loaded", usage: "clamp setting, force in N, field", law: thor_loaded },
    Function {
        name: "pendulum",
        usage: "field: what the bench's pendulum is at the actuator",
        law: pendulum,
    },
    Function {
        name: "softer",
        usage: "field: what makes THOR's beam as soft as the two printed slopes",
        law: softer,
    },
    Function { name: "fit", usage: "field: of eq 3-14 as printed, and what is extracted from it", law: fit },
];

fn printed(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    setup.printed(call.word(0)?)
}

fn actuator(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let spec = match call.word(0)? {
        "thor" => &setup.thor.spec,
        "saffir" => &setup.saffir,
        other => return Err(call.unknown("actuator", other)),
    };
    let c = spec.coefficients();
    let field = call.word(1)?;
    let value = match field {
        "ratio_m" => Some(spec.ratio()),
        "supply_v" => spec.motor.supply_v,
        "torque_constant_nm_a" => Some(spec.motor.torque_constant_nm_a),
        "peak_force_n" => spec.ratings.peak_force_n,
        "continuous_force_n" => spec.ratings.continuous_force_n,
        "sprung_mass_kg" => Some(spec.sprung_mass_kg),
        "total_mass_kg" => Some(c.total_mass()),
        "damping_n_s_m" => Some(c.damping),
        "force_constant_n_a" => Some(c.force_constant),
        _ => None,
    };
    value.ok_or_else(|| call.unknown("field", field))
}

fn material(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let name = call.word(0)?;
    let m = Material::named(name).ok_or_else(|| call.unknown("material", name))?;
    match call.word(1)? {
        "bending_merit" => Ok(m.bending_merit()),
        "yield_strength_pa" => Ok(m.yield_strength_pa),
        "youngs_modulus_pa" => Ok(m.youngs_modulus_pa),
        other => Err(call.unknown("field", other)),
    }
}

fn pivot(call: &Call<'_>, at: usize) -> Result<EndLoadedBeam, ReproduceError> {
    Ok(EndLoadedBeam::saffir(1e-3 * call.number(at)?))
}

fn saffir_beam(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let beam = pivot(call, 0)?;
    match call.word(1)? {
        "pivot_m" => Ok(beam.pivot_m),
        "total_length_m" => Ok(beam.total_length_m),
        "width_m" => Ok(beam.width_m),
        "thickness_m" => Ok(beam.thickness_m),
        "youngs_modulus_pa" => Ok(beam.material.youngs_modulus_pa),
        "yield_strength_pa" => Ok(beam.material.yield_strength_pa),
        "second_moment_m4" => Ok(beam.second_moment_m4()),
        "yield_force_n" => Ok(beam.yield_force_n()),
        "max_deflection_m" => Ok(beam.max_deflection_m()),
        "stiffness_n_m" => Ok(beam.stiffness_n_m()),
        other => Err(call.unknown("field", other)),
    }
}

fn saffir_stiffness(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let law = match call.word(0)? {
        "fixed" => BeamLaw::Fixed,
        "pinned-pinned" => BeamLaw::PinnedPinned,
        "fixed-pinned" => BeamLaw::FixedPinned,
        "measured" => BeamLaw::Measured,
        other => return Err(call.unknown("law", other)),
    };
    let beam = pivot(call, 1)?;
    Ok(beam.stiffness_by(law, beam.pivot_m))
}

fn saffir_stress(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(pivot(call, 0)?.stress_pa(call.number(1)?))
}

fn saffir_safety(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let (beam, force_n) = (pivot(call, 1)?, call.number(2)?);
    match call.word(0)? {
        "load" => Ok(beam.load_safety_factor(force_n)),
        "deflection" => Ok(beam.deflection_safety_factor(force_n)),
        other => Err(call.unknown("safety factor", other)),
    }
}

fn measured_law_ends_mm() -> f64 {
    let above = |mm: f64| {
        let beam = EndLoadedBeam::saffir(1e-3 * mm);
        beam.stiffness_by(BeamLaw::Measured, beam.pivot_m)
            > beam.stiffness_by(BeamLaw::FixedPinned, beam.pivot_m)
    };
    let (mut low, mut high) = (90.0, 125.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if above(middle) { low = middle } else { high = middle }
    }
    low
}

fn thor_design_stiffness(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(MomentLoadedBeam::thor(ClampSetting::Compliant).ideal_stiffness_n_m(call.number(0)?))
}

fn clamped(call: &Call<'_>) -> Result<MomentLoadedBeam, ReproduceError> {
    match call.word(0)? {
        "compliant" => Ok(MomentLoadedBeam::thor(ClampSetting::Compliant)),
        "stiff" => Ok(MomentLoadedBeam::thor(ClampSetting::Stiff)),
        "locked-out" => Ok(MomentLoadedBeam::thor(ClampSetting::LockedOut)),
        other => Err(call.unknown("clamp setting", other)),
    }
}

fn thor_beam(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let beam = clamped(call)?;
    match call.word(1)? {
        "stiffness_n_m" => Ok(beam.stiffness_n_m()),
        "bending_stiffness_n_m2" => Ok(beam.bending_stiffness_n_m2()),
        other => Err(call.unknown("field", other)),
    }
}

fn thor_loaded(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let (beam, force_n) = (clamped(call)?, call.number(1)?);
    match call.word(2)? {
        "safety" => Ok(beam.load_safety_factor(force_n)),
        "stress_pa" => Ok(beam.stress_pa(force_n)),
        "tip_angle_rad" => Ok(beam.tip_angle_rad(force_n)),
        other => Err(call.unknown("field", other)),
    }
}

fn softer(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let both = setup.softer.series_and_scale;
    let [series, extra, modulus] = setup.softer.single;
    match call.word(0)? {
        "series_n_m" => Ok(both.series_stiffness_n_m),
        "series_low_n_m" => Ok(both.series_quantiles_n_m[0]),
        "series_high_n_m" => Ok(both.series_quantiles_n_m[1]),
        "beam_scale" => Ok(both.beam_scale),
        "extra_length_m" => Ok(both.equivalent_extra_length_m),
        "lock_out" => Ok(both.lock_out_factor),
        "lock_out_low" => Ok(both.lock_out_quantiles[0]),
        "lock_out_high" => Ok(both.lock_out_quantiles[1]),
        "series_compliant" => Ok(series.from_compliant),
        "series_stiff" => Ok(series.from_stiff),
        "extra_compliant" => Ok(extra.from_compliant),
        "extra_stiff" => Ok(extra.from_stiff),
        "modulus_compliant" => Ok(modulus.from_compliant),
        "modulus_stiff" => Ok(modulus.from_stiff),
        other => Err(call.unknown("field", other)),
    }
}

fn fit(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let fit = &setup.fit;
    let extracted = fit.extract(STIFF_N_M, setup.thor.spec.sprung_mass_kg, setup.printed("E3-02")?);
    match call.word(0)? {
        "static_gain" => Ok(fit.dc_gain()),
        "static_gain_db" => Ok(20.0 * fit.dc_gain().log10()),
        "total_mass_kg" => Ok(extracted.total_mass_kg),
        "damping_n_s_m" => Ok(extracted.damping_n_s_m),
        "rotor_inertia_kg_m2" => Ok(extracted.rotor_inertia_kg_m2),
        "rotor_damping_nm_s" => Ok(extracted.rotor_damping_nm_s),
        field @ ("peak_hz" | "peak_db") => super::response::peak_of_fit(fit, field == "peak_hz"),
        other => Err(call.unknown("field", other)),
    }
}

fn pendulum(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let Link::Mass { mass_kg, stiffness_n_m } = pendulum_link(&PendulumRig::default()) else {
        return Err(ReproduceError::missing("a pendulum is a mass"));
    };
    match call.word(0)? {
        "mass_kg" => Ok(mass_kg),
        "gravity_stiffness_n_m" => Ok(stiffness_n_m),
        other => Err(call.unknown("field", other)),
    }
}
