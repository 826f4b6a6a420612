"""small on the pendulum bench for MuJoCo 4: what my-pendulum.xml has no element for

held         rotor: armature and damping of the joint 'screw', whose position is the screw's extension
held         command: actuator 'motor', in the unit of current_a
callback     load cells: my_pendulum.py: Bench(model).channels(data) gives the bench's channels
callback     stribeck-friction: my_pendulum.py: sets the frictionloss of the joint 'screw' at every step
callback     voltage-saturation: my_pendulum.py: takes from the motor's force what the voltage does not give
held         backlash: springlength of the tendon 'deflection' as a range, within which it has no force
held         series-compliance: body 'screw_end' between screw and output, on its own spring
callback     sensor-lag@force_1_n: my_pendulum.py: Bench(model).sense(data) passes the channels through it, step by step

Use, every callback being put in after the model has been loaded:

    model = mujoco.MjModel.from_xml_path("my-pendulum.xml")
    data = mujoco.MjData(model)
    bench = my_pendulum.Bench(model)
    data.ctrl[0] = 1.0  # current_a
    mujoco.mj_step(model, data)
    bench.channels(data)
"""

from math import atan, cos, exp, pi, sin, sqrt, tan, tanh  # noqa: F401
from math import log as ln  # noqa: F401

import mujoco
import numpy


def sign(x):
    return int(x > 0) - int(x < 0)


def square(x):
    return x * x



class Lag:
    """First-order low-pass, exact for a signal that is straight between the steps."""

    def __init__(self, cutoff_hz):
        self.angular, self.state = 2 * pi * cutoff_hz, None

    def step(self, value, h):
        if self.state is None:
            self.state = value
        else:
            x = self.angular * h
            decay = exp(-x)
            late = 1 - (1 - decay) / x
            self.state = decay * self.state + (1 - decay - late) * self.before + late * value
        self.before = value
        return self.state


class Late:
    """A sample tells of so long ago."""

    def __init__(self, delay_s):
        self.delay_s, self.past = delay_s, []

    def step(self, value, h):
        whole, part = divmod(self.delay_s / h, 1)
        self.past = [value] + self.past[: int(whole) + 1]

        def back(steps):
            return self.past[min(steps, len(self.past) - 1)]

        return (1 - part) * back(int(whole)) + part * back(int(whole) + 1)


class Mode:
    """A force multiplied by 1 + g p^2/(p^2 + 2 zeta w p + w^2), exact for one that is straight between the steps."""

    def __init__(self, frequency_hz, ratio, participation):
        self.w, self.ratio, self.participation, self.low = 2 * pi * frequency_hz, ratio, participation, None

    def step(self, value, h):
        if self.low is None:
            self.low, self.rate, self.before = value, 0.0, value
            return value
        decay, lag = self.ratio * self.w, 2 * self.ratio / self.w
        damped = self.w * sqrt(max(0.0, 1 - self.ratio**2))
        fall = exp(-decay * h)
        cosine, sine = (fall * cos(damped * h), fall * sin(damped * h) / damped) if damped > 0 else (fall, fall * h)
        slope = (value - self.before) / h
        apart, apart_rate = self.low - (self.before - lag * slope), self.rate - slope
        self.before = value
        self.low = value - lag * slope + apart * (cosine + decay * sine) + apart_rate * sine
        self.rate = slope - self.w**2 * sine * apart + apart_rate * (cosine - decay * sine)
        return value + self.participation * (value - self.low - lag * self.rate)


def stages():
    return [
        ("force_1_n", Lag(200)),
    ]


class Bench:
    """The bench's sensors, and its callbacks."""

    def __init__(self, model):
        self.model = model
        self.signature = model.signature
        self.deflection = model.tendon("deflection").id
        self.screw = model.joint("screw").qposadr[0]
        self.screw_rate = model.joint("screw").dofadr[0]
        self.screw_end = model.joint("screw_end").qposadr[0]
        self.screw_end_rate = model.joint("screw_end").dofadr[0]
        self.lever = model.joint("lever").qposadr[0]
        self.lever_rate = model.joint("lever").dofadr[0]
        self.stages = stages()
        mujoco.set_mjcb_control(self._control)
        self.buffer = numpy.zeros(1)
        mujoco.set_mjcb_passive(self._passive)

    def extension(self, data):
        """Extension y and speed of the screw."""
        return data.qpos[self.screw], data.qvel[self.screw_rate]

    def spring_force(self, data):
        """Force of the spring on link 1, positive in compression."""
        delta, delta_dot = data.ten_length[self.deflection], data.ten_velocity[self.deflection]
        left = delta - min(max(delta, -2e-5), 2e-5)
        force = 5e5 * left
        return force

    def screw_force(self, data):
        """Force in the screw, positive in compression, with the latest acceleration."""
        return self.spring_force(data) + 0.5 * (data.qacc[self.screw_rate] + -1 * data.qacc[self.screw_end_rate])

    def channels(self, data):
        """The bench's channels at this instant, before its sensors, as a campaign calls them."""
        mujoco.mj_forward(self.model, data)
        y, _ = self.extension(data)
        return {
            "force_1_n": self.spring_force(data),
            "force_2_n": 1e7 * (data.qpos[self.screw_end] - 0.1 * data.qpos[self.lever]),
            "motor_angle_rad": y / 0.001,
            "spring_deflection_m": data.ten_length[self.deflection],
            "joint_angle_rad": data.qpos[self.lever],
        }

    def sense(self, data):
        """The channels behind the sensors: to be called after every step, and once before the first."""
        channels = self.channels(data)
        for name, stage in self.stages:
            channels[name] = stage.step(channels[name], self.model.opt.timestep)
        return channels

    def _control(self, model, data):
        if model.signature != self.signature:
            return
        speed = data.qvel[self.screw_rate]
        pushed = data.actuator_force[0] - self.spring_force(data)
        direction = sign(speed if abs(speed) > 1e-8 else pushed)  # noqa: F841
        load = lambda: self.screw_force(data)  # noqa: E731, F841
        model.dof_frictionloss[self.screw_rate] = 20 + 20 * exp(-(speed / 0.004) ** 2)

    def _passive(self, model, data):
        if model.signature != self.signature:
            return
        y, y_dot = self.extension(data)
        t, F_bs = data.time, self.screw_force(data)  # noqa: F841
        theta, theta_dot = y / 0.001, y_dot / 0.001  # noqa: F841
        on_screw = 0.0
        commanded = force = 200 * data.ctrl[0] + 0
        low, high = (200 * (volts - 200 * y_dot) / 2 for volts in (-24, 24))
        force = min(max(force, low), high)
        on_screw += force - commanded
        data.qfrc_passive[self.screw_rate] += on_screw
