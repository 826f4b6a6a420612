//! Errors of the sensors that are effects of the catalogue, step by step alongside the motion.

use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Errors of the sensors; `None` is absent.
#[derive(Debug, Clone, Default)]
pub struct SensorErrors {
    /// Low-pass of the force sensors, or of one channel: cutoff, Hz.
    pub lag: Option<(Option<String>, f64)>,
    /// Lateness of all sensors, or of one channel: s.
    pub delay: Option<(Option<String>, f64)>,
    /// Structural mode in the path of the forces: frequency in Hz, damping ratio, participation.
    pub mode: Option<[f64; 3]>,
}

/// Channels in the order of the measured signals.
const CHANNELS: [[&str; 2]; 5] = [
    ["force_1_n", "output_torque_nm"],
    ["force_2_n", ""],
    ["motor_angle_rad", ""],
    ["spring_deflection_m", "spring_deflection_rad"],
    ["joint_angle_rad", ""],
];

pub(crate) struct Chain<'a> {
    of: &'a SensorErrors,
    step: f64,
    /// True signals, and those that the structure passes on, one step ago.
    before: [[f64; 5]; 2],
    shown: [f64; 5],
    low: [f64; 5],
    /// Low-passed force and its rate behind the structural mode.
    mode: [[f64; 2]; 2],
    late: VecDeque<[f64; 5]>,
}

fn concerns(wanted: Option<&String>, channel: usize) -> bool {
    wanted.is_none_or(|w| CHANNELS[channel].contains(&w.as_str()))
}

impl<'a> Chain<'a> {
    pub fn new(of: &'a SensorErrors, step: f64) -> Self {
        let zero = [0.0; 5];
        Self {
            of,
            step,
            before: [zero; 2],
            shown: zero,
            low: zero,
            mode: [[0.0; 2]; 2],
            late: VecDeque::new(),
        }
    }

    /// Rest at the first sample.
    pub fn begin(&mut self) {
        if let Some((_, delay)) = &self.of.delay {
            // One more than the whole steps, so that the value between two steps can be interpolated.
            self.late = (0..(delay / self.step).floor() as usize + 2).map(|_| [0.0; 5]).collect();
        }
    }

    /// A step further, with the true signals at its end.
    pub fn pass(&mut self, signal: [f64; 5]) {
        let h = self.step;
        let mut shown = signal;
        if let Some([hz, ratio, participation]) = self.of.mode {
            let w = TAU * hz;
            for i in 0..2 {
                // Trapezoidal rule for P'' + 2 ratio w P' + w^2 P = w^2 F.
                let [p, rate] = self.mode[i];
                let force = 0.5 * (self.before[0][i] + signal[i]);
                let mean_rate =
                    (rate + 0.5 * h * w * w * (force - p)) / (1.0 + h * ratio * w + 0.25 * h * h * w * w);
                self.mode[i] = [p + h * mean_rate, 2.0 * mean_rate - rate];
                shown[i] += participation * (signal[i] - self.mode[i][0] - 2.0 * ratio / w * self.mode[i][1]);
            }
        }
        let passed = shown;
        if let Some((channel, hz)) = &self.of.lag {
            let x = 0.5 * TAU * hz * h;
            for i in 0..5 {
                let force = channel.is_some() || i < 2;
                if force && concerns(channel.as_ref(), i) {
                    self.low[i] +=
                        2.0 * x / (1.0 + x) * (0.5 * (self.before[1][i] + passed[i]) - self.low[i]);
                    shown[i] = self.low[i];
                }
            }
        }
        if let Some((channel, delay)) = &self.of.delay {
            self.late.push_back(shown);
            self.late.pop_front();
            let part = delay / h - (delay / h).floor();
            for i in 0..5 {
                if concerns(channel.as_ref(), i) {
                    shown[i] = part * self.late[0][i] + (1.0 - part) * self.late[1][i];
                }
            }
        }
        self.before = [signal, passed];
        self.shown = shown;
    }

    /// What the logger writes.
    pub fn show(&self) -> [f64; 5] {
        self.shown
    }
}
