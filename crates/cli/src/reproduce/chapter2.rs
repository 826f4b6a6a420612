//! Chapters 1 and 2: counts, ratings, materials, the SAFFiR cantilever and the THOR moment-loaded beam.

use anyhow::Context;
use sealegs::actuator::spring::{
    BeamLaw, ClampSetting, EndLoadedBeam, Material, MomentLoadedBeam, SofterThanDesigned, Spring,
};
use sealegs::actuator::{ActuatorSpec, Coefficients};

use super::ledger::Ledger;

/// Newton per pound-force.
const LBF_N: f64 = 4.448_221_615;

/// Enters everything of chapters 1 and 2.
///
/// # Errors
///
/// If a preset or a printed value is missing.
pub fn enter(ledger: &mut Ledger<'_>) -> anyhow::Result<()> {
    let thor = ActuatorSpec::preset("thor-linear")?;
    let saffir = ActuatorSpec::preset("saffir-linear")?;
    counts(ledger);
    ratings(ledger, &thor, &saffir)?;
    materials(ledger)?;
    beam_formulas(ledger)?;
    saffir_range(ledger);
    saffir_safety(ledger);
    thor_beam(ledger, &thor)?;
    measured_pair(ledger)
}

fn counts(ledger: &mut Ledger<'_>) {
    let saffir_leg = [3, 1, 2];
    ledger.put("C1-01", 2.0 * f64::from(saffir_leg.iter().sum::<i32>()), "2 x (hip 3 + knee 1 + ankle 2)");
    // Legs, arms, waist, neck, hands (section 1-2), limbs twice.
    let thor = 2 * 6 + 2 * 7 + 2 + 2 + 2 * 2;
    ledger.put(
        "C1-02",
        f64::from(thor),
        "2 legs of 6, 2 arms of 7, waist 2, neck 2, 2 hands of 2: the sum needs each limb twice",
    );
    let linear = 2 * 6;
    let hoekens = 2 * 2;
    ledger.put(
        "C1-05",
        f64::from(linear - hoekens),
        "12 linear actuators less hip pitch and knee of both legs",
    );
    let walkers = ["M2V2", "Flame and Tulip", "COMAN", "DLR biped", "Valkyrie", "SAFFiR", "THOR"];
    ledger.put("C1-06", walkers.len() as f64, format!("counted in Table 1: {}", walkers.join(", ")));
}

fn ratings(ledger: &mut Ledger<'_>, thor: &ActuatorSpec, saffir: &ActuatorSpec) -> anyhow::Result<()> {
    // Without losses the motor idles at supply over torque constant: an upper bound of the rated speed.
    let idle = |spec: &ActuatorSpec| {
        let supply = spec.motor.supply_v.context("the preset states its supply")?;
        anyhow::Ok(supply / spec.motor.torque_constant_nm_a * spec.ratio())
    };
    let (v_saffir, v_thor) = (idle(saffir)?, idle(thor)?);
    let share = |printed: f64, ideal: f64| 100.0 * printed / ideal;
    let saffir_printed = ledger.printed("T2-03")?;
    ledger.note_value("T2-03", v_saffir, format!(
        "ideal no-load speed at the supply with THOR's torque constant; the rating is {:.0} % of it, which is plausible",
        share(saffir_printed, v_saffir)
    ));
    let thor_printed = ledger.printed("T2-08")?;
    ledger.note_value(
        "T2-08",
        v_thor,
        format!(
            "ideal no-load speed at the supply; the rating is {:.0} % of it, which is plausible",
            share(thor_printed, v_thor)
        ),
    );
    ledger.put("T2-06", saffir.ratio(), "lead / (2 pi N_p), eq 3-2");
    let c = thor.coefficients();
    let amperes = |n: f64| n / c.force_constant;
    let continuous = ledger.printed("T2-09")?;
    ledger.remark("T2-09", format!("a rating; corresponds to {:.2} A", amperes(continuous)));
    let peak = ledger.printed("T2-10")?;
    ledger.put("T2-10", 500.0 * LBF_N, format!(
        "500 lbf; {:.2} A by eq 4-48, while the 10 A of chapter 4 make {:.0} N, {:.0} % above this rating",
        amperes(peak),
        10.0 * c.force_constant,
        100.0 * (10.0 * c.force_constant / peak - 1.0)
    ));
    let peaks = (thor.ratings.peak_force_n, saffir.ratings.peak_force_n);
    let (Some(thor_peak), Some(saffir_peak)) = peaks else {
        anyhow::bail!("the presets state their peak forces")
    };
    ledger.put("T2-11", thor_peak / saffir_peak, "2225 over 1000 N; the text says doubled");
    let rated = thor.ratings.continuous_force_n.context("the preset states its continuous force")?;
    ledger.put("T2-12", 100.0 * 200.0 / rated, "200 over 685 N");
    Ok(())
}

