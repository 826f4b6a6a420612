//! What a spring can bear, and when a simulation first asked more of it.

use std::fmt;

use serde::Serialize;

/// One limit that was exceeded.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OverLimit {
    /// Which limit, with the unit of its numbers.
    pub what: LimitKind,
    /// What was asked.
    pub value: f64,
    /// What is allowed.
    pub limit: f64,
}

/// The limits of a spring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LimitKind {
    /// Bending stress against the yield strength, Pa.
    YieldStressPa,
    /// Force against the actuator's rated peak, N.
    RatedForceN,
    /// Torque against a rotary actuator's rated peak, N m.
    RatedTorqueNm,
    /// Pivot distance against the range that the mounting and the measured law cover, m.
    PivotRangeM,
    /// Free length against the range between the two settings, m.
    LengthRangeM,
}

impl fmt::Display for OverLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, limit) = (self.value, self.limit);
        match self.what {
            LimitKind::YieldStressPa => {
                write!(f, "beam past yield: {:.1} MPa, strength {:.1} MPa", 1e-6 * value, 1e-6 * limit)
            }
            LimitKind::RatedForceN => write!(f, "past the rated force: {value:.1} N, rated {limit:.1} N"),
            LimitKind::RatedTorqueNm => {
                write!(f, "past the rated torque: {value:.2} N m, rated {limit:.2} N m")
            }
            LimitKind::PivotRangeM => {
                write!(f, "pivot out of range: {:.2} mm, limit {:.2} mm", 1e3 * value, 1e3 * limit)
            }
            LimitKind::LengthRangeM => {
                write!(f, "beam length out of range: {:.2} mm, limit {:.2} mm", 1e3 * value, 1e3 * limit)
            }
        }
    }
}

impl OverLimit {
    pub(super) fn pivot_out_of_range(pivot_m: f64, range_m: [f64; 2]) -> Self {
        Self { what: LimitKind::PivotRangeM, value: pivot_m, limit: nearer(pivot_m, range_m) }
    }

    pub(super) fn length_out_of_range(length_m: f64, range_m: [f64; 2]) -> Self {
        Self { what: LimitKind::LengthRangeM, value: length_m, limit: nearer(length_m, range_m) }
    }
}

fn nearer(value: f64, [least, greatest]: [f64; 2]) -> f64 {
    if value < least { least } else { greatest }
}

/// What a spring can bear; forces are N, or N m for a torsion spring.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpringLimits {
    /// Stiffness, N/m or N m/rad.
    pub stiffness: f64,
    /// Bending stress per unit of force, Pa/N; zero for a spring that has no beam, or none in the load path.
    pub stress_per_force_pa: f64,
    /// Yield strength of the beam, Pa.
    pub yield_stress_pa: Option<f64>,
    /// Force at which the beam yields.
    pub yield_force: Option<f64>,
    /// Rated peak force of the actuator.
    pub rated_force: Option<f64>,
    /// Whether forces are torques: a torsion spring.
    pub torsion: bool,
    /// A setting outside the beam's range, known before anything moves.
    pub static_finding: Option<OverLimit>,
}

impl SpringLimits {
    /// Deflection at which the beam yields, m.
    #[must_use]
    pub fn yield_deflection(&self) -> Option<f64> {
        self.yield_force.map(|f| f / self.stiffness)
    }

    /// Bending stress at a force, Pa.
    #[must_use]
    pub fn stress_pa(&self, force: f64) -> f64 {
        self.stress_per_force_pa * force.abs()
    }

    /// The limits that this force passes, the beam's setting aside.
    #[must_use]
    pub fn check(&self, force: f64) -> Vec<OverLimit> {
        let mut passed = Vec::new();
        if let (Some(limit), Some(yield_force)) = (self.yield_stress_pa, self.yield_force)
            && force.abs() > yield_force
        {
            passed.push(OverLimit { what: LimitKind::YieldStressPa, value: self.stress_pa(force), limit });
        }
        if let Some(limit) = self.rated_force
            && force.abs() > limit
        {
            let what = if self.torsion { LimitKind::RatedTorqueNm } else { LimitKind::RatedForceN };
            passed.push(OverLimit { what, value: force.abs(), limit });
        }
        passed
    }

    /// The limits that the spring's force passes over a run of equidistant values, each with the time at which it
    /// was first passed and the worst value.
    #[must_use]
    pub fn over_run(self, start_s: f64, step_s: f64, forces: &[f64]) -> Vec<LimitEvent> {
        let mut watch = LimitWatch::new(self, start_s);
        for (i, force) in forces.iter().enumerate() {
            watch.observe(start_s + step_s * i as f64, *force);
        }
        watch.events
    }

