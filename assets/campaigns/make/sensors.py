"""Sensors with noise, quantisation, gain and bias, and the files of a campaign."""

import math

import numpy as np

# unit suffix or channel -> noise (one standard deviation), count, spread of gain, spread of bias, decimals in the file
LEG_SENSORS = {
    "force": dict(noise=2.0, count=0.0, gain=0.01, bias=3.0, decimals=1),
    "foot.normal_force_n": dict(noise=10.0, count=0.0, gain=0.01, bias=5.0, decimals=1),
    "current_a": dict(noise=0.01, count=0.0, gain=0.0, bias=0.0, decimals=3),
    # A leg's rotors: Hall sensors interpolated; a bench has an encoder.
    "rotor_angle_rad": dict(noise=0.02, count=2.0 * math.pi / 256, gain=0.0, bias=0.0, decimals=3),
    "angle_rad": dict(noise=1e-4, count=2.0 * math.pi / 16384, gain=0.0, bias=1e-3, decimals=5),
    "base.height_m": dict(noise=1e-4, count=0.0, gain=0.002, bias=5e-4, decimals=5),
}
BENCH_SENSORS = {
    "force": dict(noise=2.0, count=0.0, gain=0.01, bias=3.0, decimals=1),
    "motor_angle_rad": dict(noise=0.0, count=2.0 * math.pi / 4096, gain=0.0, bias=0.0, decimals=4),
    "joint_angle_rad": dict(noise=0.0, count=2.0 * math.pi / 65536, gain=0.0, bias=0.0, decimals=5),
    "current_a": dict(noise=0.0, count=0.0, gain=0.0, bias=0.0, decimals=4),
}


class Sensors:
    """One individual sensor for each column, the same in all runs of a campaign."""

    def __init__(self, columns, table, rng, force_noise=None):
        self.rng = rng
        self.table = {}
        for column in columns:
            kind = next(k for k in table if column == k or column.endswith("." + k) or (k == "force" and "force_" in column
                                                                                  and column != "foot.normal_force_n"))
            law = dict(table[kind])
            if kind == "force" and force_noise:
                law["noise"] = force_noise
            law["gain"] = 1.0 + law["gain"] * rng.uniform(-1.0, 1.0)
            law["bias"] = law["bias"] * rng.uniform(-1.0, 1.0)
            self.table[column] = law

    def read(self, column, true):
        law = self.table[column]
        value = law["gain"] * true + law["bias"] + law["noise"] * self.rng.standard_normal(len(true))
        return np.round(value / law["count"]) * law["count"] if law["count"] > 0.0 else value

    def noise_std(self):
        """Of noise, count and last printed digit together."""
        result = {}
        for column, law in self.table.items():
            parts = [law["noise"] ** 2, law["count"] ** 2 / 12.0, 10.0 ** (-2 * law["decimals"]) / 12.0]
            result[column] = float(f"{math.sqrt(sum(parts)):.3g}")
        return result

    def errors(self):
        """Gain and bias by column, where there is one."""
        return {c: dict(gain=round(l["gain"], 6), bias=round(l["bias"], 6)) for c, l in self.table.items()
                if l["gain"] != 1.0 or l["bias"] != 0.0}


def write_csv(path, time_s, columns, sensors):
    lines = ["time_s," + ",".join(columns)]
    read = [[f"{v:.{sensors.table[c]['decimals']}f}" for v in sensors.read(c, true)] for c, true in columns.items()]
    read = [[cell.lstrip("-") if float(cell) == 0.0 else cell for cell in column] for column in read]
    for row in zip((f"{t:.4f}".rstrip("0").rstrip(".") for t in time_s), *read):
        lines.append(",".join(row))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(v) for v in value) + "]"
    return repr(float(value)) if isinstance(value, float) else str(value)


def toml_key(key):
    return key if all(c.isalnum() or c in "-_" for c in key) else f'"{key}"'


def toml_tables(table, prefix=""):
    """Lines of a TOML file: plain values, then one table after the other; a table of plain values two levels down stays inline."""
    lines = [f"{toml_key(k)} = {toml_value(v)}" for k, v in table.items() if not isinstance(v, dict)]
    for key, value in table.items():
        if not isinstance(value, dict):
            continue
        if prefix.count(".") >= 1 and all(not isinstance(v, dict) for v in value.values()):
            lines.append(f"{toml_key(key)} = {toml_value(value)}")
            continue
        name = f"{prefix}{toml_key(key)}"
        lines += ["", f"[{name}]", *toml_tables(value, name + ".")]
    return lines
