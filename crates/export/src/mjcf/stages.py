

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
