//! What one run of a campaign has of its own: its rig, where it begins, its servo's gain.

use super::{Bench, Start, start_of};
use crate::ActuatorSpec;
use sealegs_model::Record;

/// A run's own rig, start and gain.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSetup {
    /// The name of its record.
    pub record: String,
    /// The bench with the run's own mass and length.
    pub bench: Bench,
    /// Position (m, or rad of a rotary drive) and speed of the output at its first row; used of drives without a spring.
    pub start: (f64, f64),
    /// The rows that it was taken from, where they tell it only roughly: the model's motion then tells more.
    pub first_rows: Option<FirstRows>,
    /// Factor of the servo's proportional gain.
    pub servo_gain: f64,
}

/// The first rows of a run that begins in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstRows {
    /// The output column that shows the position.
    pub channel: String,
    /// Position (m, or rad of a rotary drive) per unit of it.
    pub scale: f64,
    /// Where it begins, in the column's unit.
    pub start: Start,
}

impl RunSetup {
    /// A run on a bench whose start is taken from its record.
    ///
    /// The position is the first output column that shows one, see [`start_of`]; where there is none the speed is the
    /// speed column's and the position zero.
    #[must_use]
    pub fn of_record(record: &Record, spec: &ActuatorSpec, bench: Bench, servo_gain: f64) -> Self {
        let arm = bench.arm_m();
        let position = [("position_m", 1.0), ("joint_angle_rad", arm), ("motor_angle_rad", spec.ratio())];
        let speed = [("speed_m_s", 1.0), ("speed_rad_s", arm)];
        let first_rows_of = |(channel, scale): &(&str, f64)| {
            let start = start_of(&record.time_s, record.output(channel)?, record.cut);
            Some(FirstRows { channel: (*channel).to_owned(), scale: *scale, start })
        };
        let of_position = position.iter().find_map(first_rows_of);
        let start = match &of_position {
            Some(FirstRows { scale, start, .. }) => (scale * start.value, scale * start.slope),
            None => {
                let of_speed = speed.iter().find_map(first_rows_of);
                (0.0, of_speed.map_or(0.0, |of| of.scale * of.start.value))
            }
        };
        let first_rows = of_position.filter(|of| of.start.slope_std > 0.0);
        Self { record: record.name.clone(), bench, start, first_rows, servo_gain }
    }
}

#[cfg(test)]
mod tests {
    use super::super::start::tests::in_motion;
    use super::*;
    use sealegs_model::{InputHold, Signal};

    #[test]
    fn analytic_a_start_in_motion_is_found() {
        let (time_s, values) = in_motion();
        let mut record = Record {
            cut: false,
            name: "run".to_owned(),
            time_s,
            hold: InputHold::ZeroOrder,
            inputs: Vec::new(),
            outputs: vec![Signal { channel: "position_m".to_owned(), values }],
        };
        let spec = ActuatorSpec::preset("rigid-linear").expect("preset");
        let start =
            |record: &Record| RunSetup::of_record(record, &spec, Bench::Free { load: 0.0 }, 1.0).start;
        let (x, v) = start(&record);
        assert!((x - 0.2).abs() < 1e-12 && (v - 0.7).abs() < 1e-9, "{x} {v}");
        record.outputs[0].channel = "motor_angle_rad".to_owned();
        assert!((start(&record).0 - 0.2 * spec.ratio()).abs() < 1e-12);
        record.outputs[0].channel = "force_2_n".to_owned();
        assert_eq!(start(&record), (0.0, 0.0));
    }
}
