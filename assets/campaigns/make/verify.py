"""What the simulator is worth: against the Rust program without effect and noise, and against itself at half the step.

    cargo run --release -p sealegs-leg --example channels -- thor-drop > drop.csv
    venv/bin/python verify.py against drop.csv thor-drop       greatest and rms difference of each channel, per cent of its range
    venv/bin/python verify.py halve [SET [NAME ..]]            each run of each shipped campaign with its effect, at its step and at
                                                               half of it, in units of the sensors' noise
    venv/bin/python verify.py strength [SET]                   what the hidden effects change in it, in units of the noise
"""

import argparse
import sys

import numpy as np

from campaigns import SETS
from make import excitation, individual, run_bench, run_leg
from robot import ASSETS, mujoco_leg, merged, read_toml
from sensors import BENCH_SENSORS, LEG_SENSORS, Sensors

ONE = dict.fromkeys(("stiffness", "inertia", "damping", "force_constant"), 1.0)


def against(path, name):
    """The nominal leg against a CSV of the Rust program's channels."""
    with open(path, encoding="utf-8") as file:
        header = file.readline().strip().split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    other = dict(zip(header, table.T))
    scenario = read_toml(name if name.endswith(".toml") else ASSETS / "scenarios" / f"{name}.toml")
    scenario = merged(scenario, {"duration_s": float(other["time_s"][-1])})
    scales = {actuator: ONE for actuator in mujoco_leg(scenario).names}
    time_s, mine = run_leg(scenario, scales, {})
    if not np.allclose(time_s, other["time_s"], atol=1e-9):
        sys.exit("the samples are at other times")
    print(f"{'channel':28s} {'from':>10s} {'to':>10s} {'greatest %':>10s} {'rms %':>8s}")
    for channel, values in mine.items():
        span = np.ptp(values)
        off = other[channel] - values
        print(f"{channel:28s} {values.min():10.4f} {values.max():10.4f} {100 * np.abs(off).max() / span:10.3f} "
              f"{100 * np.sqrt(np.mean(off**2)) / span:8.3f}")


def run_of(spec, index, effects, step_s):
    """A run of a campaign without sensors. A bench's later runs are drawn after its sensors and cannot be had alone."""
    rng = np.random.default_rng(spec["seed"])
    if spec["bench"] == "leg":
        scales = individual(mujoco_leg(spec["runs"][0][2]).names, rng)
        return run_leg(spec["runs"][index][2], scales, effects, step_s)[1]
    scale = individual(["thor"], rng)["thor"]
    time_s = np.arange(round(spec["duration_s"] * spec["rate_hz"]) + 1) / spec["rate_hz"]
    return run_bench(np.round(excitation(spec["runs"][index][0], time_s, rng), 4), time_s, scale, effects, step_s)


def compare(spec, one, two):
    """Rms over all outputs and samples in units of noise, and the greatest difference with its channel."""
    table = LEG_SENSORS if spec["bench"] == "leg" else BENCH_SENSORS
    noise = Sensors(one, table, np.random.default_rng(0), spec.get("force_noise")).noise_std()
    columns = [c for c in one if spec["bench"] == "leg" or c != "current_a"]
    off = {c: np.abs(one[c] - two[c]) / noise[c] for c in columns}
    worst = max(columns, key=lambda c: off[c].max())
    return float(np.sqrt(np.mean(np.square(list(off.values()))))), (float(off[worst].max()), worst)


def halve(which, *names):
    for name, spec in SETS[which].items():
        if names and name not in names:
            continue
        step = spec["step_s"]
        for index in range(len(spec["runs"]) if spec["bench"] == "leg" else 1):
            rms, worst = compare(spec, *(run_of(spec, index, spec["effects"], s) for s in (step, 0.5 * step)))
            print(f"{name} {spec['runs'][index][0]}: {step * 1e6:.0f} against {step * 5e5:.0f} us: rms {rms:.4f}, "
                  f"greatest {worst[0]:.3f} noise ({worst[1]})", flush=True)


def strength(which):
    for name, spec in SETS[which].items():
        if spec["effects"]:
            rms, worst = compare(spec, *(run_of(spec, 0, effects, spec["step_s"]) for effects in (spec["effects"], {})))
            print(f"{name}: {' + '.join(spec['effects'])} changes rms {rms:.1f}, greatest {worst[0]:.0f} noise ({worst[1]})", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("against", "halve", "strength"))
    parser.add_argument("rest", nargs="*")
    arguments = parser.parse_args()
    if arguments.what == "against":
        against(*arguments.rest)
    elif arguments.what == "halve":
        halve(*arguments.rest or ["shipped"])
    else:
        strength(arguments.rest[0] if arguments.rest else "shipped")


if __name__ == "__main__":
    main()
