

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