    /// The smallest force at which [`SpringLimits::check`] finds anything; infinite without limits.
    #[must_use]
    pub fn first_limit(&self) -> f64 {
        self.yield_force.unwrap_or(f64::INFINITY).min(self.rated_force.unwrap_or(f64::INFINITY))
    }
}

/// A limit with the time at which it was first passed, and the worst that came after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LimitEvent {
    /// When it was first passed, s.
    pub time_s: f64,
    /// The limit, with the greatest value over the whole run.
    pub worst: OverLimit,
}

impl fmt::Display for LimitEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} s: {}", self.time_s, self.worst)
    }
}

/// Watches a spring's force during a simulation. One comparison per step as long as nothing is passed.
#[derive(Debug, Clone)]
pub struct LimitWatch {
    limits: SpringLimits,
    threshold: f64,
    events: Vec<LimitEvent>,
}

impl LimitWatch {
    /// A watch that starts at `time_s`; a setting out of range is an event at that time.
    #[must_use]
    pub fn new(limits: SpringLimits, time_s: f64) -> Self {
        let events = limits.static_finding.iter().map(|o| LimitEvent { time_s, worst: o.clone() }).collect();
        Self { threshold: limits.first_limit(), limits, events }
    }

    /// Looks at the spring's force at one time.
    pub fn observe(&mut self, time_s: f64, force: f64) {
        if force.abs() <= self.threshold {
            return;
        }
        for over in self.limits.check(force) {
            match self.events.iter_mut().find(|e| e.worst.what == over.what) {
                Some(event) if over.value > event.worst.value => event.worst = over,
                Some(_) => {}
                None => self.events.push(LimitEvent { time_s, worst: over }),
            }
        }
    }

    /// The limits that were passed, in the order in which that happened.
    #[must_use]
    pub fn events(&self) -> &[LimitEvent] {
        &self.events
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ClampSetting, EndLoadedBeam, MomentLoadedBeam, Spring, TorsionSpring};
    use super::*;

    #[test]
    fn a_watch_keeps_the_first_time_and_the_worst_value() {
        let spring = Spring::MomentLoadedBeam(MomentLoadedBeam::thor(ClampSetting::Stiff));
        let mut watch = LimitWatch::new(spring.limits(Some(2225.0)), 0.0);
        for (time_s, force) in [(0.1, 2000.0), (0.2, -2300.0), (0.3, 4200.0), (0.4, 100.0), (0.5, -2500.0)] {
            watch.observe(time_s, force);
        }
        let [rated, yielded] = watch.events() else { panic!("two limits: {:?}", watch.events()) };
        assert_eq!(
            (rated.time_s, rated.worst.what, rated.worst.value),
            (0.2, LimitKind::RatedForceN, 4200.0)
        );
        assert_eq!((yielded.time_s, yielded.worst.what), (0.3, LimitKind::YieldStressPa));
        // 463.7 MPa at 2225 N (section 2-5-1), linear in the force.
        assert!((yielded.worst.value / (463.7e6 * 4200.0 / 2225.0) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_run_of_forces_is_watched_at_its_times() {
        let limits = Spring::EndLoadedBeam(EndLoadedBeam::saffir(0.110)).limits(Some(1000.0));
        let events = limits.over_run(2.0, 0.5, &[0.0, 900.0, -1200.0, 1100.0]);
        assert_eq!(events.len(), 1);
        assert_eq!((events[0].time_s, events[0].worst.value), (3.0, 1200.0));
        assert_eq!(events[0].to_string(), "3.0000 s: past the rated force: 1200.0 N, rated 1000.0 N");
    }

    #[test]
    fn a_pivot_out_of_range_is_reported_before_anything_moves() {
        let watch = LimitWatch::new(Spring::EndLoadedBeam(EndLoadedBeam::saffir(0.115)).limits(None), 0.0);
        assert_eq!(watch.events()[0].worst, OverLimit::pivot_out_of_range(0.115, [0.065, 0.110]));
        assert!(watch.events()[0].to_string().contains("115.00 mm, limit 110.00 mm"));
        let inside = LimitWatch::new(Spring::EndLoadedBeam(EndLoadedBeam::saffir(0.110)).limits(None), 0.0);
        assert!(inside.events().is_empty());
    }

    #[test]
    fn a_torsion_spring_speaks_of_torque() {
        let limits = Spring::Torsion(TorsionSpring { stiffness_nm_rad: 2500.0 }).limits(Some(35.0));
        assert_eq!(limits.check(-40.0)[0].to_string(), "past the rated torque: 40.00 N m, rated 35.00 N m");
        assert!(limits.check(34.0).is_empty());
    }

    #[test]
    fn a_locked_out_beam_does_not_yield() {
        let locked = Spring::MomentLoadedBeam(MomentLoadedBeam::thor(ClampSetting::LockedOut)).limits(None);
        assert_eq!(locked.yield_force, None);
        assert!(locked.check(1e6).is_empty());
    }
}
