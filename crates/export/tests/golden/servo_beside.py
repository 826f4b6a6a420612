"""servo on the pendulum bench for MuJoCo 4: what servo.xml has no element for

held         rotors: armature and damping of their joints
held         command position_rad: actuator 'lever': gain, duty limit as forcerange; dcmotor 'lever_back_emf'
callback     supply, gain, enable: servo.py: drive.supply_v and drive.proportional may be set; drive.enabled = False opens the bridge. The file has 10 V and 4 per rad
callback     sensors: servo.py: Bench(model).channels(data) gives them as a campaign calls them
held         servo's command_delay_s: delay of the actuator 'lever', and half a step for its interpolation
callback     servo's duty_dead_zone: servo.py: takes the bridge's dead zone from the voltage
callback     load-dependent-friction: servo.py: sets the frictionloss of the joint 'lever' at every step
held         starts of the runs: keys, by the run's name: position and speed of every joint

Use, every callback being put in after the model has been loaded:

    model = mujoco.MjModel.from_xml_path("servo.xml")
    data = mujoco.MjData(model)
    bench = servo.Bench(model)
    data.actuator("lever").ctrl = 0.1  # position_rad
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


def stages():
    return []



class Drive:
    """A drive at a joint. Its travel y is `arm` times the position of its rotor's joint; its forces are those along y."""

    arm = 1.0
    # Whether the rotor has a joint of its own.
    coupled = False
    # Whether the command passes a delay.
    late = False
    # What a drive has of these is in its own class below.
    friction = quantised = beside = None

    def __init__(self, model, joint):
        self.model, self.joint = model, joint
        self.joint_position = self.position = model.joint(joint).qposadr[0]
        self.joint_rate = self.rate = model.joint(joint).dofadr[0]
        self.motor = model.actuator(joint).id
        self.buffer = numpy.zeros(1)
        self.through = numpy.zeros(model.nv)
        # A drive that is switched off makes no force, and no back-EMF.
        self.enabled = True
        self.reset()

    def reset(self):
        """Every run begins cold and without a memory."""
        self.time = self.heat = 0.0

    def motion(self, data):
        """Travel y and speed."""
        return self.arm * data.qpos[self.position], self.arm * data.qvel[self.rate]

    def output(self, data):
        """Travel and speed of the joint, as y."""
        return self.motion(data)

    def load(self, data):
        """Force that passes from the drive to what it moves, with the latest acceleration."""
        mujoco.mj_mulM(self.model, data, self.through, data.qacc)
        rotor = self.model.dof_armature[self.rate] * data.qacc[self.rate]
        return (self.through[self.rate] - rotor + data.qfrc_bias[self.rate]) / self.arm

    def command(self, data, ahead_s=0.0):
        """The command that is in force, or will be so soon."""
        if self.late:
            return mujoco.mj_readCtrl(self.model, data, self.motor, data.time + ahead_s, self.buffer, 1)[0]
        return data.ctrl[self.motor]

    def rub(self, data):
        """Sets the bound of the dry friction."""
        y, speed = self.motion(data)
        # Below this speed it is at rest, and friction opposes the push.
        pushed = -self.arm * data.qfrc_constraint[self.rate]
        direction = sign(speed if abs(speed) > 1e-8 else pushed)
        if data.time < self.time:
            self.reset()
        bound = self.model.dof_frictionloss[self.rate]
        self.heat += bound * abs(data.qvel[self.rate]) * (data.time - self.time)
        self.time = data.time
        bound = self.friction(y, speed, direction, lambda: self.load(data))
        self.model.dof_frictionloss[self.rate] = abs(self.arm) * bound


class Winding(Drive):
    """A drive whose command is a voltage."""

    constant = resistance_ohm = 1.0
    # Voltage at a duty of 1; set it to what is measured.
    supply_v = 0.0
    offset = 0.0

    def force(self, volts, y_dot):
        return self.constant * (volts - self.constant * y_dot) / self.resistance_ohm

    def volts(self, force, y_dot):
        return force * self.resistance_ohm / self.constant + self.constant * y_dot

    def asked(self, data, y, y_dot):
        """The voltage at the winding."""
        return self.command(data) + self.offset

    def held(self, data, y, y_dot):
        """What MuJoCo's own actuators make."""
        return self.force(self.command(data) + self.offset, y_dot)

    def limited(self, force, y_dot):
        return force

    def beside_motor(self, data, y, y_dot):
        """What the motor makes beside MuJoCo's own actuators."""
        made = 0.0
        if self.enabled:
            made = self.limited(self.force(self.asked(data, y, y_dot), y_dot), y_dot)
        return made - self.held(data, y, y_dot)


