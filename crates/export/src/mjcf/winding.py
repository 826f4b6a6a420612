

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
