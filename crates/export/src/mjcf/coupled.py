

class Coupled(Drive):
    """A drive whose rotor meets its joint at a spring, or in a transmission that yields or has play."""

    coupled = True
    # Travel y per motion of the joint.
    lever = 1.0
    # Damping of gears while their play is closed, and half of that.
    contact_damping = half_gap = 0.0

    def __init__(self, model, joint):
        super().__init__(model, joint)
        rotor = model.joint(joint + "_rotor")
        self.position, self.rate = rotor.qposadr[0], rotor.dofadr[0]
        self.deflection = model.tendon(joint + "_deflection").id

    def output(self, data):
        return self.lever * data.qpos[self.joint_position], self.lever * data.qvel[self.joint_rate]

    def touch(self, data):
        """Adds that damping."""
        if self.contact_damping and abs(data.ten_length[self.deflection]) > self.half_gap:
            force = self.contact_damping * data.ten_velocity[self.deflection]
            data.qfrc_passive[self.rate] -= force
            data.qfrc_passive[self.joint_rate] += self.lever * force

    def load(self, data):
        return self.spring_force(data.ten_length[self.deflection], data.ten_velocity[self.deflection], data)
