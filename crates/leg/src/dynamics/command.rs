//! A command on its way from the controller, or from a record, to the motor.

use sealegs_actuator::plant::CommandStage;
use std::collections::VecDeque;

/// A time stamp this close to the end of a step, as a share of the step, is on it.
const SNAP: f64 = 1e-6;

/// The commands of one actuator that have been sent and may still be on their way.
#[derive(Debug, Default)]
pub(crate) struct CommandLine {
    /// When each command comes into force, s, and its current, A, after the drive's stages.
    sent: VecDeque<(f64, f64)>,
    /// Mean current over each step where a record gives the commands, A.
    given: Option<Vec<f64>>,
}

impl CommandLine {
    /// Takes commands, A over each step, from a record from now on.
    pub fn give(&mut self, per_step: Vec<f64>) {
        self.given = Some(per_step);
    }

    /// The recorded command over a step, A, if there is a record; the last one holds beyond its end.
    pub fn given(&self, step: usize) -> Option<f64> {
        let given = self.given.as_ref()?;
        given.get(step).or(given.last()).copied()
    }

    /// Sends a command through the drive's stages, each sample on its own.
    pub fn send(&mut self, time_s: f64, current_a: f64, stages: &[Box<dyn CommandStage>]) {
        let (mut at, mut value) = ([time_s], [current_a]);
        for stage in stages {
            stage.apply(&mut at, &mut value);
        }
        // A start that is tried again sends again.
        if let Some(last) = self.sent.back_mut().filter(|last| last.0 >= at[0]) {
            *last = (at[0], value[0]);
        } else {
            self.sent.push_back((at[0], value[0]));
        }
    }

    /// Mean of what is in force over a step from `from_s`, A; before the first command comes into force it is that
    /// command. Steps are asked for in the order of time.
    pub fn mean(&mut self, from_s: f64, step_s: f64) -> f64 {
        let snap = SNAP * step_s;
        while self.sent.len() > 1 && self.sent[1].0 <= from_s + snap {
            self.sent.pop_front();
        }
        let Some(&(_, mut value)) = self.sent.front() else { return 0.0 };
        let to_s = from_s + step_s;
        let (mut sum, mut since) = (0.0, from_s);
        for &(at, next) in self.sent.iter().skip(1).take_while(|(at, _)| *at < to_s - snap) {
            sum += value * (at - since);
            (since, value) = (at, next);
        }
        if since <= from_s { value } else { (sum + value * (to_s - since)) / step_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Late(f64);

    impl CommandStage for Late {
        fn apply(&self, time_s: &mut [f64], _values: &mut [f64]) {
            time_s.iter_mut().for_each(|t| *t += self.0);
        }
    }

    #[test]
    fn analytic_a_delayed_staircase_keeps_its_mean() {
        let stages: Vec<Box<dyn CommandStage>> = vec![Box::new(Late(2.3e-3))];
        let mut line = CommandLine::default();
        let h = 2e-4;
        let mut got = Vec::new();
        for n in 0..50 {
            let t = f64::from(n) * h;
            if n % 5 == 0 {
                line.send(t, f64::from(n / 5), &stages);
            }
            got.push(line.mean(t, h));
        }
        // The command k comes into force at 2.3 ms + k ms: halfway through the step from 3.2 ms for k = 1.
        assert_eq!((got[0], got[15], got[17]), (0.0, 0.0, 1.0));
        assert!((got[16] - 0.5).abs() < 1e-9, "{got:?}");
    }

    #[test]
    fn a_command_without_stages_is_in_force_at_once() {
        let mut line = CommandLine::default();
        line.send(0.0, 2.0, &[]);
        assert_eq!(line.mean(0.0, 1e-4), 2.0);
        line.send(1e-3, 3.0, &[]);
        assert_eq!(line.mean(1e-3, 1e-4), 3.0);
    }
}
