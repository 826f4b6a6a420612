"""arm with its drives for MuJoCo 4: what arm.xml has no element for

held         rotors: armature and damping of their joints
held         command shoulder.torque_nm: actuator 'shoulder', in the column's unit
held         command elbow.torque_nm: actuator 'elbow', in the column's unit
callback     sensors: arm.py: Robot(model).channels(data) gives them as a campaign calls them
held         shoulder/coulomb-friction: frictionloss of the joint 'shoulder'
callback     elbow/load-dependent-friction: arm.py: sets the frictionloss of the joint 'elbow' at every step
lost         elbow/dahl-friction: this writer has no element for it at a drive without a spring
approximate  joint limits: range of the joints as the URDF states it: the model itself has no stops
lost         friction in the URDF: at elbow: the model's friction is that of its effects

Use, every callback being put in after the model has been loaded:

    model = mujoco.MjModel.from_xml_path("arm.xml")
    data = mujoco.MjData(model)
    robot = arm.Robot(model)
    data.actuator("shoulder").ctrl = 0.1  # shoulder.torque_nm
    data.actuator("elbow").ctrl = 0.1  # elbow.torque_nm
    mujoco.mj_step(model, data)
    robot.channels(data)
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


class Drive1(Drive):
    """The drive of the joint 'shoulder'."""


class Drive2(Drive):
    """The drive of the joint 'elbow'."""

    def friction(self, y, speed, direction, load):
        return 0.05 * abs(load())


class Robot:
    """The drives with their sensors, and the callbacks."""

    def __init__(self, model):
        self.model = model
        self.signature = model.signature
        self.drives = [
            Drive1(model, "shoulder"),
            Drive2(model, "elbow"),
        ]
        self.stages = stages()
        mujoco.set_mjcb_control(self._control)

    def _control(self, model, data):
        if model.signature != self.signature:
            return
        for drive in self.drives:
            if drive.quantised:
                data.ctrl[drive.motor] = drive.quantised(data.ctrl[drive.motor])
            if drive.friction:
                drive.rub(data)

    def channels(self, data):
        """The channels at this instant, before the sensors, as a campaign calls them."""
        mujoco.mj_forward(self.model, data)
        channels = {}
        drive = self.drives[0]
        channels["shoulder.angle_rad"] = data.qpos[drive.joint_position]
        channels["shoulder.speed_rad_s"] = data.qvel[drive.joint_rate]
        channels["shoulder.motor_angle_rad"] = drive.motion(data)[0] / 0.1
        channels["shoulder.output_torque_nm"] = drive.load(data)
        drive = self.drives[1]
        channels["elbow.angle_rad"] = data.qpos[drive.joint_position]
        channels["elbow.speed_rad_s"] = data.qvel[drive.joint_rate]
        channels["elbow.motor_angle_rad"] = drive.motion(data)[0] / 0.1
        channels["elbow.output_torque_nm"] = drive.load(data)
        return channels

    def sense(self, data):
        """The channels behind the sensors: to be called after every step, and once before the first."""
        channels = self.channels(data)
        for name, stage in self.stages:
            channels[name] = stage.step(channels[name], self.model.opt.timestep)
        return channels
