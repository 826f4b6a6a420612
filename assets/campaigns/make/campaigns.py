"""Which campaigns there are: shipped ones, those to validate with, and those for the comparison with a peer.

An effect stands under its scoped name, `PLACE/EFFECT`, PLACE being an actuator, a link or the foot as in the robot's files; on a
bench it has no place.
"""

from robot import merged
from simulate import STEP_S

HOLD = {"kind": "pd", "stiffness_nm_rad": 500.0, "damping_nm_s_rad": 20.0, "gravity_compensation": False, "feed_forward": False,
        "current_limit_a": 10.0}
FOLLOW = {"kind": "pd", "stiffness_nm_rad": 500.0, "damping_nm_s_rad": 10.0, "gravity_compensation": True, "feed_forward": True,
          "current_limit_a": 10.0}


def drop(height, hip=-0.45, knee=0.90, ankle=-0.45, duration=0.5):
    """A drop as of thor-drop.toml: from a height (m) in a posture (rad)."""
    return {
        "description": f"THOR's leg lands from {height:g} m, knee at {knee:g} rad", "robot": "thor-leg", "duration_s": duration,
        "base": {"kind": "rail", "carriage_mass_kg": 20.0},
        "start": {"drop_height_m": height, "springs": "unloaded",
                  "posture_rad": {"hip_pitch": hip, "knee": knee, "ankle_pitch": ankle}},
        "ground": {}, "controller": HOLD}


def sine(amplitude, frequency, phase=0.0):
    return {"shape": "sine", "amplitude_rad": amplitude, "frequency_hz": frequency, "phase_rad": phase}


def swing(duration, knee_rad, hip_to_rad, **motion):
    """A swing on the stand: hip flexes along a half-cosine, the other joints move as given."""
    moves = {"hip_pitch": {"shape": "half-cosine", "to_rad": hip_to_rad, "start_s": 0.1, "duration_s": 0.8}} | motion
    return {
        "description": "THOR's leg swings on a stand, all its joints moving", "robot": "thor-leg", "duration_s": duration,
        "base": {"kind": "fixed", "height_m": 1.2},
        "start": {"springs": "balanced", "posture_rad": {"hip_pitch": -0.6, "knee": knee_rad}},
        "controller": FOLLOW, "motion": moves}


DROPS = [("fit-05cm", "fit", drop(0.05)), ("fit-crouched", "fit", drop(0.08, -0.65, 1.30, -0.65)),
         ("fit-10cm", "fit", drop(0.10)), ("check-upright", "holdout", drop(0.07, -0.30, 0.60, -0.30))]
CLEAN_DROPS = [DROPS[0], ("fit-10cm-crouched", "fit", drop(0.10, -0.60, 1.20, -0.60)), ("check-08cm", "holdout", drop(0.08))]


def swings(duration):
    # Rotor damping takes most of the current: amplitude times frequency stays below what 10 A can move. The foot rises to
    # about 0.9 rad toes up, where its weight changes sides at the ankle.
    moves = [
        dict(ankle_pitch=sine(0.07, 3.0), ankle_roll=sine(0.06, 2.3, 0.4), knee=sine(0.20, 0.9), hip_roll=sine(0.08, 1.2),
             hip_yaw=sine(0.08, 1.5, 0.8)),
        dict(ankle_pitch=sine(0.10, 1.8, 1.0), ankle_roll=sine(0.04, 3.4), knee=sine(0.12, 1.6, 0.5), hip_roll=sine(0.09, 1.1, 1.0),
             hip_yaw=sine(0.10, 1.0)),
        dict(ankle_pitch=sine(0.08, 2.4, 0.7), ankle_roll=sine(0.05, 2.8, 1.5), knee=sine(0.16, 1.2, 1.2),
             hip_roll=sine(0.06, 1.5), hip_yaw=sine(0.08, 1.3, 2.0)),
    ]
    return [("fit-a", "fit", swing(duration, 0.4, -1.3, **moves[0])), ("fit-b", "fit", swing(duration, 0.3, -1.2, **moves[1])),
            ("check-c", "holdout", swing(duration, 0.35, -1.4, **moves[2]))]


def leg(seed, runs, effects, force_noise, step_s=STEP_S):
    preset = "thor-drop" if "ground" in runs[0][2] else "thor-swing"
    return {"bench": "leg", "scenario": preset, "seed": seed, "runs": runs, "effects": effects, "force_noise": force_noise,
            "step_s": step_s}


def bench(seed, effects, duration=10.0, rate=500.0, step_s=STEP_S):
    return {"bench": "pendulum", "seed": seed, "effects": effects, "duration_s": duration, "rate_hz": rate, "step_s": step_s,
            "runs": [("fit-chirp", "fit"), ("fit-steps", "fit"), ("check-noise", "holdout"), ("check-low", "holdout")]}


SHIPPED = {
    # A worn sole: what is missing changes the forces at impact by a fifth.
    "leg-drop": leg(11, DROPS, {"foot/contact-compliance": {"stiffness_n_m_n": 1.2e6, "damping_s_m": 0.9}}, 4.0),
    # Its play rattles in the second run: with the usual step that is up to five noise units off.
    "leg-swing": leg(12, swings(1.1), {"ankle_outer/backlash": {"gap_m": 8.0e-5}}, 2.0, 2e-6),
    "leg-clean": leg(13, CLEAN_DROPS, {}, 4.0),
    "bench-knee": bench(14, {"spring-hysteresis": {"stiffness_n_m": 60e3, "slip_force_n": 12.0}}),
}

SLIDING = [(name, role, merged(run, {"start": {"posture_rad": {"hip_pitch": -0.75, "ankle_pitch": -0.15}}}))
           for name, role, run in [DROPS[0], ("fit-08cm", "fit", drop(0.08)), ("check-06cm", "holdout", drop(0.06))]]
