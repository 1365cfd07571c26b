"""Peers on open third-party records, compared with `outerloop diagnose`. Called by scripts/outside-peers.

Each peer learns from the training spans and is judged on the held-out ones, as the diagnosis is. Those that pick columns get
the same as in the exam: residual, regressors, and the noise that the diagnosis estimated from the record, since they have
no means to. Two more only predict: a free-running NARX model names nothing, and a Bouc-Wen element beside the declared
model, fitted by least squares, always names the same.
"""

import json
import subprocess
import sys
import tomllib
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS

import methods
import records
import regressors

# Tried low-pass cut-offs of the displacement, as multiples of the motion's band (nine tenths of the speed's power).
CUTOFFS = tuple(2.0**i for i in range(1, 10))


@dataclass
class Question:
    """A record, evenly sampled, with its samples for training and for judging."""

    case: dict
    model: dict
    t: np.ndarray
    h: float
    given: np.ndarray
    target: np.ndarray
    train: np.ndarray
    test: np.ndarray


def question(folder, case):
    file = case["train"][0].split("@")[0]
    with open(folder / file) as lines:
        heads = next(line for line in lines if not line.startswith("#")).strip().split(",")
        data = np.loadtxt(lines, delimiter=",", unpack=True)
    t = data[0]
    h = (t[-1] - t[0]) / (len(t) - 1)
    even = t[0] + h * np.arange(len(t))
    actuator = case["channel"] == "actuator"
    pick = lambda head: np.interp(even, t, data[[h.split("_")[0] for h in heads].index(head)])
    given, target = ("command", "displacement") if actuator else ("displacement", "force")

    def inside(spans):
        ends = [part.split("@")[1].split("..") for part in spans]
        return np.any([(even >= float(a)) & (even < float(b)) for a, b in ends], axis=0)

    with open(folder / case["model"], "rb") as stream:
        model = tomllib.load(stream)[case["channel"]]
    return Question(case, model, even, h, pick(given), pick(target), inside(case["train"]), inside(case["test"]))


def nrmse(q, predicted):
    left = (q.target - predicted)[q.test]
    return float(np.sqrt(np.mean(left**2)) / np.std(q.target[q.test]))


def band_hz(x, h):
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2 * np.fft.rfftfreq(len(x), h) ** 2
    return np.fft.rfftfreq(len(x), h)[np.searchsorted(np.cumsum(power), 0.9 * power.sum())]


