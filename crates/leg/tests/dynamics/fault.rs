//! What cannot be run, and what cannot go on.

use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::{Event, EventKind, Observer, Sample};
use sealegs_leg::{LegError, run};

#[derive(Default)]
struct Kept(Vec<f64>, Vec<Event>);

impl Observer for Kept {
    fn sample(&mut self, s: &Sample) -> Result<(), LegError> {
        self.0.push(s.time_s);
        Ok(())
    }

    fn event(&mut self, e: &Event) -> Result<(), LegError> {
        self.1.push(e.clone());
        Ok(())
    }
}

#[test]
fn a_runaway_stops_with_time_and_subject_and_keeps_what_was_seen() {
    // A joint servo far beyond what the step can integrate.
    let set = ["step_s=1e-3", "duration_s=0.5", "actuator.knee.parameters.stiffness=1e10"].map(str::to_owned);
    let scenario = Scenario::load("thor-drop", &set).expect("good");
    let mut kept = Kept::default();
    let result = run(&scenario, &mut kept).expect("runs");
    let stopped = result.stopped.expect("it runs away");
    assert!(stopped.contains("no longer finite at") && result.time_s < 0.5, "{stopped}");
    assert!(!kept.0.is_empty());
    assert!(kept.1.iter().any(|e| e.kind == EventKind::NotFinite));
}

#[test]
fn names_that_are_not_there_are_told() {
    let message = |set: &str| {
        let scenario = Scenario::load("thor-drop", &[set.to_owned()]).expect("readable");
        run(&scenario, &mut ()).expect_err("refused").to_string()
    };
    assert!(message("start.posture_rad.kneee=0.1").contains("did you mean 'knee'"));
    assert!(message("actuator.knie.spring=stiff").contains("no actuator 'knie'"));
    assert!(message("actuators.spring=stif").contains("did you mean 'stiff'"));
    assert!(message("actuator.knee.parameters.stifness=1e5").contains("did you mean 'stiffness'"));
    assert!(message("robot=thor-lg").contains("did you mean 'thor-leg'"));
    // An ankle bent so far that the actuator would have to be longer than it can.
    assert!(message("start.posture_rad.ankle_pitch=1.5").contains("ankle"));
}
