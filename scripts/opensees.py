"""Steps per second of OpenSeesPy on the structure of Table 1: explicit Newmark, 2 kHz. Called by scripts/opensees-ratio."""

import math
import time

import openseespy.opensees as ops

MASS_KG, STIFFNESS_N_PER_M, DAMPING_RATIO, STEP_S = 1000.0, 158e3, 0.02, 5e-4
STEPS, RUNS = 200_000, 5


def build():
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, MASS_KG)
    ops.uniaxialMaterial("Elastic", 1, STIFFNESS_N_PER_M)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.rayleigh(2.0 * DAMPING_RATIO * math.sqrt(STIFFNESS_N_PER_M / MASS_KG), 0.0, 0.0, 0.0)
    ops.timeSeries("Trig", 1, 0.0, 1e9, 0.5)
    ops.pattern("Plain", 1, 1)
    ops.load(2, -MASS_KG)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("Diagonal")
    ops.algorithm("Linear")
    # gamma 1/2, beta 0: the central differences of explicit Newmark.
    ops.integrator("NewmarkExplicit", 0.5)
    ops.analysis("Transient")


def best(run):
    fastest = 0.0
    for _ in range(RUNS):
        build()
        began = time.perf_counter()
        run()
        fastest = max(fastest, STEPS / (time.perf_counter() - began))
        if not 0.0 < abs(ops.nodeDisp(2, 1)) < 10.0:
            raise SystemExit(f"the structure of OpenSees is at {ops.nodeDisp(2, 1)} m")
    return fastest


def stepwise():
    for _ in range(STEPS):
        ops.analyze(1, STEP_S)


def report(name, rate):
    print(f"{name:66} {rate * 1e-6:7.2f} million steps/s")


report("OpenSeesPy, one analyze(1) a step", best(stepwise))
report("OpenSeesPy, all steps in one analyze", best(lambda: ops.analyze(STEPS, STEP_S)))
