"""Records of specimens with OpenSees' own hysteresis laws: an exam whose laws nobody in this project wrote.

    opensees-exam.py OUT_DIR [--seed N] [--count N]

Writes OUT_DIR/ID.csv, OUT_DIR/ID.toml (the declared model) and OUT_DIR/cases.toml, in the format that host-tests reads. Units: N, mm, s.
"""

import argparse
import math
import random
from pathlib import Path

import openseespy.opensees as ops

REST_BEFORE_S, REST_AFTER_S, TRAINING_SHARE = 3.0, 2.0, 0.62
FINEST_HZ = 1024  # a record at a lower rate is integrated at a multiple of it
FASTEST_MM_S = 800.0  # what a servo-hydraulic actuator reaches
LEAST_SHARE, MOST_SHARE = 0.08, 0.45  # rms of an effect over the spring's
CLASSES = ["one", "clean", "one", "two", "one", "outside"]

# The names grouped by meaning, to list the wrong ones for each cause.
FRICTION = ["coulomb_friction", "stribeck_friction"]
LOOP = ["bilinear_hysteresis", "bouc_wen_hysteresis"]
RATE = ["viscous_damping", "quadratic_damping", "maxwell_damper", "channel_skew"]
ELASTIC = ["hardening", "softening"]
GAP = ["dead_band", "slip_gap"]
ONE_WAY = ["asymmetric_stiffness"]
# No law below involves time, mass, a sensor fault or backlash.
ABSURD = ["drift", "temperature_gain", "mains_hum", "quantisation", "frozen_sensor", "sensor_noise", "inertia_force", "backlash"]
# rig_compliance, degradation, gain_error and offset are wrong as well, but a motion may justify them: in neither list.
NO_RATE = FRICTION + LOOP + ELASTIC + GAP + ONE_WAY
NO_LOOP = FRICTION + LOOP + RATE + ONE_WAY
NAMES = FRICTION + LOOP + RATE + ELASTIC + GAP + ONE_WAY + ABSURD + ["saturation"]


