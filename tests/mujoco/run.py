"""Runs exported benches in MuJoCo on given commands, and weighs exported legs.

    python run.py JOB.json OUT.json

JOB.json has `benches`: a list of {xml, python, runs}, each run {controls, step_s, per_row, key}: by
actuator the command of every step (MuJoCo may take several in one), how many steps there are from one row to the next, and the
key where it begins. OUT.json has, for each bench and run, the channels by name, one value a row. JOB.json may have
`legs`: a list of {file, steps}, files of MJCF or URDF; OUT.json then has for each its mass in kg, its number of degrees of
freedom and actuators, the height of its first
body at every one of so many steps from the key 'start', the greatest joint speed, and the joints' positions at the end.
"""

import importlib.util
import json
import sys

import mujoco
import numpy as np


def loaded(path):
    spec = importlib.util.spec_from_file_location("beside", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def bench_run(item, run):
    # A callback of the model before would be called while this one is compiled.
    mujoco.set_mjcb_control(None)
    mujoco.set_mjcb_passive(None)
    model = mujoco.MjModel.from_xml_path(item["xml"])
    data = mujoco.MjData(model)
    if run["key"] is not None:
        mujoco.mj_resetDataKeyframe(model, data, model.key(run["key"]).id)
    beside = loaded(item["python"])
    bench = beside.Robot(model) if hasattr(beside, "Robot") else beside.Bench(model)
    dense = bool(bench.stages)
    show = bench.sense if dense else bench.channels
    rows = [show(data)]
    finer = round(run["step_s"] / model.opt.timestep)
    actuators = [model.actuator(name).id for name in run["controls"]]
    for step, controls in enumerate(zip(*run["controls"].values()), 1):
        data.ctrl[actuators] = controls
        for _ in range(finer):
            mujoco.mj_step(model, data)
            if dense:
                shown = show(data)
        if step % run["per_row"] == 0:
            if not dense:
                shown = show(data)
            rows.append(shown)
    if data.warning.number.sum() > 0:
        raise RuntimeError(f"{item['xml']}: MuJoCo warns {data.warning.number}")
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def weighed(item):
    mujoco.set_mjcb_control(None)
    mujoco.set_mjcb_passive(None)
    model = mujoco.MjModel.from_xml_path(item["file"])
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    heights, speed = [float(data.xpos[1, 2])], 0.0
    for _ in range(item["steps"]):
        mujoco.mj_step(model, data)
        heights.append(float(data.xpos[1, 2]))
        speed = max(speed, float(np.abs(data.qvel).max()))
    joints = {model.joint(i).name: float(data.qpos[model.joint(i).qposadr[0]]) for i in range(model.njnt)}
    return {"joints": joints, "mass_kg": float(model.body_mass.sum()), "dofs": model.nv, "actuators": model.nu, "heights_m": heights, "speed": speed,
            "time_s": float(data.time), "warnings": int(data.warning.number.sum())}


def main():
    with open(sys.argv[1]) as file:
        job = json.load(file)
    out = {"benches": [[bench_run(item, run) for run in item["runs"]] for item in job.get("benches", [])],
           "legs": [weighed(item) for item in job.get("legs", [])], "version": mujoco.__version__}
    with open(sys.argv[2], "w") as file:
        json.dump(out, file)


main()