class Servo(Winding):
    """A drive with a position loop: duty = clamp(k_p e - k_d y' + k_i integral of e), e = goal - y."""

    proportional = derivative = integral = dead_band = feedback_delay_s = 0.0
    duty_limit = 1.0
    # Of the loop's own samples; None where it is continuous.
    period_s = None

    def __init__(self, model, joint):
        super().__init__(model, joint)
        # What MuJoCo's own actuator has; gain and supply may be set to others here.
        self.file = self.proportional * self.supply_v, self.derivative * self.supply_v, self.duty_limit * self.supply_v

    def reset(self):
        super().reset()
        self.loop_s, self.sum, self.held_duty, self.sample, self.past = 0.0, 0.0, 0.0, 0, []

    def held(self, data, y, y_dot):
        if self.coupled:
            return self.force(0.0, y_dot)
        proportional, derivative, most = self.file
        volts = proportional * (self.command(data) + self.offset - y) - derivative * y_dot
        return self.force(min(max(volts, -most), most), y_dot)

    def asked(self, data, y, y_dot):
        y, y_dot = self.output(data)
        # The file's delay is half a step longer, for the mean over a step: a loop that samples sees the command itself.
        ahead_s = 0.0 if self.period_s is None else 0.5 * self.model.opt.timestep
        return self.supply_v * self.duty(self.command(data, ahead_s), y, y_dot, data.time)

    def duty(self, goal, y, y_dot, time):
        """What the loop makes of the goal and of the motion that it sees."""
        if time < self.loop_s:
            self.reset()
        y, y_dot = self.seen(y, y_dot, time)
        span, self.loop_s = time - self.loop_s, time
        if self.period_s is not None:
            sample = int(time / self.period_s + 1e-9) + 1
            if sample == self.sample:
                return self.held_duty
            span, self.sample = (sample - self.sample) * self.period_s, sample
        error = goal + self.offset - y
        error -= min(max(error, -self.dead_band), self.dead_band)
        free = self.proportional * error - self.derivative * y_dot + self.integral * self.sum
        self.held_duty = min(max(free, -self.duty_limit), self.duty_limit)
        if self.held_duty == free:
            self.sum += error * span
        return self.held_duty

    def seen(self, y, y_dot, time):
        """The motion of so long ago."""
        if self.feedback_delay_s == 0:
            return y, y_dot
        if not self.past or time > self.past[-1][0]:
            self.past.append((time, y, y_dot))
        at = time - self.feedback_delay_s
        while len(self.past) > 2 and self.past[1][0] <= at:
            self.past.pop(0)
        (from_s, y, y_dot), *rest = self.past
        if not rest or at <= from_s:
            return y, y_dot
        part = (at - from_s) / (rest[0][0] - from_s)
        return y + part * (rest[0][1] - y), y_dot + part * (rest[0][2] - y_dot)


class Drive1(Servo):
    """The drive of the joint 'lever'."""

    late = True
    constant = 0.5
    resistance_ohm = 2
    supply_v = 10
    proportional = 4
    duty_limit = 0.8

    def friction(self, y, speed, direction, load):
        return 0.1 * abs(load())

    def limited(self, force, y_dot):
        asked = self.volts(force, y_dot)
        force = self.force(asked - min(max(asked, -0.5), 0.5), y_dot)
        return force

    def beside(self, data):
        """Force along y that MuJoCo's own elements do not make."""
        y, y_dot = self.motion(data)
        beside = self.beside_motor(data, y, y_dot)
        return beside


class Bench:
    """The drives with their sensors, and the callbacks."""

    def __init__(self, model):
        self.model = model
        self.signature = model.signature
        self.drives = [
            Drive1(model, "lever"),
        ]
        self.stages = stages()
        mujoco.set_mjcb_control(self._control)
        mujoco.set_mjcb_passive(self._passive)

    def _control(self, model, data):
        if model.signature != self.signature:
            return
        for drive in self.drives:
            if drive.quantised:
                data.ctrl[drive.motor] = drive.quantised(data.ctrl[drive.motor])
            if drive.friction:
                drive.rub(data)

    def _passive(self, model, data):
        if model.signature != self.signature:
            return
        for drive in self.drives:
            if drive.beside:
                data.qfrc_passive[drive.rate] += drive.arm * drive.beside(data)

    def channels(self, data):
        """The channels at this instant, before the sensors, as a campaign calls them."""
        mujoco.mj_forward(self.model, data)
        channels = {}
        drive = self.drives[0]
        channels["motor_angle_rad"] = drive.motion(data)[0] / 1
        channels["joint_angle_rad"] = data.qpos[drive.joint_position]
        channels["output_torque_nm"] = drive.load(data)
        channels["speed_rad_s"] = data.qvel[drive.joint_rate]
        return channels

    def sense(self, data):
        """The channels behind the sensors: to be called after every step, and once before the first."""
        channels = self.channels(data)
        for name, stage in self.stages:
            channels[name] = stage.step(channels[name], self.model.opt.timestep)
        return channels
