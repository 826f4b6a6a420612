"""Steps a leg or a bench: explicit midpoint rule at 20 us, the controller or a command in the loop.

The midpoint rule is of second order; at 20 us halving the step changes what the sensors see by far less than their noise
(measured by `verify.py`, stated in the README beside).
"""

import math
from dataclasses import dataclass, field

import mujoco
import numpy as np

import equations as eq

STEP_S = 20e-6

GROUND = {"height_m": 0.0, "friction": 0.8, "stiffness_n_m_n": 2.77e6, "exponent": 1.5, "damping_s_m": 0.5,
          "bristle_stiffness_n_m": 87.5e3, "bristle_damping_n_s_m": 125.0}


@dataclass
class Bodies:
    """MuJoCo as the provider of poses, mass matrix and bias."""

    model: mujoco.MjModel

    def __post_init__(self):
        self.data = d = mujoco.MjData(self.model)
        n = self.model.nv
        self.mass, self.bias = np.zeros((n, n)), np.zeros(n)
        self.views = d.xpos, d.xmat, d.xaxis, d.xanchor

    def at(self, q, v):
        m, d = self.model, self.data
        d.qpos[:] = q
        d.qvel[:] = v
        mujoco.mj_kinematics(m, d)
        mujoco.mj_comPos(m, d)
        mujoco.mj_makeM(m, d)
        mujoco.mj_comVel(m, d)
        mujoco.mj_rne(m, d, 0, self.bias)
        mujoco.mj_fullM(m, d, self.mass)


@dataclass
class Plant:
    """A leg with its true numbers: `params` by actuator (columns of `equations`), ground, delays of the drives."""

    leg: object
    params: np.ndarray
    ground: dict = None
    delays_s: np.ndarray = None
    limits_a: np.ndarray = None
    gravity: float = 9.81
    bodies: Bodies = field(init=False)

    def __post_init__(self):
        self.bodies = Bodies(self.leg.model)
        m = len(self.leg.names)
        self.delays_s = np.zeros(m) if self.delays_s is None else self.delays_s
        self.limits_a = np.full(m, np.inf) if self.limits_a is None else self.limits_a
        if self.ground is None:
            self.sole, self.g = np.zeros((0, 3)), np.zeros(7)
        else:
            self.sole, self.g = self.leg.sole, np.array([self.ground[key] for key in GROUND])

    def arms(self, q, v):
        """dL/dq (m x n) and lengths at a pose."""
        leg, b = self.leg, self.bodies
        b.at(q, v)
        n, m = leg.model.nv, len(leg.names)
        arms, lengths, rates = np.zeros((m, n)), np.zeros(m), np.zeros(m)
        carrier, extra = np.zeros(n), np.zeros(n)
        for i in range(m):
            lengths[i], rates[i], _, _ = eq.reach(i, *leg.arrays(), q, v, *b.views, leg.slides, leg.moves, self.gravity,
                                                  arms[i], carrier, extra)
        return arms, lengths, rates


def rest_deflection(p, force):
    """Deflection at which the spring carries a force, m."""
    if p[eq.CUBIC] != 0.0 and force != 0.0:
        low, high = sorted((0.0, force / p[eq.STIFFNESS]))
        roots = np.roots([p[eq.CUBIC], 0.0, p[eq.STIFFNESS], -force])
        left = next(r.real for r in roots if abs(r.imag) < 1e-12 and low - 1e-12 <= r.real <= high + 1e-12)
    else:
        left = force / p[eq.STIFFNESS]
    return left + math.copysign(0.5 * p[eq.GAP], force) if force != 0.0 else 0.0


