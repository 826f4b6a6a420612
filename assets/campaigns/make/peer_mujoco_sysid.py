"""The same pendulum campaigns for a peer, MuJoCo's system identification toolbox `mujoco.sysid`, and for `sealegs diagnose`.

    venv/bin/python make.py --set peer -o DIR
    venv/bin/python peer_mujoco_sysid.py DIR PATH-TO-SEALEGS > peer.md       (without the program: the peer's lines alone)

The peer gets the model that its careful user would build, and nothing of the base physics is kept from it: a joint of the motor
with armature, damping and a gear, a joint of the spring with stiffness (and the sprung mass as its armature), the pendulum behind
it; commands held between samples, every sensor divided by its noise, gain and bias of the load cells as parameters,
Runge-Kutta steps of 1 ms. It is fitted once with these parameters and once with
MuJoCo's `frictionloss` of the motor's joint free as well, which is the one of the hidden effects that MuJoCo has in its models.
Intervals are `calculate_intervals` at 95 %; those of sealegs are value +- 1.96 standard errors.
"""

import contextlib
import datetime
import io
import json
import logging
import math
import os
import pathlib
import platform
import subprocess
import sys
import tempfile
import time
import tomllib

import mujoco
import numpy as np
from mujoco import sysid

from robot import ASSETS, Coefficients, read_toml

ARM_M, LENGTH_M, MASS_KG = 0.0725, 0.300, 4.0
STEP_S = 1e-3
NOMINAL = Coefficients.of(read_toml(ASSETS / "actuators" / "thor-linear.toml"), "stiff")
OUTPUTS = ("force_1_n", "force_2_n", "motor_angle_rad", "joint_angle_rad")


def model_spec():
    """The pendulum behind a spring joint behind a motor joint, angles in the pendulum's (y = arm * motor)."""
    spec = mujoco.MjSpec.from_string(f"""
    <mujoco>
      <option timestep="{STEP_S}" integrator="RK4" gravity="0 0 -9.81"/>
      <worldbody>
        <body name="motor"><inertial pos="0 0 0" mass="1e-6" diaginertia="1e-9 1e-9 1e-9"/>
          <joint name="motor" axis="0 1 0" armature="{NOMINAL.inertia * ARM_M**2}" damping="{NOMINAL.damping * ARM_M**2}"/>
          <body name="link"><inertial pos="0 0 {-LENGTH_M}" mass="{MASS_KG}" diaginertia="1e-9 1e-9 1e-9"/>
            <joint name="spring" axis="0 1 0" armature="{NOMINAL.sprung * ARM_M**2}" stiffness="{NOMINAL.stiffness * ARM_M**2}"/>
            <site name="link"/>
          </body>
        </body>
      </worldbody>
      <actuator><motor name="current" joint="motor" gear="{NOMINAL.force_constant * ARM_M}"/></actuator>
      <sensor>
        <jointpos name="motor_angle" joint="motor"/><jointpos name="spring_angle" joint="spring"/>
        <torque name="link_torque" site="link"/>
      </sensor>
    </mujoco>""")
    return spec


def parameters(with_friction):
    """What is fitted, in the model's units, with where it is written to."""
    def joint(name, key):
        return lambda spec, p: setattr(spec.joint(name), key, keep(getattr(spec.joint(name), key), p.value[0]))

    def keep(old, value):
        """Joint properties that are polynomials in recent versions keep their shape."""
        if np.ndim(old) == 0:
            return value
        new = np.zeros_like(np.asarray(old, dtype=float))
        new[0] = value
        return new

    def gear(spec, p):
        spec.actuator("current").gear[0] = p.value[0]

    def add(name, nominal, low, high, modifier=None):
        result.add(sysid.Parameter(name, nominal, low, high, modifier=modifier))

    result = sysid.ParameterDict()
    square = ARM_M**2
    for name, value, where, key in (("armature", NOMINAL.inertia * square, "motor", "armature"),
                                    ("damping", NOMINAL.damping * square, "motor", "damping"),
                                    ("stiffness", NOMINAL.stiffness * square, "spring", "stiffness")):
        add(name, value, 0.2 * value, 5.0 * value, joint(where, key))
    add("gear", NOMINAL.force_constant * ARM_M, 10.0, 30.0, gear)
    if with_friction:
        add("frictionloss", 0.5, 0.0, 20.0, joint("motor", "frictionloss"))
    for channel in ("force_1_n", "force_2_n"):
        add(f"gain {channel}", 1.0, 0.9, 1.1)
        add(f"bias {channel}", 0.0, -50.0, 50.0)
    return result


