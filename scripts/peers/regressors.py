"""The candidate regressors of a residual, each under the name of its effect.

Every peer gets the same: for each effect its textbook column, at two or three values of a shape parameter if there is one. A
column shared with a declared parameter is named only as far as its coefficient takes the parameter beyond three tolerances,
as in the diagnosis. Of identical columns one is kept.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, lfilter


def lagged(y, time_s, h):
    pole = np.exp(-h / time_s)
    return lfilter([1.0 - pole], [1.0, -pole], y, zi=[pole * y[0]])[0]


def play(x, width):
    """The output of a play of +-width."""
    out = np.empty_like(x)
    at = x[0]
    for i, value in enumerate(x):
        at = min(max(at, value - width), value + width)
        out[i] = at
    return out


def resonant(y, hz, ratio, h):
    w = 2.0 * np.pi * hz
    # Backward differences: stable at every rate.
    a0 = 1.0 + 2.0 * ratio * w * h + (w * h) ** 2
    return lfilter([(w * h) ** 2 / a0], [1.0, -(2.0 + 2.0 * ratio * w * h) / a0, 1.0 / a0], y)


@dataclass
class Column:
    """A regressor; `allowed`: coefficients that name nothing."""

    name: str
    values: np.ndarray
    negative: str = ""
    allowed: tuple = (0.0, 0.0)

    def named(self, coefficient):
        """The effect, and the part of the coefficient that is one."""
        low, high = self.allowed
        beyond = max(coefficient - high, 0.0) + min(coefficient - low, 0.0)
        return (self.negative or self.name) if beyond < 0.0 else self.name, beyond


def columns(c):
    x, v, t, h = c.x, c.v, c.t, c.h
    swing = np.max(np.abs(x))
    speed = np.std(v[c.moving])
    one = np.ones_like(t)
    warm = 1.0 - np.exp(-t / (0.3 * t[-1]))
    parts = []

    def add(name, *these, **more):
        parts.extend(Column(name, values, **more) for values in these)

    def declared(name, parameter, values, unit=1.0):
        add(name, values, allowed=tuple(r / unit for r in c.room[parameter]))

    if c.name == "actuator":
        lag_s = max(1e-3 * c.parameters["lag_ms"], h)
        gain = c.parameters["gain"]
        declared("gain_error", "gain", c.base / gain)
        declared("delay_error", "delay_ms", -v, 1e3)
        declared("lag_error", "lag_ms", -lagged(v, lag_s, h), 1e3)
        declared("offset", "offset_mm", one)
        add("second_lag", *(lagged(x, s, h) - x for s in (5e-3, 15e-3)))
        add("oil_column", *(resonant(x, hz, 0.2, h) - x for hz in (15.0, 40.0)))
        add("rig_compliance", -c.force)
        add("asymmetric_actuator", np.abs(v), np.maximum(v, 0.0))
        add("rate_limit", *(v - np.clip(v, -s * speed, s * speed) for s in (1.0, 1.5)))
    else:
        declared("gain_error", "stiffness_n_per_mm", x)
        declared("viscous_damping", "damping_n_s_per_mm", v)
        declared("inertia_force", "mass_kg", c.a, 1e3)
        declared("offset", "offset_n", one)
        add("quadratic_damping", v * np.abs(v))
        add("maxwell_damper", *(x - lagged(x, s, h) for s in (5e-3, 20e-3, 80e-3)))
        add("hardening", x**3, x * np.abs(x), negative="softening")
        add("asymmetric_stiffness", x**2, np.maximum(x, 0.0))
        fade = (np.exp(-((v / (s * speed)) ** 2)) for s in (0.3, 1.0))
        add("stribeck_friction", *(np.tanh(v / (0.05 * speed)) * f for f in fade))
        add("bilinear_hysteresis", *(x - play(x, w * swing) for w in (0.1, 0.3)))
        add("bouc_wen_hysteresis", *(lagged(x - play(x, w * swing), 5e-3, h) for w in (0.1, 0.3)))
        add("slip_gap", *(np.clip(x, -w * swing, w * swing) * (x * v > 0.0) for w in (0.1, 0.3)))
    add("drift", t, warm)
    add("temperature_gain", c.base * t, c.base * warm)
    add("coulomb_friction", *(np.tanh(v / (s * speed)) for s in (0.02, 0.2)))
    add("backlash", *(play(x, w * swing) - x for w in (0.01, 0.05)))
    add("dead_band", *(-np.clip(x, -w * swing, w * swing) for w in (0.02, 0.1)))
    add("saturation", *(np.clip(x, -w * swing, w * swing) - x for w in (0.7, 0.85)))
    for hz in (50.0, 60.0):
        add("mains_hum", np.sin(2.0 * np.pi * hz * t), np.cos(2.0 * np.pi * hz * t))
    step = lattice(c.residual + c.base)
    if step > 0.0:
        add("quantisation", step * np.round(c.base / step) - c.base)
    return parts


def lattice(y):
    """The step of the converter, if the values show one."""
    values = np.unique(y)
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-9 * np.ptp(y)]
    if len(gaps) == 0 or len(values) > 0.5 * len(y):
        return 0.0
    return float(np.median(gaps))


# Columns with a larger correlation count as identical.
SAME = 0.99999


def library(c):
    """Columns, a matrix of them with mean square 1, their sizes, and the residual; both in units of the noise."""
    parts = [p for p in columns(c) if np.any(p.values)]
    matrix = np.column_stack([p.values for p in parts])
    size = np.sqrt(np.mean(matrix**2, axis=0))
    matrix /= size
    alike = np.abs(matrix.T @ matrix) / len(matrix) > SAME
    keep = [i for i in range(len(parts)) if not alike[i, :i].any()]
    sigma = max(c.sigma, 1e-12)
    return [parts[i] for i in keep], matrix[:, keep], size[keep] / sigma, c.residual / sigma
