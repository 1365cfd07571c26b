"""Questions of the exam as arrays, and the declared model's residual."""

import csv
import tomllib
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import butter, filtfilt, lfilter

ACTUATOR = ("gain", "delay_ms", "lag_ms", "offset_mm")
SPECIMEN = ("stiffness_n_per_mm", "damping_n_s_per_mm", "mass_kg", "offset_n")
IDEAL = {"gain": 1.0}


@dataclass
class Channel:
    """One half of a record: the model's residual, the noise at rest, and the signals for regressors."""

    name: str
    residual: np.ndarray
    sigma: float
    moving: np.ndarray
    t: np.ndarray
    h: float
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    base: np.ndarray
    force: np.ndarray
    parameters: dict
    # By how much each may still fall and rise.
    room: dict


def read(folder):
    with open(folder / "model.toml", "rb") as file:
        model = tomllib.load(file)
    train = np.loadtxt(folder / "train.csv", delimiter=",", skiprows=1, unpack=True)
    with open(folder / "rest.csv", newline="") as file:
        rest = [(float(r["from_s"]), float(r["to_s"])) for r in csv.DictReader(file)]
    return model, train, rest


def low_passed(y, h, hz):
    b, a = butter(4, min(0.9, 2.0 * h * hz))
    return filtfilt(b, a, y)


def ram(p, t, u, h):
    """Displacement of an actuator with these gain, delay, lag and offset."""
    gain, delay_ms, lag_ms, offset = p
    late = np.interp(t - 1e-3 * delay_ms, t, u)
    pole = np.exp(-h / max(1e-3 * lag_ms, 1e-6))
    return gain * lfilter([1.0 - pole], [1.0, -pole], late, zi=[pole * late[0]])[0] + offset


def spring(p, x, v, a):
    """Force of a specimen with these stiffness, damping, mass and offset."""
    return p[0] * x + p[1] * v + 1e-3 * p[2] * a + p[3]


def refitted(names, declared, predict, target, where):
    """Declared parameters inside three tolerances at their best where `where` says, and how far each may still go."""
    value = np.array([float(declared.get(n, {}).get("value", IDEAL.get(n, 0.0))) for n in names])
    room = 3.0 * np.array([declared.get(n, {}).get("tolerance", 0.0) for n in names])
    free = room > 0.0

    def all_of(part):
        p = value.copy()
        p[free] += part * room[free]
        return p

    left = lambda part: (target - predict(all_of(part)))[where]
    fitted = all_of(least_squares(left, np.zeros(free.sum()), bounds=(-1, 1)).x)
    parameters = dict(zip(names, fitted))
    return parameters, dict(zip(names, zip(value - room - fitted, value + room - fitted)))


def channels(folder):
    """Actuator and specimen, each with its declared parameters refitted inside three tolerances."""
    model, (t, u, x, f), rest = read(folder)
    h = (t[-1] - t[0]) / (len(t) - 1)
    still = np.zeros(len(t), bool)
    for begin, end in rest:
        still |= (t >= begin) & (t <= end)
    # Twice the highest frequency of any excitation in the exam.
    smooth = low_passed(x, h, 30.0)
    v = np.gradient(smooth, h)
    a = np.gradient(v, h)

    def channel(name, names, declared, predict, target, **more):
        parameters, left = refitted(names, declared, predict, target, slice(None, None, 4))
        base = predict(list(parameters.values()))
        residual = target - base
        sigma = np.std(np.concatenate([residual[(t >= b) & (t <= e)] for b, e in rest[:1]]))
        return Channel(
            name, residual, sigma, ~still, t, h, base=base, force=f, parameters=parameters, room=left, **more
        )

    first = channel("actuator", ACTUATOR, model["actuator"], lambda p: ram(p, t, u, h), x, x=None, v=None, a=None)
    first.x = first.base
    first.v = np.gradient(first.x, h)
    first.a = np.gradient(first.v, h)
    declared = model["specimen"]
    second = channel("specimen", SPECIMEN, declared, lambda p: spring(p, smooth, v, a), f, x=smooth, v=v, a=a)
    return [first, second]