def truth(answer):
    """The true values of the parameters, in the model's units."""
    scale, square = answer["scale"]["thor"], ARM_M**2
    values = {"armature": NOMINAL.inertia * scale["inertia"] * square, "damping": NOMINAL.damping * scale["damping"] * square,
              "stiffness": NOMINAL.stiffness * scale["stiffness"] * square,
              "gear": NOMINAL.force_constant * scale["force_constant"] * ARM_M}
    values["frictionloss"] = answer["effects"].get("coulomb-friction", {}).get("force_n", 0.0) * ARM_M
    for channel in ("force_1_n", "force_2_n"):
        values[f"gain {channel}"] = answer["sensors"][channel]["gain"]
        values[f"bias {channel}"] = answer["sensors"][channel]["bias"]
    return values


def read(folder):
    campaign = tomllib.loads((folder / "campaign.toml").read_text())
    runs = []
    for entry in campaign["run"]:
        with open(folder / entry["file"], encoding="utf-8") as file:
            header = file.readline().strip().split(",")
        table = np.loadtxt(folder / entry["file"], delimiter=",", skiprows=1)
        runs.append((entry["role"], dict(zip(header, table.T))))
    return campaign["noise_std"], runs


def sequences(spec, runs):
    """The runs as the toolbox wants them: controls at the model's step, held; measurements at their own times."""
    model = spec.compile()
    state = sysid.create_initial_state(model, np.zeros(model.nq), np.zeros(model.nv))
    controls, sensors = [], []
    for data in runs:
        t = data["time_s"]
        fine = np.arange(round(t[-1] / STEP_S) + 1) * STEP_S
        held = data["current_a"][np.minimum(np.floor(fine / (t[1] - t[0]) + 1e-6).astype(int), len(t) - 1)]
        controls.append(sysid.TimeSeries.from_control_names(fine, held[:, None], model))
        table = np.column_stack([data[c] for c in OUTPUTS])
        mapping = {c: (sysid.SignalType.CustomObs, np.array([i])) for i, c in enumerate(OUTPUTS)}
        sensors.append(sysid.TimeSeries(t, table, mapping))
    return controls, sensors, state


class Residual:
    """Predicted load cells and encoders less measured ones, in units of noise; the sum of squares of a run is its mean square."""

    def __init__(self, noise):
        self.noise = np.array([noise[c] for c in OUTPUTS])

    def predicted(self, params, times, data, at):
        # A rollout's sensors belong to the start of the step that its time stamp ends.
        motor, spring, torque = (np.interp(at, times - STEP_S, data[:, i]) for i in (0, 1, 3))
        forces = -params["stiffness"].value[0] * spring / ARM_M, torque / ARM_M
        cells = [params[f"gain {c}"].value[0] * f + params[f"bias {c}"].value[0] for c, f in zip(OUTPUTS, forces)]
        return np.column_stack([*cells, motor * ARM_M / NOMINAL.travel_per_rad, motor + spring])

    def __call__(self, params, predicted, measured, model, return_pred_all, state=None, sensor_weights=None):
        at = measured.times[:-1]
        values = self.predicted(params, predicted.times, predicted.data, at)
        residual = (values - measured.data[:-1]) / self.noise / math.sqrt(values.size)
        own = sysid.TimeSeries(at, values, measured.signal_mapping)
        return residual, own, sysid.TimeSeries(at, measured.data[:-1], measured.signal_mapping)


def sequence(spec, controls, sensors, state, names):
    group = sysid.ModelSequences.__new__(sysid.ModelSequences)
    group.name, group.spec, group.gt_model, group.allow_missing_sensors = "pendulum", spec, spec.compile(), True
    group.measured_rollout = [
        sysid.SystemTrajectory(model=group.gt_model, control=c, sensordata=s, initial_state=state, state=None)
        for c, s in zip(controls, sensors)]
    group.sequence_name, group.control, group.sensordata = names, controls, sensors
    group.initial_state = [state] * len(controls)
    return group