def log_uniform(rng, low, high):
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def rounded(value):
    """Six digits, so that the cause as written is the cause as computed."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


# Motion -----------------------------------------------------------------------------------------------------------------------------


class Levels:
    """Levels one after the other with smooth changes between them: value, first and second derivative."""

    def __init__(self, begin_s, end_s, levels, change_s, outside=0.0):
        width = (end_s - begin_s) / len(levels)
        change_s = min(change_s, width)
        before = [outside] + levels
        self.changes = [(begin_s + i * width, change_s, before[i], level) for i, level in enumerate(levels)]
        self.changes.append((end_s - change_s, change_s, levels[-1], outside))

    def at(self, t):
        value = self.changes[0][2]
        for begin, change, low, high in self.changes:
            if t < begin:
                break
            u = (t - begin) / change
            if u < 1.0:
                rise = high - low
                return (low + rise * u**3 * (10 - 15 * u + 6 * u * u), rise * 30 * (u * (1 - u)) ** 2 / change,
                        rise * 60 * u * (1 - u) * (1 - 2 * u) / change**2)
            value = high
        return value, 0.0, 0.0


def carried(envelope, carrier):
    """A carrier under an envelope: displacement, velocity, acceleration."""
    (e, e1, e2), (c, c1, c2) = envelope, carrier
    return e * c, e1 * c + e * c1, e2 * c + 2 * e1 * c1 + e * c2


def narrow_band(rng, centre_hz):
    lines = [(2 * math.pi * min(3.0, max(0.3, centre_hz * rng.uniform(0.65, 1.35))), rng.uniform(0, 2 * math.pi),
              math.hypot(rng.gauss(0, 1), rng.gauss(0, 1)) * 0.1) for _ in range(20)]

    def at(t, _step):
        x = v = a = 0.0
        for w, phase, size in lines:
            s, c = size * math.sin(w * t + phase), size * math.cos(w * t + phase)
            x, v, a = x + s, v + w * c, a - w * w * s
        return x, v, a

    return at


def cycles(rate):
    """A sine whose frequency follows the levels `rate`, queried at increasing times."""
    phase = 0.0

    def at(t, step):
        nonlocal phase
        hz, slope, _ = rate.at(t)
        phase += 2 * math.pi * step * (rate.at(t - step)[0] + 4 * rate.at(t - step / 2)[0] + hz) / 6
        w, s, c = 2 * math.pi * hz, math.sin(phase), math.cos(phase)
        return s, w * c, 2 * math.pi * slope * c - w * w * s

    return at


def draw_motion(rng, peak_mm):
    """Its title, its length, and a function that gives displacement, velocity and acceleration on a grid."""
    begin = REST_BEFORE_S
    end = begin + round(rng.uniform(26.0, 34.0), 1)
    total = round(end + REST_AFTER_S, 1)
    fast = log_uniform(rng, 0.7, min(2.6, FASTEST_MM_S / (2 * math.pi * peak_mm)))
    slow = max(0.4, fast / rng.uniform(1.8, 3.5))
    first, second = rng.choice([(slow, fast), (fast, slow)])
    kind = rng.choice(["response", "cycles", "mixed"])
    jitter = lambda levels: [min(1.0, level * rng.uniform(0.9, 1.1)) for level in levels]
    if kind == "response":
        levels = jitter([0.35, 0.65, 1.0, 0.5, 0.9, 0.4])
        parts = [(Levels(begin, end, levels, 2.5), narrow_band(rng, math.sqrt(slow * fast)))]
        title = f"as in an earthquake, around {math.sqrt(slow * fast):.2f} Hz"
    elif kind == "cycles":
        levels = jitter([0.25, 0.5, 0.75, 1.0, 0.3, 0.6, 0.95, 0.45, 0.85, 0.4, 0.8])
        rates = [first] * 4 + [second] * 3 + [first] * 2 + [second] * 2
        parts = [(Levels(begin, end, levels, 0.9), cycles(Levels(begin, end, rates, 0.9, first)))]
        title = f"cycles of rising amplitude, {first:.2f} and {second:.2f} Hz"
    else:
        middle, late = begin + 0.4 * (end - begin), begin + 0.8 * (end - begin)
        parts = [(Levels(begin, middle, jitter([0.3, 0.6, 0.95]), 0.9), cycles(Levels(begin, middle, [first], 0.9, first))),
                 (Levels(middle, late, jitter([0.6, 1.0, 0.5, 0.85]), 1.5), narrow_band(rng, math.sqrt(slow * fast))),
                 (Levels(late, end, jitter([0.4, 0.8]), 0.9), cycles(Levels(late, end, [second], 0.9, second)))]
        title = f"cycles of {first:.2f} Hz, as in an earthquake, cycles of {second:.2f} Hz"

    def on_grid(step, count):
        grid = []
        for i in range(count):
            moved = [carried(envelope.at(i * step), carrier(i * step, step)) for envelope, carrier in parts]
            grid.append([sum(column) for column in zip(*moved)])
        scale = peak_mm / max(abs(g[0]) for g in grid)
        return [[scale * g[q] for g in grid] for q in range(3)]

    return title, total, 2 * math.pi * math.sqrt(slow * fast), on_grid


# Laws -------------------------------------------------------------------------------------------------------------------------------
# A law draws its shape for a peak of `x` mm and an angular frequency `w`. It returns the names that are right, half right and wrong, and
# a function of a stiffness `s` (to which all forces are proportional) and a tag that gives the materials, the law itself last.


class Cause:
    def __init__(self, materials, right, half=(), wrong=(), most=math.inf, verdicts=("effect", "partial", "ambiguous")):
        self.materials, self.most, self.verdicts = materials, most, list(verdicts)
        self.right, self.half = list(right), list(half)
        self.never = [n for n in NAMES if n in ABSURD or n in wrong]


def loop(materials, yields_at=1.0):
    """A loop that yields early is nearly friction."""
    early = yields_at < 0.12
    return Cause(materials, LOOP, FRICTION if early else [], RATE + ELASTIC + GAP + ONE_WAY + ([] if early else FRICTION))


def steel01(rng, x, w):
    y, b = log_uniform(rng, 0.08, 0.35), rng.uniform(0.01, 0.2)
    return loop(lambda s, t: [("Steel01", t, s * y * x, s, b)], y)


def steel02(rng, x, w):
    y, b, r0 = log_uniform(rng, 0.08, 0.35), rng.uniform(0.01, 0.2), rng.uniform(8, 20)
    return loop(lambda s, t: [("Steel02", t, s * y * x, s, b, r0, 0.925, 0.15)], y)


def boucwen(rng, x, w):
    y, alpha, n, share = log_uniform(rng, 0.08, 0.35), rng.uniform(0.01, 0.2), rng.uniform(1, 3), rng.uniform(0.4, 0.7)
    beta, gamma = share * (y * x) ** -n, (1 - share) * (y * x) ** -n
    return loop(lambda s, t: [("BoucWen", t, alpha, s, n, gamma, beta, 1.0, 0.0, 0.0, 0.0)], y)


def multilinear(rng, x, w):
    y, k2, k3 = rng.uniform(0.06, 0.15) * x, rng.uniform(0.3, 0.6), rng.uniform(0.05, 0.2)
    f = [y, y + k2 * y, y + k2 * y + k3 * 3 * y, y + k2 * y + k3 * 3 * y + 0.03 * 4 * x]
    return loop(lambda s, t: [("MultiLinear", t, y, s * f[0], 2 * y, s * f[1], 5 * y, s * f[2], 5 * y + 4 * x, s * f[3])])


def vaiana(rng, x, w):
    after, y = rng.uniform(0.02, 0.2), log_uniform(rng, 0.08, 0.3)
    return loop(lambda s, t: [("HystereticSmooth", t, s, after * s, s * y * x, 0.0)], y)


def friction(rng, x, w):
    y, material = log_uniform(rng, 0.003, 0.015), rng.choice(["Steel01", "ElasticPP"])
    wrong = [n for n in RATE if n != "viscous_damping"] + ELASTIC + GAP + ONE_WAY
    make = {"Steel01": lambda s, t: [("Steel01", t, s * y * x, s, 0.0)], "ElasticPP": lambda s, t: [("ElasticPP", t, s, y * x)]}
    return Cause(make[material], FRICTION, LOOP, wrong)


def viscous(rng, x, w):
    return Cause(lambda s, t: [("Viscous", t, s / w, 1.0)], ["viscous_damping"], ["maxwell_damper"], NO_RATE)


def quadratic(rng, x, w):
    alpha = rng.choice([2.0, 1.7])
    half = [] if alpha == 2.0 else ["viscous_damping"]
    make = lambda s, t: [("Viscous", t, s * x / (x * w) ** alpha, alpha)]
    return Cause(make, ["quadratic_damping"], half, NO_RATE + ["maxwell_damper"])


def weak_power(rng, x, w):
    """Between friction and a dashpot. No name describes the power, so `unknown` is right, and so is either extreme."""
    alpha = rng.uniform(0.2, 0.5)
    make = lambda s, t: [("Viscous", t, s * x / (x * w) ** alpha, alpha)]
    wrong = ["quadratic_damping", "channel_skew", "stribeck_friction"] + ELASTIC + GAP + ONE_WAY
    return Cause(make, ["viscous_damping", "coulomb_friction"], [], wrong, verdicts=("effect", "partial", "ambiguous", "unknown"))


def maxwell(rng, x, w):
    relaxation, material = log_uniform(rng, 0.3, 3.0) / w, rng.choice(["Maxwell", "ViscousDamper"])
    length = (1.0,) if material == "Maxwell" else ()
    half = ["viscous_damping"] if relaxation * w < 0.6 else []
    make = lambda s, t: [(material, t, s, s * relaxation, 1.0, *length)]
    return Cause(make, ["maxwell_damper"], half, NO_RATE + ["quadratic_damping"])


def curve(points):
    """An odd elastic law through points given for positive displacement."""
    strains = [-p[0] for p in reversed(points)] + [0.0] + [p[0] for p in points]
    forces = [-p[1] for p in reversed(points)] + [0.0] + [p[1] for p in points]
    return lambda s, t: [("ElasticMultiLinear", t, 0.0, "-strain", *strains, "-stress", *[s * f for f in forces])]


def hardening(rng, x, w):
    if rng.random() < 0.5:
        power = rng.uniform(2.0, 3.5)
        points = [(1.3 * x * i / 26, x * (1.3 * i / 26) ** power / power) for i in range(1, 27)]
    else:
        bend, more, slope = rng.uniform(0.1, 0.25) * x, rng.uniform(0.45, 0.6) * x, rng.uniform(0.3, 0.5)
        points = [(bend, 0.0), (more, slope * (more - bend)), (1.3 * x, slope * (more - bend) + 1.3 * x - more)]
    return Cause(curve(points), ["hardening"], ["dead_band"], NO_LOOP + ["softening", "saturation"], 4.0)


def softening(rng, x, w):
    """What is missing from the declared spring: a negative force beside it, at most .9 of its stiffness."""
    bend, more, slope = rng.uniform(0.06, 0.15) * x, rng.uniform(0.3, 0.5) * x, rng.uniform(0.5, 0.8)
    points = [(bend, 0.0), (more, -slope * (more - bend)), (1.3 * x, -slope * (more - bend) - 1.3 * x + more)]
    return Cause(curve(points), ["softening"], ["saturation"], NO_LOOP + GAP + ["hardening"], 0.9)


def gap(rng, x, w):
    """Stops on both sides: a dead band around zero, or a stiffening spring. A slipping joint is half right."""
    at = rng.uniform(0.15, 0.45) * x
    make = lambda s, t: [("ElasticPPGap", t, s, 1e3 * s * x, at), ("ElasticPPGap", t + 1, s, -1e3 * s * x, -at),
                         ("Parallel", t + 2, t, t + 1)]
    return Cause(make, ["hardening", "dead_band"], ["slip_gap"], NO_LOOP + ["softening", "saturation"], 5.0)


def joint(rng, x, w):
    """Friction and the clearance of a hole, in series with a spring."""
    at, slip = rng.uniform(0.1, 0.35) * x, rng.uniform(0.05, 0.2) * x
    make = lambda s, t: [("Steel01", t, s * slip, 40 * s, 1e-4), ("ElasticPPGap", t + 1, 40 * s, 1e3 * s * x, at),
                         ("ElasticPPGap", t + 2, 40 * s, -1e3 * s * x, -at), ("Parallel", t + 3, t, t + 1, t + 2), ("Elastic", t + 4, s),
                         ("Series", t + 5, t + 3, t + 4)]
    return Cause(make, ["slip_gap"], FRICTION + ["dead_band"], RATE + ["softening", "saturation"] + ONE_WAY, 5.0)


def one_sided(rng, x, w):
    make = rng.choice([lambda s, t: [("ENT", t, s)], lambda s, t: [("Elastic", t, s, 0.0, 0.0)]])
    return Cause(make, ONE_WAY, [], FRICTION + LOOP + RATE + GAP + ["saturation"])


def outside(materials, right, most=math.inf):
    return Cause(materials, right, [], [n for n in RATE + ["saturation"] if n not in right], most, ("unknown", "partial"))


def flag(rng, x, w):
    y, k2, beta = rng.uniform(0.1, 0.3), rng.uniform(0.03, 0.2), rng.uniform(0.4, 0.9)
    return outside(lambda s, t: [("SelfCentering", t, s, k2 * s, s * y * x, beta)], LOOP + FRICTION + ["softening"])


def hysteretic(rng, x, w):
    y, px, py, damage = rng.uniform(0.08, 0.2) * x, rng.uniform(0.6, 0.8), rng.uniform(0.15, 0.3), rng.uniform(0.0005, 0.002)
    d, f = [y, 4 * y, 1.5 * x], [y, 1.3 * y, 1.4 * y]

    def make(s, t):
        side = lambda sign: [sign * value for pair in zip([s * g for g in f], d) for value in pair]
        return [("Hysteretic", t, *side(1), *side(-1), px, py, damage, 2 * damage, 0.3)]

    return outside(make, LOOP + ["degradation", "slip_gap", "softening"])


def pinching4(rng, x, w):
    d = [rng.uniform(0.05, 0.1) * x, rng.uniform(0.2, 0.3) * x, 0.7 * x, 2.0 * x]
    f = [d[0], d[0] * rng.uniform(1.8, 2.2), d[0] * rng.uniform(2.3, 2.6), d[0] * 2.2]
    r_disp, r_force, u_force = rng.uniform(0.3, 0.6), rng.uniform(0.15, 0.3), rng.uniform(-0.1, 0.05)

    def make(s, t):
        backbone = [value for pair in zip([s * g for g in f], d) for value in pair]
        return [("Pinching4", t, *backbone, *[-b for b in backbone], r_disp, r_force, u_force, r_disp, r_force, u_force,
                 0.5, 0.1, 0.3, 0.1, 0.6, 0.2, 0.1, 0.5, 0.1, 0.3, 0.3, 0.1, 0.3, 0.1, 0.3, 10.0, "energy")]

    return outside(make, LOOP + ["degradation", "slip_gap", "softening"])


def nailed_wall(rng, x, w):
    f0, fi = rng.uniform(0.15, 0.3) * x, rng.uniform(0.02, 0.05) * x
    shape = (rng.uniform(0.03, 0.1), -0.05, rng.uniform(1.1, 1.5), rng.uniform(0.01, 0.05), rng.uniform(0.5, 0.8), 1.1)
    right = LOOP + FRICTION + ["degradation", "slip_gap", "softening"]
    return outside(lambda s, t: [("SAWS", t, s * f0, s * fi, 1.5 * x, s, *shape)], right)


def pounding(rng, x, w):
    at, dy, k2 = rng.uniform(0.1, 0.4) * x, rng.uniform(0.05, 0.2) * x, rng.uniform(0.3, 0.6)
    return outside(lambda s, t: [("ImpactMaterial", t, s, k2 * s, -dy, -at)], ONE_WAY + GAP + ["hardening"], 6.0)


ONE = [steel01, friction, boucwen, hardening, viscous, gap, steel02, quadratic, one_sided, maxwell, softening, weak_power, joint,
       multilinear, vaiana]
OUTSIDE = [flag, pinching4, pounding, hysteretic, nailed_wall]
GROUPS = [[friction], [steel01, steel02, boucwen, vaiana], [viscous, quadratic, maxwell], [hardening, softening, gap], [one_sided]]


# OpenSees ---------------------------------------------------------------------------------------------------------------------------


def force(materials, tag, motion, step):
    """Force of a zeroLength element whose end moves as given; one more node is free, as an analysis needs an unknown."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (1, 2, 3):
        ops.node(node, 0.0)
    ops.fix(1, 1)
    ops.mass(3, 1.0)
    for material in materials:
        ops.uniaxialMaterial(*material)
    ops.uniaxialMaterial("Elastic", 999, 1.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", tag, "-dir", 1)
    ops.element("zeroLength", 2, 1, 3, "-mat", 999, "-dir", 1)
    for series, values in enumerate(motion, 1):
        ops.timeSeries("Path", series, "-dt", step, "-values", *values)
    ops.pattern("MultipleSupport", 1)
    ops.groundMotion(1, "Plain", "-disp", 1, "-vel", 2, "-accel", 3)
    ops.imposedMotion(2, 1, 1)
    ops.constraints("Transformation")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.algorithm("Linear")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    forces = [0.0]
    while len(forces) < len(motion[0]) - 1:
        if ops.analyze(1, step) != 0:
            raise SystemExit(f"OpenSees gave up at {len(forces) * step:.3f} s with {materials}")
        forces.append(ops.eleForce(1, 2))
    if not all(map(math.isfinite, forces)):
        raise SystemExit(f"OpenSees answers no number with {materials}")
    return forces


def command(material):
    return " ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in material)


def exact(materials):
    return [tuple(map(rounded, m)) for m in materials]


class TooSmall(Exception):
    """A cause that the motion hardly shows, whatever its random shape."""


def sized(rng, draw, x, w, k, motion, step):
    """A random cause, its materials at the wanted size, its rms over the spring's. Redrawn if too small or worn out early."""
    wanted = log_uniform(rng, LEAST_SHARE, MOST_SHARE)
    split = round(TRAINING_SHARE * len(motion[0]))
    for _ in range(20):
        cause = draw(rng, x, w)
        unit = exact(cause.materials(k, 10))
        forces = force(unit, unit[-1][1], motion, step)
        share, late = rms(forces) / (k * rms(motion[0])), rms(forces[split:]) / (k * rms(motion[0][split:]))
        scale = min(wanted / share if share > 0.0 else math.inf, cause.most)
        if scale * min(share, 2 * late) >= LEAST_SHARE and late > 0.4 * share:
            return cause, lambda tag: exact(cause.materials(scale * k, tag)), scale * share
    raise TooSmall(f"{draw.__name__} does not reach the least size")


# Cases ------------------------------------------------------------------------------------------------------------------------------


def error_of_declared(columns, force_n, declared, split):
    """NRMSE on the held-out span of the declared model, refitted by least squares within three tolerances."""
    residual = [f - sum(d[0] * c[i] for d, c in zip(declared, columns)) for i, f in enumerate(force_n)]
    gram = [[sum(a * b for a, b in zip(p[:split], q[:split])) for q in columns] for p in columns]
    right = [sum(a * b for a, b in zip(p[:split], residual)) for p in columns]
    moved = [0.0] * len(columns)
    for _ in range(300):
        for i, (_, tolerance) in enumerate(declared):
            best = (right[i] - sum(gram[i][j] * moved[j] for j in range(len(moved)) if j != i)) / gram[i][i]
            moved[i] = max(-3 * tolerance, min(3 * tolerance, best))
    left = [residual[i] - sum(m * c[i] for m, c in zip(moved, columns)) for i in range(split, len(force_n))]
    return rms(left) / deviation(force_n[split:])


def deviation(values):
    mean = sum(values) / len(values)
    return rms([v - mean for v in values])


def make_case(rng, ident, draws, folder):
    peak, rate = log_uniform(rng, 8.0, 80.0), rng.choice([256, 300, 400, 500, 512, 600, 800, 1000, 1024])
    title, total, w, on_grid = draw_motion(rng, peak)
    finer = math.ceil(FINEST_HZ / rate)
    step, count = 1.0 / (rate * finer), round(total * rate * finer) + 2
    motion = on_grid(step, count)
    k = rounded(log_uniform(rng, 2e3, 2e5) / peak)
    damped = not draws or (rng.random() < 0.5 and viscous not in draws)
    c = rounded(k / w * rng.uniform(0.02, 0.1)) if damped else 0.0

    # Spring and dashpot, in parallel with the causes.
    beside = [("Elastic", 2, k)] + ([("Viscous", 3, c, 1.0)] if damped else [])
    parallel, causes, shares = [m[1] for m in beside], [], []
    words = [command((m[0], *m[2:])) for m in beside]
    for i, draw in enumerate(draws):
        cause, at_size, share = sized(rng, draw, peak, w, k, motion, step)
        materials = at_size(10 * (i + 1))
        words.append(", ".join(map(command, materials)))
        beside += materials
        parallel.append(materials[-1][1])
        causes.append(cause)
        shares.append(share)
    forces = force(beside + [("Parallel", 1, *parallel)], 1, motion, step)

    # The transducers' readings.
    true_mm, true_mm_s, true_n = motion[0][: count - 1 : finer], motion[1][: count - 1 : finer], forces[::finer]
    peak_n = max(map(abs, true_n))
    noise_n, noise_mm = peak_n * rng.uniform(0.001, 0.004), peak * rng.uniform(0.0001, 0.0005)
    offset = peak_n * rng.uniform(-0.0025, 0.0025)
    x = [d + rng.gauss(0.0, noise_mm) for d in true_mm]
    f = [n + offset + rng.gauss(0.0, noise_n) for n in true_n]
    with open(folder / f"{ident}.csv", "w") as out:
        out.write("time_s,displacement_mm,force_n\n")
        out.writelines(f"{i / rate:.8f},{d:.6f},{n:.4f}\n" for i, (d, n) in enumerate(zip(x, f)))

    # The laboratory's declaration.
    tolerance = k * rng.uniform(0.01, 0.03)
    declared = [(k + tolerance * rng.uniform(-1, 1), tolerance),
                (c * rng.uniform(0.8, 1.2), 0.2 * c) if damped else (0.0, 0.005 * k / w), (0.0, 0.005 * peak_n)]
    keys = ["stiffness_n_per_mm", "damping_n_s_per_mm", "offset_n"]
    lines = [f"{key} = {{ value = {v:.6g}, tolerance = {t:.4g} }}" for key, (v, t) in zip(keys, declared)]
    if rng.random() < 0.5:  # k in N/mm divided by w squared is in tonnes
        lines.insert(2, f"mass_kg = {{ value = 0, tolerance = {0.002 * k / w**2 * 1e3:.4g} }}")
    (folder / f"{ident}.toml").write_text("# declared before the effect is known\n[specimen]\n" + "\n".join(lines) + "\n")

    at = round(TRAINING_SHARE * total, 1)
    split = math.ceil(at * rate)
    before = error_of_declared([x, true_mm_s, [1.0] * len(x)], f, declared, split)
    after = max(0.02, math.hypot(noise_n, k * noise_mm) / deviation(f[split:]))
    return {
        "id": ident,
        "title": f"{title}, {peak:.1f} mm, {rate} Hz",
        "channel": "specimen",
        "model": f"{ident}.toml",
        "train": [f"{ident}.csv@0..{at}"],
        "test": [f"{ident}.csv@{at}..{total}"],
        "rest": [f"{ident}.csv@0..2.8"],
        **answers(causes),
        "cause": "OpenSees, in parallel: " + "; ".join(words) if draws else "nothing is missing: " + "; ".join(words),
        "reference": f"{{ before_nrmse = {max(before, 1e-4):.4f}, after_nrmse = {after:.4f} }}",
        "shares": [round(s, 4) for s in shares],
        "both": [c.right for c in causes],
    }


def answers(causes):
    right = list(dict.fromkeys(n for c in causes for n in c.right))
    half = [n for n in dict.fromkeys(n for c in causes for n in c.half) if n not in right]
    never = [n for n in NAMES if all(n in c.never for c in causes) and n not in right + half]
    verdicts = causes[0].verdicts if causes else ["none"]
    return {"verdicts": verdicts, "names": right, "half": half, "set_must_hold_one_of": right, "never": never}


def toml_value(key, value):
    if isinstance(value, list):
        return "[" + ", ".join(toml_value("", v) for v in value) + "]"
    return str(value) if key == "reference" or isinstance(value, float) else '"' + value + '"'


def drawn_until_shown(given, i, kind, orders, turn):
    """A number of cases; redrawn with another motion if the first does not show its cause."""
    for attempt in range(20):
        rng = random.Random(f"{given.seed}/{i}" + (f"/{attempt}" if attempt else ""))
        if kind == "two":
            draws = [rng.choice(group) for group in rng.sample(GROUPS, 2)]
        else:
            draws = [orders[kind][turn % len(orders[kind])]] if kind in orders else []
        ident = "_".join([kind, f"{i:03}", *(d.__name__ for d in draws)])
        try:
            yield make_case(rng, ident, draws, given.out_dir)
        except TooSmall as why:
            print(why, "by this motion: another one", flush=True)
    raise SystemExit(f"no motion shows case {i}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out_dir", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=48)
    given = parser.parse_args()
    given.out_dir.mkdir(parents=True, exist_ok=True)
    orders = {"one": list(ONE), "outside": list(OUTSIDE)}
    for order in orders.values():
        random.Random(given.seed).shuffle(order)
    turns = dict.fromkeys(CLASSES, 0)
    tables = [f"# Laws of OpenSees {ops.version()}, by scripts/opensees-exam.py, seed {given.seed}.\n"
              "# shares: rms of each cause over the spring's; both: right names for each cause."]
    for i in range(given.count):
        kind = CLASSES[i % len(CLASSES)]
        case = next(drawn_until_shown(given, i, kind, orders, turns[kind]))
        turns[kind] += 1
        tables.append("[[case]]\n" + "\n".join(f"{key} = {toml_value(key, value)}" for key, value in case.items()))
        print(case["id"], case["shares"], case["reference"], flush=True)
    (given.out_dir / "cases.toml").write_text("\n\n".join(tables) + "\n")


if __name__ == "__main__":
    main()