fn materials(ledger: &mut Ledger<'_>) -> anyhow::Result<()> {
    for (id, name) in [
        ("T3-01", "steel-1010"),
        ("T3-02", "steel-4140"),
        ("T3-03", "aluminium-7075"),
        ("T3-04", "titanium-13"),
        ("T3-05", "hdpe"),
        ("T3-06", "e-glass"),
        ("T3-07", "titanium-6al-4v"),
    ] {
        let m = Material::named(name).with_context(|| format!("material {name}"))?;
        let why = format!("{:.0} MPa over {:.1} GPa", 1e-6 * m.yield_strength_pa, 1e-9 * m.youngs_modulus_pa);
        ledger.put(id, m.bending_merit(), why);
    }
    Ok(())
}

fn beam_formulas(ledger: &mut Ledger<'_>) -> anyhow::Result<()> {
    let beam = EndLoadedBeam::saffir(0.088);
    let (a, l) = (beam.pivot_m, beam.total_length_m);
    let (e, i) = (beam.material.youngs_modulus_pa, beam.second_moment_m4());
    let ei = e * i;
    // Eq 2-1 from the beam's own stiffness and yield force instead of the printed formula.
    let at_yield = beam.yield_force_n() / beam.stiffness_by(BeamLaw::Fixed, a);
    let merit = beam.material.yield_strength_pa / e * a * a / beam.thickness_m;
    ledger.put("E2-01", at_yield / merit, "yield force over fixed-end stiffness, in units of (S_y/E) L^2/h");
    let stress = beam.stress_pa(1.0) * beam.width_m * beam.thickness_m.powi(2) / a;
    ledger.put("E2-02", stress, "stress per force in units of L/(b h^2)");
    // Superposition: the overhang on a rigid pivot, plus the rotation of the span behind it.
    let overhang = a.powi(3) / (3.0 * ei);
    let span = l - a;
    for (id, law, behind, what) in [
        ("E2-03", BeamLaw::Fixed, 0.0, "a^3/(3EI)"),
        (
            "E2-04",
            BeamLaw::PinnedPinned,
            a * a * span / (3.0 * ei),
            "a^3/(3EI) plus a times the slope a s/(3EI) of a pinned span s = l - a",
        ),
        (
            "E2-05",
            BeamLaw::FixedPinned,
            a * a * span / (4.0 * ei),
            "a^3/(3EI) plus a times the slope a s/(4EI) of a span fixed at its far end",
        ),
    ] {
        ledger.put(id, beam.stiffness_by(law, a) * (overhang + behind), what);
    }
    let law = |mm: f64| 1e-3 * EndLoadedBeam::saffir(1e-3 * mm).stiffness_by(BeamLaw::Measured, 1e-3 * mm);
    ledger.put("E2-06", law(70.0), "the 430 kN/m of section 2-4-3 fix the unit: N/m with l in mm");
    ledger.put("E2-06a", law(70.0), "eq 2-6 at 70 mm");
    ledger.put("E2-06b", law(65.0), "eq 2-6 at the short end");
    ledger.put("E2-06c", law(110.0), "eq 2-6 at the long end");
    let between = |mm: f64| law(mm) - 1e-3 * beam.stiffness_by(BeamLaw::FixedPinned, 1e-3 * mm);
    let (mut low, mut high) = (90.0, 125.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if between(middle) > 0.0 { low = middle } else { high = middle }
    }
    ledger.put(
        "E2-06d",
        low,
        "true over the tested 71 to 108 mm; beyond this length the fit is softer than fixed-pinned",
    );
    for (key, which) in
        [("fixed", BeamLaw::Fixed), ("pinpin", BeamLaw::PinnedPinned), ("fixpin", BeamLaw::FixedPinned)]
    {
        for mm in [65.0, 70.0, 110.0] {
            let k = 1e-3 * beam.stiffness_by(which, 1e-3 * mm);
            ledger.put(&format!("E2-k-{key}-{mm:.0}"), k, "eq 2-3 to 2-5 with E = 115 GPa");
        }
    }
    Ok(())
}

