"""Simulated runs, and models as dictionaries."""

from __future__ import annotations

import numpy as np
import pytest
import sealegs


def test_a_drop_hits_the_ground_harder_from_higher_up():
    low, high = (sealegs.simulate("thor-drop", {"start.drop_height_m": h, "duration_s": 0.3}) for h in (0.02, 0.1))
    assert high.result.peaks.ground_force_n.value > low.result.peaks.ground_force_n.value > 100
    assert low.channels["base.height_m"].shape == low.time_s.shape
    assert low.time_s[0] == 0 and low.time_s[-1] == pytest.approx(0.3)
    assert list(low.frame("pandas").columns) == list(low.channels)
    assert low.frame("polars")["base.height_m"][0] == low["base.height_m"][0]


def test_a_scenario_is_a_dictionary(tmp_path):
    scenario = sealegs.scenario("thor-drop")
    scenario["duration_s"] = np.float64(0.05)
    scenario.start["drop_height_m"] = 0.03
    run = sealegs.simulate(scenario, recording=tmp_path / "drop.rrd")
    same = sealegs.simulate("thor-drop", {"duration_s": 0.05, "start.drop_height_m": 0.03})
    assert np.array_equal(run["base.height_m"], same["base.height_m"])
    assert (tmp_path / "drop.rrd").stat().st_size > 1000
    with pytest.raises(sealegs.InputError, match="durationn_s"):
        sealegs.simulate("thor-drop", {"durationn_s": 1})


def test_a_locked_bench_carries_the_motors_force_at_rest():
    time_s = np.arange(0, 2, 1e-3)
    actuator = sealegs.actuator("thor-linear")
    run = sealegs.simulate_bench(actuator, time_s=time_s, motor_force_n=np.full_like(time_s, 500.0))
    # At rest the spring carries the motor's force; what dry friction of the preset could hold back is in the tolerance.
    assert abs(run["force_1_n"][-1]) == pytest.approx(500.0, rel=0.05)
    softer = sealegs.simulate_bench("thor-linear", time_s=time_s, current_a=np.sin(time_s), spring="compliant")
    assert softer["current_a"].shape == softer["force_1_n"].shape == time_s.shape
    with pytest.raises(sealegs.InputError, match="3 values for 2000 time stamps"):
        sealegs.simulate_bench("thor-linear", time_s=time_s, current_a=[1, 2, 3])
    with pytest.raises(TypeError, match="give one command"):
        sealegs.simulate_bench("thor-linear", time_s=time_s)


def test_analytic_a_free_mass_obeys_newton():
    time_s = np.arange(0, 1, 1e-3)
    force_n = 20 * np.sin(2 * np.pi * time_s)
    drive = sealegs.actuator("rigid-linear")
    # Without a transmission the rotor is a mass (kg) and its damping acts on the load (N s/m).
    rotor_kg, damping_n_s_m = 0.01, 1e-3
    drive.motor.update(rotor_inertia_kg_m2=rotor_kg, rotor_damping_nm_s=damping_n_s_m)
    for mass_kg in (2.0, 5.0):
        run = sealegs.simulate_bench(
            drive, bench="free", rig={"mass_kg": mass_kg}, time_s=time_s, motor_force_n=force_n, hold="linear"
        )
        w = 2 * np.pi
        # m x'' = F from rest; what the damping takes in this second, b t / m = 5e-4 of the speed, is in the tolerance.
        position_m = 20 / ((mass_kg + rotor_kg) * w) * (time_s - np.sin(w * time_s) / w)
        assert run["position_m"] == pytest.approx(position_m, rel=1e-3, abs=1e-6)
    with pytest.raises(sealegs.InputError, match="'mass_kg' is for the bench pendulum or free, not for 'locked'"):
        sealegs.simulate_bench("thor-linear", rig={"mass_kg": 1.0}, time_s=time_s, motor_force_n=force_n)
    with pytest.raises(sealegs.InputError, match="behind a spring the output must have a mass"):
        sealegs.simulate_bench("thor-linear", bench="free", time_s=time_s, motor_force_n=force_n)


def test_an_unfinished_recording_is_not_left_behind(tmp_path):
    with pytest.raises(sealegs.SealegsError):
        sealegs.simulate("thor-drop", {"duration_s": 0.01}, recording=tmp_path / "nowhere" / "drop.rrd")
    assert list(tmp_path.iterdir()) == []


def test_a_value_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="not JSON compliant"):
        sealegs.simulate({**sealegs.scenario("thor-drop"), "duration_s": float("nan")})


def test_presets_are_named():
    presets = sealegs.presets()
    assert "thor-drop" in presets.scenarios and "thor-linear" in presets.actuators and presets.robots
    with pytest.raises(sealegs.InputError, match="did you mean"):
        sealegs.actuator("thor-liner")
