"""The scenarios' controller: joint-space PD through the moment arms, with the nominal numbers of the robot.

Like a robot's firmware it knows the nominal torque constant, damping, inertia and weights, not the true ones. Stiffness acts on
joint positions, damping on the joint speeds that the motors' speeds stand for.
"""

import math

import numpy as np

DEFAULTS = {"kind": "free", "rate_hz": 1000.0, "stiffness_nm_rad": 500.0, "damping_nm_s_rad": 20.0, "gravity_compensation": True,
            "feed_forward": True, "current_limit_a": math.inf}


def motion_at(motion, t, start):
    """Position, speed and acceleration of a joint's wanted motion."""
    # An acceleration that ends with a jump at a tick must not depend on the rounding of its time.
    t = round(t, 9)
    if motion is None:
        return start, 0.0, 0.0
    if motion["shape"] == "half-cosine":
        length = motion["duration_s"]
        f, df, ddf = half_cosine((t - motion.get("start_s", 0.0)) / length)
        way = motion["to_rad"] - start
        return start + way * f, way * df / length, way * ddf / length**2
    w = 2.0 * math.pi * motion["frequency_hz"]
    f, df, ddf = half_cosine(t * motion["frequency_hz"])
    df, ddf = df * motion["frequency_hz"], ddf * motion["frequency_hz"] ** 2
    sin, cos = math.sin(w * t + motion.get("phase_rad", 0.0)), math.cos(w * t + motion.get("phase_rad", 0.0))
    a = motion["amplitude_rad"]
    return start + a * f * sin, a * (df * sin + f * w * cos), a * (ddf * sin + 2.0 * df * w * cos - f * w * w * sin)


def half_cosine(s):
    if s <= 0.0:
        return 0.0, 0.0, 0.0
    if s >= 1.0:
        return 1.0, 0.0, 0.0
    p = math.pi * s
    return 0.5 * (1.0 - math.cos(p)), 0.5 * math.pi * math.sin(p), 0.5 * math.pi**2 * math.cos(p)


def least_force(arms, torques):
    """Actuator forces F with arms^T F nearest to the torques."""
    return np.linalg.lstsq(arms.T, torques, rcond=None)[0]


class Controller:
    """Currents (A) from true states, with the nominal plant's numbers."""

    def __init__(self, scenario, nominal, start_q):
        self.spec = DEFAULTS | scenario.get("controller", {})
        self.nominal, self.start_q = nominal, start_q
        leg = nominal.leg
        self.first = 1 if leg.rail else 0
        self.motion = [scenario.get("motion", {}).get(name) for name in leg.joints]
        gains = [self.spec | self.spec.get("joints", {}).get(name, {}) for name in leg.joints[self.first:]]
        self.stiffness = np.array([g["stiffness_nm_rad"] for g in gains])
        self.damping = np.array([g["damping_nm_s_rad"] for g in gains])
        self.c = leg.coefficients

    def weight(self, q):
        """Joint torques that hold the leg as it hangs from its base."""
        b = self.nominal.bodies
        b.at(q, np.zeros_like(q))
        return b.bias[self.first:].copy()

    def __call__(self, t, q, v, y, w):
        if self.spec["kind"] == "free":
            return np.zeros(len(self.c))
        first = self.first
        arms = self.nominal.arms(q, np.zeros_like(v))[0][:, first:]
        seen = np.linalg.lstsq(arms, w, rcond=None)[0]
        wanted = np.array([motion_at(self.motion[j], t, self.start_q[j]) for j in range(first, len(q))])
        torques = self.stiffness * (wanted[:, 0] - q[first:]) + self.damping * (wanted[:, 1] - seen)
        if self.spec["gravity_compensation"]:
            torques += self.weight(q)
        forces = least_force(arms, torques)
        if self.spec["feed_forward"]:
            forces += np.array([c.damping for c in self.c]) * (arms @ wanted[:, 1])
            forces += np.array([c.inertia for c in self.c]) * (arms @ wanted[:, 2])
        amps = forces / np.array([c.force_constant for c in self.c])
        return np.clip(amps, -self.spec["current_limit_a"], self.spec["current_limit_a"])


def start_of(scenario, plant):
    """Positions, speeds and spring forces at the start."""
    leg = plant.leg
    spec = scenario.get("start", {})
    q = np.array([spec.get("posture_rad", {}).get(name, 0.0) for name in leg.joints])
    v = np.array([spec.get("speed_rad_s", {}).get(name, 0.0) for name in leg.joints])
    first = 1 if leg.rail else 0
    if leg.rail:
        q[0] = 0.0
        plant.bodies.at(q, v)
        xpos, xmat = plant.bodies.data.xpos[leg.sole_body], plant.bodies.data.xmat[leg.sole_body].reshape(3, 3)
        lowest = min((xpos + xmat @ p)[2] for p in leg.sole)
        height = plant.ground["height_m"] if plant.ground else 0.0
        q[0] = height + spec.get("drop_height_m", 0.0) - lowest
    loads = np.zeros(len(leg.names))
    if spec.get("springs", "unloaded") == "balanced":
        arms = plant.arms(q, np.zeros_like(v))[0][:, first:]
        plant.bodies.at(q, np.zeros_like(q))
        loads = least_force(arms, plant.bodies.bias[first:].copy())
    return q, v, loads
