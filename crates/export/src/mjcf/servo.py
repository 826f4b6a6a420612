

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
