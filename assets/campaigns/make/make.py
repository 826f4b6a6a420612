"""Makes campaigns with a hidden effect by a simulator of its own: MuJoCo for the bodies, `equations.py` for everything else.

    python3 -m venv venv && venv/bin/pip install -r requirements.txt
    venv/bin/python make.py                                  the shipped campaigns, into the folder above
    venv/bin/python make.py --set validation -o DIR          more, not for the repository; answers in DIR/answers.json
    venv/bin/python make.py --set validation --others 1000 -o DIR    the same effects in other individuals
    venv/bin/python make.py --set peer -o DIR                those of the comparison with a peer
"""

import argparse
import json
import math
import pathlib
import time

import numpy as np

import equations as eq
from campaigns import SETS
from controller import Controller, start_of
from robot import mujoco_leg, mujoco_pendulum, spring_stiffness, read_toml, ASSETS
from sensors import BENCH_SENSORS, LEG_SENSORS, Sensors, toml_key, toml_tables, toml_value, write_csv
from simulate import GROUND, STEP_S, Plant, run

# How far an individual differs from the nominal robot: uniform within these shares.
SPREAD = {"stiffness": 0.03, "inertia": 0.06, "damping": 0.10, "force_constant": 0.02}
COLUMN = {"stiffness": eq.STIFFNESS, "inertia": eq.INERTIA, "damping": eq.DAMPING, "force_constant": eq.FORCE_CONSTANT}
HOUSE = pathlib.Path(__file__).resolve().parent.parent


def individual(names, rng):
    """True over nominal, by actuator and parameter."""
    return {name: {key: round(1.0 + share * rng.uniform(-1.0, 1.0), 6) for key, share in SPREAD.items()} for name in names}


def true_params(leg, scales):
    rows = np.array([c.row() for c in leg.coefficients])
    for row, name in zip(rows, leg.names):
        for key, column in COLUMN.items():
            row[column] *= scales[name][key]
    return rows


def put_in(effect, values, row, travel_per_rad):
    """Sets an actuator's parameters (a row of `equations`) to an effect of the catalogue; False if it is none of those."""
    columns = {
        "coulomb-friction": {"force_n": eq.COULOMB},
        "stribeck-friction": {"coulomb_n": eq.COULOMB, "static_n": eq.STATIC, "stribeck_velocity_m_s": eq.STRIBECK_SPEED},
        "load-dependent-friction": {"coefficient": eq.LOAD_FRICTION},
        "direction-dependent-friction": {"force_n": eq.COULOMB, "asymmetry": eq.ASYMMETRY},
        "presliding-friction": {"force_n": eq.PRESLIDING_FORCE, "stiffness_n_m": eq.PRESLIDING_STIFFNESS},
        "quadratic-drag": {"coefficient_n_s2_m2": eq.DRAG},
        "hardening-spring": {"cubic_n_m3": eq.CUBIC},
        "spring-damping": {"damping_n_s_m": eq.SPRING_DAMPING},
        "spring-hysteresis": {"stiffness_n_m": eq.SLIP_STIFFNESS, "slip_force_n": eq.SLIP_FORCE},
        "backlash": {"gap_m": eq.GAP},
        "series-compliance": {"stiffness_n_m": eq.SERIES},
        "voltage-saturation": {"bus_v": eq.BUS_V, "resistance_ohm": eq.RESISTANCE},
    }
    if effect == "torque-ripple":
        row[eq.RIPPLE], row[eq.RIPPLE_PHASE] = values["amplitude_n"], values["phase_rad"]
        # sin(N theta), theta = y / r.
        row[eq.RIPPLE_PER_M] = values["cycles_per_rev"] / travel_per_rad
        return True
    for key, column in columns.get(effect, {}).items():
        row[column] = values[key]
    return effect in columns


