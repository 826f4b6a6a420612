//! Chapter 3: the extracted parameters and the high-impedance bench.

use sealegs::actuator::response::{
    Feature, ForceResponse, HALF_POWER_DB, SecondOrderFit, Transfer, crossings, db, peaks,
};

use super::ledger::Ledger;
use super::thor::{SOFT_N_M, STIFF_N_M, Thor};

const WIDE_HZ: [f64; 2] = [0.05, 1000.0];

/// Enters parameters, natural frequencies and the locked bench.
///
/// # Errors
///
/// If a printed value is missing.
pub fn enter(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    parameters(ledger, thor)?;
    locked(ledger, thor)?;
    excitation(ledger, thor);
    Ok(())
}

fn parameters(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    let r = thor.spec.ratio();
    ledger.put("E3-02", r, "l/(2 pi N_p) with 2 mm and 3:1");
    let fit = SecondOrderFit {
        numerator_1_s2: ledger.printed("E3-14a")?,
        damping_1_s: ledger.printed("E3-14b")?,
        constant_1_s2: ledger.printed("E3-14c")?,
    };
    ledger.remark("E3-14a", "a fit of the measurement: printed, not derivable");
    ledger.remark("E3-14b", "a fit of the measurement: printed, not derivable");
    ledger.put("E3-14c", fit.numerator_1_s2, format!(
        "the model form k/m_T over s^2 + (b/m_T) s + k/m_T makes it equal to the numerator; the printed fit has a static gain of {:.4} ({:.2} dB)",
        fit.dc_gain(),
        20.0 * fit.dc_gain().log10()
    ));
    let (m_s, r_printed) = (thor.spec.sprung_mass_kg, ledger.printed("E3-02")?);
    let extracted = fit.extract(STIFF_N_M, m_s, r_printed);
    ledger.put(
        "T5-01",
        extracted.total_mass_kg,
        format!(
            "arithmetic mean of 655000/2166 = {:.2} and 655000/2279 = {:.2}: the rule behind the print",
            STIFF_N_M / fit.numerator_1_s2,
            STIFF_N_M / fit.constant_1_s2
        ),
    );
    ledger.put("T5-02", extracted.damping_n_s_m, "39.53 m_T");
    ledger.put("T5-03", extracted.rotor_inertia_kg_m2, "(m_T - m_s) r^2 with the printed r");
    ledger.put("T5-04", extracted.rotor_damping_nm_s, "b r^2 with the printed r");
    let c = thor.smh(STIFF_N_M);
    let static_gain = ForceResponse::locked(&c).sprung.at_hz(1e-6).norm() / r;
    ledger.put("E3-09", static_gain, "F1 per torque at rest is 1/r, so that the numerators are k/r and (m_s s^2 + k)/r; eq 3-11 and 3-12 are right");
    ledger.put(
        "E3-14d",
        c.damping / c.total_mass(),
        "b/m_T is what was fitted; the printed b m_s/m_k is another number (and unit)",
    );
    ledger.put("E4-05", extracted.rotor_damping_nm_s, "it multiplies the rotor's speed and is divided by r^2: the rotational b_r, not the 11658 N s/m of Table 6");
    Ok(())
}

/// The single resonance of a response, Hz.
fn resonance(transfer: &Transfer) -> f64 {
    transfer.resonances().first().map_or(f64::NAN, |m| m.frequency_hz)
}