fn saffir_range(ledger: &mut Ledger<'_>) {
    let beam = EndLoadedBeam::saffir(0.110);
    let fixed = |mm: f64| 1e-3 * beam.stiffness_by(BeamLaw::Fixed, 1e-3 * mm);
    let modulus = |kn_m: f64, mm: f64| 1e-9 * beam.material.youngs_modulus_pa * kn_m / fixed(mm);
    let (low_e, high_e) = (modulus(145.0, 108.0), modulus(512.0, 71.0));
    ledger.put(
        "R2-01",
        fixed(110.0),
        format!(
            "fixed model at 110 mm; 145 is that model at the tested 108 mm ({:.1}, with E = 115 GPa)",
            fixed(108.0)
        ),
    );
    ledger.put(
        "R2-02",
        fixed(65.0),
        format!(
            "fixed model at 65 mm; 512 is that model at the tested 71 mm ({:.1}, with E = 115 GPa)",
            fixed(71.0)
        ),
    );
    ledger.put(
        "S2-02",
        high_e,
        "inference: the range is that of the tested 71 to 108 mm, with a slightly lower modulus",
    );
    ledger.put(
        "S2-03",
        low_e,
        "the other end of the range asks for the same modulus: both ends have one explanation",
    );
}

fn saffir_safety(ledger: &mut Ledger<'_>) {
    let beam = EndLoadedBeam::saffir(0.110);
    ledger.put(
        "R2-03",
        beam.load_safety_factor(1000.0),
        format!("828 over {:.1} MPa", 1e-6 * beam.stress_pa(1000.0)),
    );
    let k_wanted = 1.46 * 1000.0 / beam.max_deflection_m();
    ledger.put(
        "R2-04",
        beam.deflection_safety_factor(1000.0),
        format!(
            "in a linear clamped beam it equals the load factor; 1.46 would need {:.1} kN/m instead of {:.1}",
            1e-3 * k_wanted,
            1e-3 * beam.stiffness_by(BeamLaw::Fixed, 0.110)
        ),
    );
    let deflection = |law| 1.0 / beam.stiffness_by(law, beam.pivot_m);
    let largest = [BeamLaw::Fixed, BeamLaw::PinnedPinned, BeamLaw::FixedPinned]
        .map(deflection)
        .into_iter()
        .fold(0.0, f64::max);
    ledger.put("R2-05", deflection(BeamLaw::Fixed) / largest, "the moment at the pivot is F a in all three, and the fixed end deflects least: the least conservative");
    let travel = 2.0 * 4.0 * 7f64.to_radians().tan();
    ledger.put("R2-06", travel, format!("2 x 4 mm x tan 7 deg; {:.2} mm a side", 0.5 * travel));
    ledger.put("R2-07", 0.0005 * 25.4, "0.0005 in");
    ledger.put("R2-08", 155.0 * LBF_N, "155 lbf");
}

/// `b/k`: the delay of the plant at low frequency, ms.
fn delay_ms(c: &Coefficients) -> f64 {
    1e3 * c.damping / c.stiffness
}