def leg_plant(scenario, scales, effects):
    """The true leg of a scenario: perturbed, with the hidden effects."""
    ground = GROUND | scenario["ground"] if "ground" in scenario else None
    masses = {}
    for name, values in effects.items():
        place, effect = name.split("/")
        if effect == "link-mass":
            masses[place] = (values["mass_kg"], values["at_m"])
        elif effect in ("contact-compliance", "ground-friction") and ground:
            ground |= values
    leg = mujoco_leg(scenario, masses)
    params = true_params(leg, scales)
    delays, limits = np.zeros(len(leg.names)), np.full(len(leg.names), math.inf)
    for name, values in effects.items():
        place, effect = name.split("/")
        if effect == "joint-stop":
            leg.stops[leg.joints.index(place), 2:] = values["stiffness_nm_rad"], values["damping_nm_s_rad"]
            continue
        if place not in leg.names:
            continue
        i = leg.names.index(place)
        if effect == "transport-delay":
            delays[i] = values["delay_s"]
        elif effect == "current-saturation":
            limits[i] = values["limit_a"]
        elif effect == "spring-setting":
            spec = read_toml(ASSETS / "actuators" / "thor-linear.toml")
            params[i, eq.STIFFNESS] *= spring_stiffness(spec, values["setting"]) / leg.coefficients[i].stiffness
        elif not put_in(effect, values, params[i], leg.coefficients[i].travel_per_rad):
            raise ValueError(f"{name} is not an effect that this simulator has")
    return Plant(leg, params, ground, delays, limits, scenario.get("gravity_m_s2", 9.81))


def run_leg(scenario, scales, effects, step_s=STEP_S, sample_s=1e-3):
    """One run of a leg: time and true channels."""
    plant = leg_plant(scenario, scales, effects)
    nominal_leg = mujoco_leg(scenario)
    nominal = Plant(nominal_leg, np.array([c.row() for c in nominal_leg.coefficients]), plant.ground)
    q, v, loads = start_of(scenario, plant)
    controller = Controller(scenario, nominal, q)
    return run(plant, q, v, loads, controller, scenario["duration_s"], sample_s, step_s, 1.0 / controller.spec["rate_hz"])


def excitation(name, time_s, rng):
    """The current of a bench run, A, one value for each sample."""
    t, n, end = time_s, len(time_s), time_s[-1]
    dt = t[1] - t[0]
    fade = np.clip((t - 0.1) / 0.4, 0.0, 1.0)

    def noise(low, high):
        spectrum = np.fft.rfft(rng.standard_normal(n))
        f = np.fft.rfftfreq(n, dt)
        spectrum[(f < low) | (f > high)] = 0.0
        x = np.fft.irfft(spectrum, n)
        return x / np.std(x)

    def chirp(low, high):
        rate = math.log(high / low) / end
        return np.sin(2.0 * math.pi * low * (np.exp(rate * t) - 1.0) / rate)

    def steps(every, largest):
        levels = rng.uniform(-largest, largest, int(end / every) + 2)
        levels[0] = 0.0
        return levels[(t / every).astype(int)]

    current = {
        "fit-chirp": lambda: 1.4 * chirp(0.5, 60.0) + 0.3 * noise(1.0, 80.0),
        "fit-steps": lambda: steps(0.4, 0.5) + 0.15 * noise(5.0, 60.0),
        "check-noise": lambda: 1.0 * noise(0.7, 40.0),
        "check-low": lambda: 0.45 * chirp(0.2, 3.0) + steps(0.7, 0.25),
    }[name]()
    return fade * current


def run_bench(current, time_s, scale, effects, step_s=STEP_S):
    """One run of the pendulum bench: true channels under the contract's names."""
    leg = mujoco_pendulum("stiff")
    params = true_params(leg, {"thor": scale})
    delays = np.zeros(1)
    for effect, values in effects.items():
        if effect == "transport-delay":
            delays[0] = values["delay_s"]
        elif not put_in(effect, values, params[0], leg.coefficients[0].travel_per_rad):
            raise ValueError(f"{effect} is not an effect that this simulator has")
    plant = Plant(leg, params, None, delays)
    dt = time_s[1] - time_s[0]
    command = lambda t, *_: current[[round(t / dt)]]
    zero = np.zeros(1)
    _, true = run(plant, zero, zero, zero, command, time_s[-1], dt, step_s, dt)
    names = {"force_1_n": "thor.force_1_n", "force_2_n": "thor.force_2_n", "motor_angle_rad": "thor.rotor_angle_rad",
             "joint_angle_rad": "joint.angle_rad"}
    return {"current_a": current} | {to: true[own] for to, own in names.items()}


def scenario_lines(scenario):
    return ["# Made by make.py. Keys: see thor-drop.toml and thor-swing.toml.", "", *toml_tables(scenario), ""]