# Past the knee's stop at 0: the wanted motion goes through it.
STOPPED = [(name, role, merged(run, {"motion": {"knee": sine(0.30, f)}, "start": {"posture_rad": {"knee": 0.20}}}))
           for (name, role, run), f in zip(swings(1.1), (1.0, 1.4, 1.2))]

# Play rattles: with the usual step it is noise units off, as in the shipped swing.
VALIDATION = {
    "v01": leg(101, DROPS, {"knee/coulomb-friction": {"force_n": 120.0}}, 4.0),
    "v02": leg(102, swings(1.1), {"ankle_inner/backlash": {"gap_m": 2.5e-4}}, 2.0, 2e-6),
    "v03": leg(103, swings(1.1), {"hip_pitch/transport-delay": {"delay_s": 0.006}}, 2.0),
    "v04": leg(104, DROPS, {"foot/contact-compliance": {"stiffness_n_m_n": 1.2e6, "damping_s_m": 0.9}}, 4.0),
    "v05": leg(105, swings(1.1), {"shank/link-mass": {"mass_kg": 0.5, "at_m": [0.0, 0.0, -0.25]}}, 2.0),
    "v06": leg(106, DROPS, {"knee/spring-setting": {"setting": "stiff"}}, 4.0),
    "v07": leg(107, DROPS, {"knee/load-dependent-friction": {"coefficient": 0.06}}, 4.0),
    "v08": leg(108, swings(1.1), {"hip_front/coulomb-friction": {"force_n": 60.0}}, 2.0),
    "v09": leg(109, SLIDING, {"foot/ground-friction": {"friction": 0.25}}, 4.0),
    "v10": leg(110, DROPS, {"ankle_outer/spring-hysteresis": {"stiffness_n_m": 80e3, "slip_force_n": 60.0}}, 4.0),
    "v11": leg(111, swings(1.1), {"ankle_outer/series-compliance": {"stiffness_n_m": 150e3}}, 2.0),
    "v12": leg(112, swings(1.1), {"hip_pitch/torque-ripple": {"amplitude_n": 60.0, "cycles_per_rev": 1.0, "phase_rad": 0.7}}, 2.0),
    "v13": leg(113, DROPS, {}, 4.0),
    "v14": leg(114, swings(1.1), {}, 2.0),
    "v15": leg(115, STOPPED, {"knee/joint-stop": {"stiffness_nm_rad": 1000.0, "damping_nm_s_rad": 5.0}}, 2.0),
    "v16": leg(116, DROPS, {"hip_pitch/direction-dependent-friction": {"force_n": 80.0, "asymmetry": 0.5}}, 4.0),
    "v17": leg(117, swings(1.1), {"knee/coulomb-friction": {"force_n": 40.0}, "ankle_outer/backlash": {"gap_m": 4.0e-4}},
               2.0, 2e-6),
    # From here on: chosen after the search was built, and looked at by its judge alone.
    "v18": leg(118, DROPS, {"knee/stribeck-friction": {"coulomb_n": 50.0, "static_n": 110.0, "stribeck_velocity_m_s": 0.01}}, 4.0),
    "v19": leg(119, swings(1.1), {"hip_back/presliding-friction": {"force_n": 60.0, "stiffness_n_m": 2e6}}, 2.0),
    "v20": leg(120, swings(1.1), {"knee/quadratic-drag": {"coefficient_n_s2_m2": 4e4}}, 2.0),
    "v21": leg(121, DROPS, {"ankle_outer/hardening-spring": {"cubic_n_m3": 9e9}}, 4.0),
    "v22": leg(122, DROPS, {"knee/spring-damping": {"damping_n_s_m": 400.0}}, 4.0),
    "v23": leg(123, swings(1.1), {"ankle_inner/transport-delay": {"delay_s": 0.003}}, 2.0),
    "v24": leg(124, DROPS, {"hip_back/load-dependent-friction": {"coefficient": 0.08}}, 4.0),
    "v25": leg(125, swings(1.1), {"thigh/link-mass": {"mass_kg": 0.8, "at_m": [0.0, 0.0, -0.15]}}, 2.0),
    "v26": leg(126, swings(1.1), {"hip_front/torque-ripple": {"amplitude_n": 50.0, "cycles_per_rev": 2.0, "phase_rad": 0.3}}, 2.0),
    "v27": leg(127, DROPS, {"knee/coulomb-friction": {"force_n": 100.0},
                            "foot/contact-compliance": {"stiffness_n_m_n": 1.5e6, "damping_s_m": 0.7}}, 4.0),
    "v28": leg(128, swings(1.1), {}, 2.0),
    "v29": leg(129, SLIDING, {}, 4.0),
    "v30": leg(130, swings(1.1), {"hip_pitch/transport-delay": {"delay_s": 0.004},
                                  "knee/load-dependent-friction": {"coefficient": 0.08}}, 2.0),
}

PEER = {
    "pendulum-clean": bench(201, {}, 10.0, 1000.0),
    "pendulum-friction": bench(202, {"coulomb-friction": {"force_n": 30.0}}, 10.0, 1000.0),
    "pendulum-backlash": bench(203, {"backlash": {"gap_m": 4e-5}}, 10.0, 1000.0),
    # The sprung mass rings undamped at 277 Hz: with the usual step it is half a turn ahead after ten seconds.
    "pendulum-series": bench(204, {"series-compliance": {"stiffness_n_m": 1.3e6}}, 10.0, 1000.0, 2e-6),
}

SETS = {"shipped": SHIPPED, "validation": VALIDATION, "peer": PEER}