fn locked(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    let stiff = thor.smh(STIFF_N_M);
    let unlumped = ForceResponse::locked(&stiff);
    let lumped = ForceResponse::locked(&thor.lumped(STIFF_N_M));
    let soft = ForceResponse::locked(&thor.smh(SOFT_N_M));
    let printed = ledger.printed("R3-01")?;
    let f_lumped = resonance(&lumped.ratio);
    ledger.put("R3-01", f_lumped, format!(
        "sqrt(k/m_T)/2 pi from Table 5; {printed} Hz would be k = {:.0} kN/m, or a reading off the figure",
        1e-3 * STIFF_N_M * (printed / f_lumped).powi(2)
    ));
    ledger.put(
        "R3-02",
        resonance(&unlumped.ratio),
        format!("sqrt(k/m_s)/2 pi; soft setting {:.1} Hz", resonance(&soft.ratio)),
    );
    ledger.put("R3-03", stiff.total_mass() / stiff.sprung_mass, "294.9 over 0.6461 kg; the text says about");
    let poles = unlumped.sprung.resonances();
    let damping = poles.first().map_or(f64::NAN, |m| m.damping_ratio);
    ledger.put("R3-04", damping, "b/(2 sqrt(k m_T)), from the poles of the closed form");
    let peak: Option<Feature> = peaks(|f| unlumped.sprung.at_hz(f), WIDE_HZ).first().copied();
    let peak = peak.unwrap_or(Feature { frequency_hz: f64::NAN, gain_db: f64::NAN });
    let printed_fit = |f: f64| {
        let s = num_complex::Complex64::new(0.0, std::f64::consts::TAU * f);
        let fit = SecondOrderFit::PRINTED;
        fit.numerator_1_s2 / (s * s + fit.damping_1_s * s + fit.constant_1_s2)
    };
    let raw = peaks(printed_fit, WIDE_HZ);
    let raw =
        raw.first().map(|p| format!("{:+.2} dB at {:.2} Hz", p.gain_db, p.frequency_hz)).unwrap_or_default();
    ledger.put(
        "S3-01",
        peak.frequency_hz,
        format!("closed form, both models; the printed fit itself peaks {raw}"),
    );
    ledger.put("S3-02", peak.gain_db, "closed form, both models");
    let edge = crossings(|f| unlumped.sprung.at_hz(f), HALF_POWER_DB, WIDE_HZ);
    ledger.put("S3-03", edge.first().copied().unwrap_or(f64::NAN), "half power");
    ledger.put("S3-04", resonance(&unlumped.sprung), "sqrt(k/m_T)/2 pi; at the stiff setting");
    let notch = |t: &Transfer| t.anti_resonances().first().map_or(f64::NAN, |m| m.frequency_hz);
    ledger.put("S3-05", notch(&unlumped.unsprung), "zero of m_s s^2 + k");
    ledger.put("S3-06", db(unlumped.unsprung.at_hz(1e5)), "m_s/m_T");
    ledger.put(
        "S3-07",
        db(unlumped.sprung.at_hz(60.0)),
        format!(
            "and {:.1} dB at 20 Hz, {:.1} dB at 100 Hz",
            db(unlumped.sprung.at_hz(20.0)),
            db(unlumped.sprung.at_hz(100.0))
        ),
    );
    ledger.put(
        "S3-08",
        notch(&lumped.unsprung),
        "the lumped model's F2/Fm is about 0 dB but for an exact zero here",
    );
    ledger.put(
        "R3-17",
        db(unlumped.ratio.at_hz(60.0)),
        format!(
            "{:+.2} dB at 15 Hz; soft setting {:+.2} dB at 60 Hz",
            db(unlumped.ratio.at_hz(15.0)),
            db(soft.ratio.at_hz(60.0))
        ),
    );
    Ok(())
}

fn excitation(ledger: &mut Ledger<'_>, thor: &Thor) {
    let per_ampere = thor.smh(STIFF_N_M).force_constant;
    ledger.put("R3-05", 2.0 * per_ampere, "2 A by K_tau/r");
    ledger.put("R3-06", per_ampere, "1 A by K_tau/r");
    ledger.put("R3-07", 3.0 * per_ampere, format!("3 A by K_tau/r; 841 N is {:.2} A", 841.0 / per_ampere));
    ledger.put("R3-08", 65_536.0 / 400.0, "2^16 samples at 400 Hz (inference)");
    ledger.put("R3-09", 400.0 / 2.0, "half the sampling frequency");
}