def make(name, spec, out):
    """One campaign, written to out/name; returns its answer."""
    folder = out / name
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(spec["seed"])
    runs, sensors, scales = [], None, None
    for entry in spec["runs"]:
        run_name, role = entry[:2]
        keys = {"file": f"{run_name}.csv", "role": role}
        if spec["bench"] == "leg":
            scenario = entry[2]
            if scales is None:
                names = mujoco_leg(scenario).names
                scales = individual(names, rng)
            time_s, columns = run_leg(scenario, scales, spec["effects"], spec["step_s"])
            keys["scenario"] = f"{run_name}.toml"
            (folder / keys["scenario"]).write_text("\n".join(scenario_lines(scenario)), encoding="utf-8")
        else:
            scales = scales or individual(["thor"], rng)
            time_s = np.arange(round(spec["duration_s"] * spec["rate_hz"]) + 1) / spec["rate_hz"]
            current = np.round(excitation(run_name, time_s, rng), 4)
            columns = run_bench(current, time_s, scales["thor"], spec["effects"], spec["step_s"])
        if sensors is None:
            table = LEG_SENSORS if spec["bench"] == "leg" else BENCH_SENSORS
            sensors = Sensors(columns, table, rng, spec.get("force_noise"))
        write_csv(folder / keys["file"], time_s, columns, sensors)
        runs.append(keys)
    is_leg = spec["bench"] == "leg"
    head = {"name": name, "bench": spec["bench"]}
    head |= {"scenario": spec["scenario"]} if is_leg else {"actuator": "thor-linear"}
    head["sample_rate_hz"] = 1000.0 if is_leg else spec["rate_hz"]
    lines = ["# Made by make.py; what is hidden in it is not said here.", ""]
    lines += [f"{key} = {toml_value(value)}" for key, value in head.items()]
    # On a bench the current is the command itself, without a sensor.
    noise = {c: s for c, s in sensors.noise_std().items() if is_leg or c != "current_a"}
    lines += ["", "[noise_std]", *(f"{toml_key(c)} = {s}" for c, s in noise.items())]
    for keys in runs:
        lines += ["", "[[run]]", *(f"{key} = {toml_value(value)}" for key, value in keys.items())]
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return {"bench": spec["bench"], "effects": spec["effects"], "scale": scales, "sensors": sensors.errors()}


def write_answers(answers, out, shipped):
    if not shipped:
        path = out / "answers.json"
        before = json.loads(path.read_text()) if path.exists() else {}
        path.write_text(json.dumps(before | answers, indent=1) + "\n", encoding="utf-8")
        return
    lines = ["# What is hidden in the campaigns beside. Only the test that judges reads this file: do not look before you have",
             "# diagnosed them yourself. `scale`: true over nominal; `sensors`: gain and bias of the individual."]
    for name, answer in answers.items():
        lines += ["", f"[{name}]", f'bench = "{answer["bench"]}"', "", f"[{name}.effects]"]
        lines += [f"{toml_key(e)} = {toml_value(v)}" for e, v in answer["effects"].items()]
        for table in ("scale", "sensors"):
            lines += ["", f"[{name}.{table}]", *(f"{toml_key(k)} = {toml_value(v)}" for k, v in answer[table].items())]
    (out / "answers.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", choices=SETS, default="shipped")
    parser.add_argument("-o", metavar="DIR", type=pathlib.Path)
    parser.add_argument("--others", metavar="N", type=int, default=0, help="other individuals: adds N to every seed")
    parser.add_argument("name", nargs="*", help="only these campaigns of the set")
    arguments = parser.parse_args()
    shipped = arguments.set == "shipped" and arguments.o is None
    if arguments.others and arguments.o is None:
        parser.error("-o DIR is needed for other individuals")
    if arguments.o is None and not shipped:
        parser.error("-o DIR is needed for sets that are not shipped")
    if shipped and arguments.name:
        parser.error("the shipped campaigns share one answers.toml: all or none, or elsewhere with -o DIR")
    out = arguments.o or HOUSE
    answers = {}
    for name, spec in SETS[arguments.set].items():
        if arguments.name and name not in arguments.name:
            continue
        start = time.time()
        answers[name] = make(name, spec | {"seed": spec["seed"] + arguments.others}, out)
        write_answers(answers, out, shipped)
        print(f"{name}: {len(spec['runs'])} runs, {time.time() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