def run(plant, q, v, loads, command, duration_s, sample_s, step_s=STEP_S, command_s=1e-3):
    """Steps from the start (positions, speeds, spring forces) under `command(t, q, v, y, w) -> A`, which holds for `command_s`.

    Returns time and channels by name (true values, without sensors).
    """
    leg, b, params = plant.leg, plant.bodies, plant.params
    n, m = leg.model.nv, len(leg.names)
    _, lengths, rates = plant.arms(q, v)
    x = np.zeros(2 * n + 6 * m + 2 * len(plant.sole))
    x[:n], x[n:2 * n] = q, v
    at = 2 * n
    x[at + m:at + 2 * m] = rates
    series = params[:, eq.SERIES] > 0.0
    x[at + 2 * m:at + 3 * m][series] = loads[series] / params[series, eq.SERIES]
    s = x[at + 2 * m:at + 3 * m]
    # y is 0 at the start: the length that leaves the springs unloaded follows.
    rest = lengths + s + np.array([rest_deflection(params[i], loads[i]) for i in range(m)])
    mode = np.where(rates > 0.0, 1, np.where(rates < 0.0, -1, 0)).astype(np.int64)
    load = loads.copy()
    dx, mid, out, scrap = np.zeros_like(x), np.zeros_like(x), np.zeros(2 * m + 1), np.zeros(2 * m + 1)
    current = np.zeros(m)
    fixed = (params, *leg.arrays(), rest, leg.stops, plant.g, leg.sole_body, plant.sole, plant.gravity, b.mass, b.bias, *b.views,
             leg.slides, leg.moves)

    def leaving(i, first):
        """Acceleration of a screw's end at the start under the first command, m/s^2."""
        b.at(x[:n], x[n:2 * n])
        eq.rhs(x, dx, scrap, mode.copy(), load.copy(), True, first, *fixed)
        return dx[at + 3 * m + i]

    # A compliant screw's end begins at rest, too, under what it carries; the spring keeps its load.
    if series.any():
        first = command(0.0, x[:n], x[n:2 * n], x[at:at + m], x[at + m:at + 2 * m])
        first = np.clip(first, -plant.limits_a, plant.limits_a)
        for i in list(np.flatnonzero(series)) * 3:
            nudge, before = 1e-6, leaving(i, first)
            s[i] += nudge
            rest[i] += nudge
            after = leaving(i, first)
            more = -after * nudge / (after - before)
            s[i] += more
            rest[i] += more
    steps = round(duration_s / step_s)
    per_command, per_sample = round(command_s / step_s), round(sample_s / step_s)
    late = np.rint(plant.delays_s / step_s).astype(int)
    given = np.zeros((steps // per_command + 1, m))
    times, rows = [], []
    for k in range(steps + 1):
        if k % per_command == 0:
            y, w = x[at:at + m], x[at + m:at + 2 * m]
            given[k // per_command] = np.clip(command(k * step_s, x[:n], x[n:2 * n], y, w), -plant.limits_a, plant.limits_a)
        for i in range(m):
            # What was on its way when the run began is what the leg was held with: the first command.
            current[i] = given[max(k - late[i], 0) // per_command, i]
        b.at(x[:n], x[n:2 * n])
        eq.rhs(x, dx, out, mode, load, True, current, *fixed)
        if k % per_sample == 0:
            times.append(k * step_s)
            rows.append(np.concatenate([x[:n], out, given[k // per_command], x[at:at + m]]))
        np.multiply(dx, 0.5 * step_s, out=mid)
        mid += x
        b.at(mid[:n], mid[n:2 * n])
        eq.rhs(mid, dx, scrap, mode, load, False, current, *fixed)
        dx *= step_s
        x += dx
        eq.finish(x, n, m, mode, params)
    if not np.all(np.isfinite(x)):
        raise ArithmeticError("the run is not finite")
    rows = np.array(rows)
    columns = {}
    for j, name in enumerate(leg.joints):
        columns["base.height_m" if name == "rail" else f"{name}.angle_rad"] = rows[:, j]
    for i, name in enumerate(leg.names):
        columns[f"{name}.force_1_n"] = rows[:, n + i]
        columns[f"{name}.force_2_n"] = rows[:, n + m + i]
        columns[f"{name}.current_a"] = rows[:, n + 2 * m + 1 + i]
        columns[f"{name}.rotor_angle_rad"] = rows[:, n + 3 * m + 1 + i] / leg.coefficients[i].travel_per_rad
    if plant.ground is not None:
        columns["foot.normal_force_n"] = rows[:, n + 2 * m]
    return np.array(times), columns