def fit(folder, answer, with_friction):
    """One identification by the peer: held-out error, parameters with half-widths, seconds."""
    start, cpu = time.time(), time.process_time()
    noise, runs = read(folder)
    spec = model_spec()
    groups = {}
    for role in ("fit", "holdout"):
        controls, sensors, state = sequences(spec, [data for r, data in runs if r == role])
        groups[role] = sequence(spec, controls, sensors, state, [role] * len(controls))
    residual = Residual(noise)
    make = lambda role: sysid.build_residual_fn(models_sequences=[groups[role]], modify_residual=residual, n_threads=1)
    params = parameters(with_friction)
    with contextlib.redirect_stdout(io.StringIO()):
        best, found = sysid.optimize(params, make("fit"), optimizer="mujoco", verbose=False, max_iters=60, x_scale="jac")
    x = best.as_vector()
    at_best = make("fit")(x, best)[0]
    _, half = sysid.calculate_intervals(at_best, found.jac)
    rms = lambda role: math.sqrt(np.mean([np.sum(np.square(r)) for r in make(role)(x, best)[0]]))
    true = truth(answer)
    return {"seconds": time.time() - start, "cpu": time.process_time() - cpu, "fit": rms("fit"), "holdout": rms("holdout"),
            "parameters": [(name, value, width, true[name]) for name, value, width in zip(best.keys(), x, half)]}


def sealegs(program, folder, answer):
    """One diagnosis by sealegs: the same figures."""
    scale = answer["scale"]["thor"]
    true = {"stiffness": NOMINAL.stiffness * scale["stiffness"], "reflected_inertia": NOMINAL.inertia * scale["inertia"],
            "damping": NOMINAL.damping * scale["damping"], "force_constant": NOMINAL.force_constant * scale["force_constant"]}
    true |= {f"{effect}.{key}": value for effect, values in answer["effects"].items() for key, value in values.items()}
    with tempfile.TemporaryDirectory() as scratch:
        out = pathlib.Path(scratch) / "out.json"
        start, before = time.time(), os.times()
        subprocess.run([program, "diagnose", str(folder), "--json", str(out)], check=True, capture_output=True)
        after = os.times()
        seconds = time.time() - start, after.children_user + after.children_system - before.children_user - before.children_system
        said = json.loads(out.read_text())
    chosen = said["after"] or said["base"]
    return said, seconds, chosen, true


def covered(rows):
    inside = [name for name, value, half, true in rows if abs(value - true) <= half]
    missed = [f"{name} off by {abs(value - true) / half:.1f} half-widths" if half > 0 else f"{name} without interval"
              for name, value, half, true in rows if abs(value - true) > half]
    return f"{len(inside)} of {len(rows)}" + (f" ({', '.join(missed)})" if missed else "")


def main():
    logging.disable(logging.WARNING)
    folder, program = pathlib.Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None
    answers = json.loads((folder / "answers.json").read_text())
    print(f"""# Side by side with a peer

Measured on {datetime.date.today()} with mujoco {mujoco.__version__} (`mujoco.sysid`), numpy {np.__version__}, Python
{platform.python_version()}, by `peer_mujoco_sysid.py`; campaigns by `make.py --set peer`.
Error: held-out runs, root mean square over all channels in units of the noise (1 is the floor). Intervals: 95 %.
""")
    print("| campaign | tool | held-out error | says | intervals that hold the truth | seconds (of processor) |")
    print("|---|---|---|---|---|---|")
    for name, answer in answers.items():
        for label, with_friction in (("mujoco.sysid", False), ("mujoco.sysid, frictionloss free", True)):
            r = fit(folder / name, answer, with_friction)
            says = "values, no verdict"
            if with_friction:
                value, half = next((v, h) for n, v, h, _ in r["parameters"] if n == "frictionloss")
                says = f"frictionloss {value:.3f} ± {half:.3f} N m (true {truth(answer)['frictionloss']:.3f})"
            print(f"| {name} | {label} | {r['holdout']:.2f} | {says} | {covered(r['parameters'])} | {r['seconds']:.0f} ({r['cpu']:.0f}) |", flush=True)
        if program is None:
            continue
        said, seconds, chosen, true = sealegs(program, folder / name, answer)
        rows = [(p["name"], p["value"], 1.96 * (p["std"] or 0.0), true[p["name"]]) for p in chosen["parameters"]
                if p["name"] in true]
        rows += [(f"gain {k['channel']}", k["gain"], 1.96 * k["gain_std"], answer["sensors"][k["channel"]]["gain"])
                 for k in chosen["sensors"] if k["channel"] in answer["sensors"]]
        says = f"{said['verdict']}: {', '.join(said['effects']) or 'nothing missing'}"
        if said["indistinguishable"]:
            says += "; or " + ", ".join("+".join(s) for s in said["indistinguishable"])
        print(f"| {name} | sealegs diagnose | {chosen['holdout_error']:.2f} | {says} | {covered(rows)} | {seconds[0]:.0f} ({seconds[1]:.0f}) |", flush=True)


if __name__ == "__main__":
    main()
