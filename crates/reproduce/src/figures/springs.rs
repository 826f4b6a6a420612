//! Figures of chapter 2: the beams.

use sealegs_actuator::spring::{BeamLaw, ClampSetting, EndLoadedBeam, MomentLoadedBeam};
use sealegs_recorder::chart::{Axis, Chart, Dash, Hue, Marker};

use super::{Figure, linear};

/// Pivot settings that were tested, mm (section 2-4-2).
const TESTED_MM: [f64; 5] = [71.0, 80.0, 88.0, 98.0, 108.0];
/// Loads of the SAFFiR tests, N, of either sign.
const SAFFIR_LOADS_N: [f64; 5] = [93.0, 187.0, 280.0, 458.0, 687.0];
/// Loads of the THOR tests, N, of either sign.
const THOR_LOADS_N: [f64; 11] =
    [51.0, 104.0, 155.0, 207.0, 255.0, 259.0, 511.0, 767.0, 1023.0, 1278.0, 1543.0];

const MARKERS: [Marker; 5] =
    [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Circle];
const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted];

/// The loads of a test and their negatives, ascending.
fn both_signs(loads: &[f64]) -> Vec<f64> {
    let mut all: Vec<f64> = loads.iter().flat_map(|f| [*f, -*f]).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Deflection in mm and load in N at every load of a test, for a stiffness in N/m.
fn points(loads: &[f64], stiffness: f64) -> Vec<(f64, f64)> {
    both_signs(loads).into_iter().map(|f| (1e3 * f / stiffness, f)).collect()
}

/// Load against deflection of the SAFFiR beam.
pub fn figure_2_12() -> Figure {
    let mut chart =
        Chart::new("SAFFiR: load and deflection", Axis::new("Deflection", "mm"), Axis::new("Load", "N"));
    for (i, mm) in TESTED_MM.into_iter().enumerate() {
        let k = EndLoadedBeam::saffir(1e-3 * mm).stiffness_by(BeamLaw::Measured, 1e-3 * mm);
        let label = format!("{mm:.0} mm: {:.0} kN/m", 1e-3 * k);
        chart = chart.marked(&label, Hue::SERIES[i], DASHES[i % 4], MARKERS[i], points(&SAFFIR_LOADS_N, k));
    }
    Figure {
        number: "2-12",
        title: "Load against deflection of the SAFFiR beam at the five tested settings",
        caption: "Lines by the measured law (eq 2-6); marks at the loads that were applied. The measured points are not printed as numbers, so only the law can be shown.".to_owned(),
        charts: vec![chart.tall(420.0)],
    }
}

/// Stiffness of the SAFFiR beam against pivot position.
pub fn figure_2_13() -> Figure {
    let beam = EndLoadedBeam::saffir(0.088);
    let grid = linear(60.0, 115.0, 111);
    let line =
        |law| grid.iter().map(|mm| (*mm, 1e-3 * beam.stiffness_by(law, 1e-3 * mm))).collect::<Vec<_>>();
    let tested = TESTED_MM.map(|mm| (mm, 1e-3 * beam.stiffness_by(BeamLaw::Measured, 1e-3 * mm)));
    let chart = Chart::new(
        "SAFFiR: stiffness and pivot",
        Axis::new("Pivot to actuator", "mm"),
        Axis::new("Stiffness", "kN/m").range(0.0, 800.0),
    )
    .line("fixed (2-3)", Hue::Blue, Dash::Solid, line(BeamLaw::Fixed))
    .line("fixed-pinned (2-5)", Hue::Green, Dash::Dashed, line(BeamLaw::FixedPinned))
    .line("pinned-pinned (2-4)", Hue::Purple, Dash::Dotted, line(BeamLaw::PinnedPinned))
    .line("measured law (2-6)", Hue::Ink, Dash::Solid, line(BeamLaw::Measured))
    .scatter("tested settings", Hue::Ink, Marker::Circle, tested.to_vec())
    .note((70.0, 430.0), "printed 430", Marker::Diamond, Hue::Vermillion)
    .note((65.0, 512.0), "printed 512", Marker::Square, Hue::Vermillion)
    .note((110.0, 145.0), "printed 145", Marker::Square, Hue::Vermillion);
    Figure {
        number: "2-13",
        title: "Stiffness of the SAFFiR beam against pivot position, four models",
        caption: "The printed range of 145 to 512 kN/m for 65 to 110 mm lies on none of the models at these ends; the fixed model gives it at the tested 108 and 71 mm with a modulus of 113 GPa.".to_owned(),
        charts: vec![chart.tall(420.0)],
    }
}

/// Stiffness of the moment-loaded beam against length.
pub fn figure_2_18() -> Figure {
    let beam = MomentLoadedBeam::thor(ClampSetting::Compliant);
    let grid = linear(40.0, 130.0, 91);
    let ideal = grid.iter().map(|mm| (*mm, 1e-3 * beam.ideal_stiffness_n_m(1e-3 * mm))).collect();
    let real = grid
        .iter()
        .map(|mm| (*mm, 1e-3 * MomentLoadedBeam::thor(ClampSetting::Length(1e-3 * mm)).stiffness_n_m()))
        .collect();
    let chart = Chart::new(
        "THOR: stiffness and free length",
        Axis::new("Free length", "mm"),
        Axis::new("Stiffness", "kN/m").range(0.0, 1200.0),
    )
    .line("ideal, EI/(h² l)", Hue::Blue, Dash::Solid, ideal)
    .line("beam x 1.13 with 2771 kN/m in series", Hue::Vermillion, Dash::Dashed, real)
    .note((110.0, 380.0), "design 380", Marker::Diamond, Hue::Blue)
    .note((55.0, 760.0), "design 760", Marker::Diamond, Hue::Blue)
    .note((110.0, 371.643), "measured 372", Marker::Square, Hue::Ink)
    .note((55.0, 655.399), "measured 655", Marker::Square, Hue::Ink);
    Figure {
        number: "2-18",
        title: "Stiffness of the moment-loaded THOR beam against its free length",
        caption: "The design values define the lever arm of 33.0 mm; the measured ones need a compliance in series (see the findings).".to_owned(),
        charts: vec![chart.tall(400.0)],
    }
}

/// Load against displacement of the THOR actuator.
pub fn figure_2_19() -> Figure {
    let mut chart =
        Chart::new("THOR: load and displacement", Axis::new("Displacement", "mm"), Axis::new("Load", "N"));
    for (i, (name, setting, design)) in
        [("110 mm", ClampSetting::Compliant, 380e3), ("55 mm", ClampSetting::Stiff, 760e3)]
            .into_iter()
            .enumerate()
    {
        let k = MomentLoadedBeam::thor(setting).stiffness_n_m();
        let label = format!("{name}: {:.1} kN/m", 1e-3 * k);
        chart = chart.marked(&label, Hue::SERIES[i], Dash::Solid, MARKERS[i], points(&THOR_LOADS_N, k)).line(
            &format!("{name}: design {:.0}", 1e-3 * design),
            Hue::SERIES[i],
            Dash::Dotted,
            points(&[1543.0], design),
        );
    }
    Figure {
        number: "2-19",
        title: "Load against displacement of the THOR actuator at both settings",
        caption: "Lines of the model with a series stiffness of 2771 kN/m, whose slopes are those of eq 2-9 and 2-10; marks at the loads that were applied.".to_owned(),
        charts: vec![chart.tall(420.0)],
    }
}

/// Stiffness settings of both designs.
pub fn figure_2_20() -> Figure {
    let law = |mm: f64| 1e-3 * EndLoadedBeam::saffir(1e-3 * mm).stiffness_by(BeamLaw::Measured, 1e-3 * mm);
    let saffir = linear(65.0, 110.0, 46).into_iter().map(|mm| (mm, law(mm))).collect();
    let thor = |setting| 1e-3 * MomentLoadedBeam::thor(setting).stiffness_n_m();
    let settings = vec![(55.0, thor(ClampSetting::Stiff)), (110.0, thor(ClampSetting::Compliant))];
    let chart = Chart::new(
        "Available stiffness",
        Axis::new("Beam length", "mm").range(45.0, 120.0),
        Axis::new("Stiffness", "kN/m").range(0.0, 800.0),
    )
    .line("SAFFiR, any length", Hue::Blue, Dash::Solid, saffir)
    .scatter("THOR, two settings", Hue::Vermillion, Marker::Square, settings)
    .horizontal(145.0, "SAFFiR range as printed, 145")
    .horizontal(512.0, "SAFFiR range as printed, 512");
    Figure {
        number: "2-20",
        title: "Stiffness settings that the two designs offer",
        caption: format!(
            "SAFFiR by its measured law: {:.0} to {:.0} kN/m over its 110 to 65 mm. THOR locked out: {:.0} kN/m (predicted; off this chart).",
            law(110.0),
            law(65.0),
            thor(ClampSetting::LockedOut)
        ),
        charts: vec![chart],
    }
}
