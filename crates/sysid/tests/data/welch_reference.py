"""Values of scipy's Welch estimates on a signal that any language can make again bit by bit.

    python3 -m venv venv && venv/bin/pip install scipy && venv/bin/python welch_reference.py > welch_reference.csv

One line per configuration and frequency: name, frequency (Hz), S_xx, S_yy, Re S_xy, Im S_xy, coherence.
"""

import numpy
import scipy
from scipy import signal

RATE_HZ = 400.0
SAMPLES = 2000


def uniform(seed):
    """Numbers in [-0.5, 0.5) of a 31-bit linear congruential generator."""
    state = seed
    while True:
        state = (1103515245 * state + 12345) % 2**31
        yield state / 2**31 - 0.5


def signals():
    """Noise on an offset and a slope, and its response by a resonant recursion with noise of its own."""
    first, second = uniform(1), uniform(2)
    x, y = [], []
    y1 = y2 = 0.0
    for n in range(SAMPLES):
        u = next(first)
        y0 = 1.5 * y1 - 0.8 * y2 + 0.3 * u
        x.append(u + 0.2 + 0.0005 * n)
        y.append(y0 + 0.1 * next(second) - 0.4)
        y1, y2 = y0, y1
    return x, y


CONFIGURATIONS = [
    # name, window, segment, overlap, detrend
    ("hann", "hann", 128, 64, "constant"),
    ("hamming", "hamming", 128, 32, "linear"),
    ("flat-top", "flattop", 100, 75, "constant"),
    ("rectangular", "boxcar", 125, 0, False),
]

if __name__ == "__main__":
    x, y = (numpy.array(v) for v in signals())
    print(f"# scipy {scipy.__version__}; made by welch_reference.py")
    print("configuration,frequency_hz,input,output,cross_re,cross_im,coherence")
    for name, window, segment, overlap, detrend in CONFIGURATIONS:
        how = dict(fs=RATE_HZ, window=window, nperseg=segment, noverlap=overlap, detrend=detrend)
        f, sxx = signal.welch(x, **how)
        _, syy = signal.welch(y, **how)
        _, sxy = signal.csd(x, y, **how)
        _, coherence = signal.coherence(x, y, **how)
        for i in range(len(f)):
            values = (f[i], sxx[i], syy[i], sxy[i].real, sxy[i].imag, coherence[i])
            print(name + "," + ",".join(f"{v:.12e}" for v in values))