fn thor_beam(ledger: &mut Ledger<'_>, thor: &ActuatorSpec) -> anyhow::Result<()> {
    let soft_beam = MomentLoadedBeam::thor(ClampSetting::Compliant);
    let stiff_beam = MomentLoadedBeam::thor(ClampSetting::Stiff);
    let ideal = |beam: &MomentLoadedBeam, l: f64| 1e-3 * beam.ideal_stiffness_n_m(l);
    let h = |kn_m: f64, l: f64| 1e3 * (soft_beam.bending_stiffness_n_m2() / (1e3 * kn_m * l)).sqrt();
    let (soft, stiff) = (ledger.printed("H2-01")?, ledger.printed("H2-02")?);
    ledger.put("H2-01", ideal(&soft_beam, 0.110), "EI/(h^2 l) of the preset, h = 33.0 mm");
    ledger.put("H2-02", ideal(&stiff_beam, 0.055), "the same h: a pure 1/l");
    ledger.put(
        "H2-03",
        0.5 * (h(soft, 0.110) + h(stiff, 0.055)),
        "sqrt(EI/(k l)); both settings give the same",
    );
    ledger.put(
        "H2-04",
        soft_beam.load_safety_factor(2225.0),
        format!(
            "{:.1} MPa at 2225 N; tip angle {:.1} deg at 110 mm, {:.1} deg at 55 mm",
            1e-6 * soft_beam.stress_pa(2225.0),
            soft_beam.tip_angle_rad(2225.0).to_degrees(),
            stiff_beam.tip_angle_rad(2225.0).to_degrees()
        ),
    );
    let measured =
        |mm: f64| 1e-3 * EndLoadedBeam::saffir(1e-3 * mm).stiffness_by(BeamLaw::Measured, 1e-3 * mm);
    let printed_top = ledger.printed("R2-02")?;
    ledger.put(
        "H2-05",
        2.0 * printed_top,
        format!(
            "2 x 512 (2 x {:.0} by the measured law); 760 is twice the compliant setting",
            measured(65.0)
        ),
    );
    ledger.put("H2-06", measured(70.0) - 50.0, "430 by eq 2-6, less 50");

    // What open-loop plants add at the ankle: a statement of the text, with the scale beside it.
    let c = thor.coefficients();
    let saffir = ActuatorSpec::preset("saffir-linear")?;
    let at = |kn_m: f64| Coefficients { stiffness: 1e3 * kn_m, ..c };
    let saffir_at = |mm: f64| {
        let moved = saffir.with_spring(Spring::EndLoadedBeam(EndLoadedBeam::saffir(1e-3 * mm)));
        delay_ms(&moved.coefficients())
    };
    ledger.remark("R2-09", format!(
        "measured in closed loop; the plant alone delays by b/k: {:.1} ms (THOR stiff), {:.1} ms (soft), SAFFiR about {:.1} ms at 70 mm and {:.1} at 65",
        delay_ms(&at(655.0)),
        delay_ms(&at(372.0)),
        saffir_at(70.0),
        saffir_at(65.0)
    ));
    Ok(())
}

fn measured_pair(ledger: &mut Ledger<'_>) -> anyhow::Result<()> {
    let (soft_slope, stiff_slope) = (ledger.printed("H2-07")?, ledger.printed("H2-08")?);
    let thor = |setting| MomentLoadedBeam::thor(setting).stiffness_n_m();
    let (soft, stiff) = (thor(ClampSetting::Compliant), thor(ClampSetting::Stiff));
    ledger.put("H2-07", soft, "measured; here from the preset's beam scale and series stiffness");
    ledger.put("H2-08", stiff, "measured; here from the preset's beam scale and series stiffness");
    let beam = MomentLoadedBeam::thor(ClampSetting::Compliant);
    let causes = SofterThanDesigned::new(&beam, soft_slope, stiff_slope);
    let both = causes.series_and_scale;
    let alone = |length| 1e-3 * both.beam_scale * beam.ideal_stiffness_n_m(length);
    ledger.put("H2-09", 1e-3 * both.series_stiffness_n_m, format!(
        "1/k = 1/k_beam + 1/k_s with k_beam ~ 1/l through both slopes: beams of {:.1} and {:.1} kN/m; 5 to 95 % {:.0} to {:.0} for slope errors of 1 %",
        alone(0.110),
        alone(0.055),
        1e-3 * both.series_quantiles_n_m[0],
        1e-3 * both.series_quantiles_n_m[1]
    ));
    ledger.put("S2-01", both.beam_scale, "the softer beam over its design stiffness of 380 kN/m");
    ledger.put("H2-10", both.lock_out_factor, format!(
        "predicted from the two slopes alone, 5 to 95 % {:.1} to {:.1} (the preset: {:.2}); relative to the soft setting {:.2}",
        both.lock_out_quantiles[0],
        both.lock_out_quantiles[1],
        thor(ClampSetting::LockedOut) / stiff,
        both.series_stiffness_n_m / soft_slope
    ));
    ledger.put("H2-11", 1e3 * both.equivalent_extra_length_m, "clamp offset and scale fit as well, but leave the lock-out infinitely stiff: excluded by section 5-2");
    let [series, extra, modulus] = causes.single;
    ledger.put("H2-12", modulus.from_compliant, format!(
        "modulus alone: x{:.3} soft against x{:.3} stiff; series alone: {:.1} against {:.2} MN/m; offset alone: {:.1} against {:.1} mm: each contradicts itself",
        modulus.from_compliant,
        modulus.from_stiff,
        1e-6 * series.from_compliant,
        1e-6 * series.from_stiff,
        1e3 * extra.from_compliant,
        1e3 * extra.from_stiff
    ));
    ledger.put("T5-07", stiff_slope, "eq 2-10");
    Ok(())
}