def motion(q):
    """Displacement, velocity and acceleration below the cut-off with which declared terms and a friction predict best."""
    band = max(band_hz(q.given, q.h), 1.0 / (q.t[-1] - q.t[0]))
    learned = np.flatnonzero(q.train)
    early, late = np.split(learned, [2 * len(learned) // 3])

    def at(times):
        x = records.low_passed(q.given, q.h, times * band)
        v = np.gradient(x, q.h)
        a = np.gradient(v, q.h)
        columns = np.column_stack([x, v, a, np.ones_like(x), np.tanh(v / (0.05 * np.std(v)))])
        weights = np.linalg.lstsq(columns[early], q.target[early], rcond=None)[0]
        return np.sum((q.target - columns @ weights)[late] ** 2), (x, v, a)

    return min((at(times) for times in CUTOFFS), key=lambda found: found[0])[1]


def channel(q, sigma):
    """As in the exam, with the declared parameters refitted on the training spans."""
    if q.case["channel"] == "actuator":
        names, predict = records.ACTUATOR, lambda p: records.ram(p, q.t, q.given, q.h)
        x = v = a = None
    else:
        x, v, a = motion(q)
        names, predict = records.SPECIMEN, lambda p: records.spring(p, x, v, a)
    parameters, room = records.refitted(names, q.model, predict, q.target, q.train)
    base = predict(list(parameters.values()))
    if x is None:
        x, v = base, np.gradient(base, q.h)
    force = np.zeros_like(base)
    return records.Channel(
        q.case["channel"], q.target - base, sigma, q.train, q.t, q.h, x, v, a, base, force, parameters, room
    )


def picked(q, c, pick):
    """The prediction of a peer that picks columns, and the generous reading of its names."""
    parts, matrix, size, y = regressors.library(c)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        weights = np.asarray(pick(matrix[q.train], y[q.train]))
    named = methods.largest(methods.picked(lambda *_: weights, parts, matrix, size, y))
    return c.base + c.sigma * (matrix @ weights), named


def narx(q):
    """A polynomial NARX model of second degree, run freely through the held-out spans; on at most 3000 samples."""
    every = max(1, int(q.train.sum()) // 3000)
    u, y = (s[::every].reshape(-1, 1) for s in (q.given, q.target))
    train, test = q.train[::every], q.test[::every]
    scale = [(s[train].mean(), s[train].std()) for s in (u, y)]
    (u, y) = ((s - mean) / spread for s, (mean, spread) in zip((u, y), scale))
    model = FROLS(
        order_selection=True, n_info_values=15, info_criteria="bic", ylag=2, xlag=2, basis_function=Polynomial(degree=2)
    )
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        model.fit(X=u[train], y=y[train])
        left = y[test] - model.predict(X=u[test], y=y[test])
    found = float(np.sqrt(np.mean(left**2)) / np.std(y[test]))
    return found if np.isfinite(found) else np.inf


def bouc_wen(q, c):
    """The textbook's fit of one hysteretic element beside the declared model, four starts, all samples of the record."""

    def element(log_give, beta, gamma):
        z, out = 0.0, np.empty_like(c.x)
        give = np.exp(log_give)
        for i, dx in enumerate(np.diff(c.x, prepend=c.x[0])):
            z += dx / give - (beta * abs(dx) * z + gamma * dx * abs(z)) / give
            z = min(max(z, -3.0), 3.0)
            out[i] = z
        return out

    def columns(p):
        return np.column_stack([element(*p), c.x, c.v, c.a, np.ones_like(c.x)])

    def solved(p):
        m = columns(p)
        return m, np.linalg.lstsq(m[q.train], q.target[q.train], rcond=None)[0]

    def left(p):
        m, w = solved(p)
        return (q.target - m @ w)[q.train]

    half = 0.5 * np.ptp(c.x)
    bounds = ([np.log(1e-4 * half), -2.0, -2.0], [np.log(half), 4.0, 4.0])
    starts = [[np.log(give * half), 0.6, 0.4] for give in (3e-3, 2e-2, 0.1, 0.4)]
    best = min((least_squares(left, s, bounds=bounds, max_nfev=25) for s in starts), key=lambda f: f.cost)
    m, w = solved(best.x)
    return m @ w


def ours(tool, folder, case):
    call = [tool, "diagnose", "--json", "--model", folder / case["model"]]
    for option in ("train", "test", "rest"):
        for part in case[option]:
            call += [f"--{option}", folder / part]
    done = subprocess.run([str(c) for c in call], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{case['id']}: {done.stderr.strip()}")
    return next(c for c in json.loads(done.stdout)["channels"] if c["channel"] == case["channel"])


def right(case, names):
    """+ where every name is right, - where one is not, nothing where none is given."""
    if not names:
        return "" if case["names"] else " (+)"
    return " (+)" if all(n in case["names"] for n in names) else " (-)"


def row(tool, folder, case):
    own = ours(tool, folder, case)
    q = question(folder, case)
    c = channel(q, max(own["noise_floor_rms"], 1e-3 * np.std(q.target)))
    names = [e["name"] for e in own["effects"]]
    in_set = [m["name"] for m in own["members"]]
    said = f"set of {len(in_set)}" if in_set else ", ".join(names) or own["verdict"]
    mark = (" (+)" if any(n in case["names"] for n in in_set) else " (-)") if in_set else right(case, names)
    cells = [case["id"], f"{100 * own['error_after']['test_nrmse']:.1f} %, {said}{mark}"]
    for pick in methods.PICK.values():
        predicted, named = picked(q, c, pick)
        cells.append(f"{100 * nrmse(q, predicted):.1f} %, {', '.join(named) or 'nothing'}{right(case, named)}")
    cells.append(f"{100 * narx(q):.1f} %")
    specimen = case["channel"] == "specimen"
    cells.append(f"{100 * nrmse(q, bouc_wen(q, c)):.1f} %" if specimen else "")
    return cells


def main(folder, tool, only):
    folder = Path(folder)
    with open(folder / "cases.toml", "rb") as file:
        cases = tomllib.load(file)["case"]
    heads = ["record", "outerloop diagnose", *methods.PICK, "NARX, run freely", "Bouc-Wen by least squares"]
    print("| " + " | ".join(heads) + " |\n" + "|---" * len(heads) + "|")
    for case in cases:
        if not only or case["id"] in only:
            print("| " + " | ".join(row(tool, folder, case)) + " |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
