"""A steel frame of three storeys and two bays with fibre sections whose first-storey brace stands in the laboratory.

    outerloop serve examples/opensees/frame.toml --once
    python examples/opensees/frame.py --record kobe.csv

solves the frame twice, with OpenSees' own brace and with the served one, and prints one JSON object: peaks, and eps_rms
and eps_max of the first floor's displacement as shares of its peak. Without --record the ground motion is a pulse.
"""

import argparse
import csv
import json
import math
import sys

import openseespy.opensees as ops

G = 9.80665
BAY_M, STOREY_M, BAYS, STOREYS = 6.0, 3.5, 2, 3
FLOOR_MASS_KG = 40e3
YIELD_PA, STEEL_PA, HARDENING = 275e6, 200e9, 0.01
BRACE_N_PER_M, BRACE_YIELD_M, BRACE_HARDENING = 20e6, 0.006, 0.05
STEP_S = 0.01

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--port", type=int, default=8090)
arguments.add_argument("--record", help="ground motion, CSV with time_s,acc_g")
arguments.add_argument("--scale", type=float, default=0.6)
arguments.add_argument("--seconds", type=float, default=20.0)
asked = arguments.parse_args()


def ground_motion():
    """Interval, s, and accelerations, m/s^2."""
    if not asked.record:
        # A pulse of a second: half a metre a second.
        pulse = [3.0 * math.sin(2.0 * math.pi * i * 0.01) for i in range(101)]
        return 0.01, [0.0] * 50 + pulse + [0.0]
    with open(asked.record, newline="") as file:
        rows = [(float(r["time_s"]), float(r["acc_g"]) * G) for r in csv.DictReader(file)]
    return rows[1][0] - rows[0][0], [a for _, a in rows]


def node(line, floor):
    return 10 * floor + line


def build():
    """The frame under its own weight; fixed at its feet."""
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for floor in range(STOREYS + 1):
        for line in range(BAYS + 1):
            ops.node(node(line, floor), line * BAY_M, floor * STOREY_M)
    for line in range(BAYS + 1):
        ops.fix(node(line, 0), 1, 1, 1)
    ops.uniaxialMaterial("Steel02", 1, YIELD_PA, STEEL_PA, HARDENING, 18.0, 0.925, 0.15)
    # Depth, web, width, flange, m: about an HEB 240 and an IPE 330, with fibres over web and flanges.
    ops.section("WFSection2d", 1, 1, 0.240, 0.010, 0.240, 0.017, 10, 3)
    ops.section("WFSection2d", 2, 1, 0.330, 0.0075, 0.160, 0.0115, 10, 3)
    ops.geomTransf("PDelta", 1)
    ops.geomTransf("Linear", 2)
    ops.beamIntegration("Lobatto", 1, 1, 5)
    ops.beamIntegration("Lobatto", 2, 2, 5)
    tag = 0
    beams = []
    for floor in range(STOREYS):
        for line in range(BAYS + 1):
            tag += 1
            ops.element("forceBeamColumn", tag, node(line, floor), node(line, floor + 1), 1, 1)
        for bay in range(BAYS):
            tag += 1
            ops.element("dispBeamColumn", tag, node(bay, floor + 1), node(bay + 1, floor + 1), 2, 2)
            beams.append(tag)
        for line in range(BAYS + 1):
            share = FLOOR_MASS_KG / (BAYS + 1)
            ops.mass(node(line, floor + 1), share, share, 1.0)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    weight = FLOOR_MASS_KG * G / (BAYS * BAY_M)
    for beam in beams:
        ops.eleLoad("-ele", beam, "-type", "-beamUniform", -weight)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-8, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 0.1)
    ops.analysis("Static")
    if ops.analyze(10) != 0:
        raise SystemExit("the frame does not carry its own weight")
    # The earthquake begins at time 0, and the brace is set in after the weight: it carries none of it.
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()


def shake(served):
    """Displacements of the first floor, m."""
    build()
    floor = node(1, 1)
    if served:
        # Its damping is in the force that is measured: none by Rayleigh beside it.
        server = ["-server", asked.port, "-noRayleigh"]
        ops.element("genericClient", 1000, "-node", floor, "-dof", 1, *server)
    else:
        ops.node(1000, BAY_M, STOREY_M)
        ops.fix(1000, 1, 1, 1)
        force = BRACE_N_PER_M * BRACE_YIELD_M
        ops.uniaxialMaterial("Steel01", 1000, force, BRACE_N_PER_M, BRACE_HARDENING)
        ops.element("zeroLength", 1000, 1000, floor, "-mat", 1000, "-dir", 1)
    # Two per cent at the first two modes' rough frequencies.
    w1, w2, ratio = 2 * math.pi * 1.5, 2 * math.pi * 6.0, 0.02
    ops.rayleigh(2 * ratio * w1 * w2 / (w1 + w2), 0.0, 2 * ratio / (w1 + w2), 0.0)
    interval, motion = ground_motion()
    ops.timeSeries("Path", 2, "-dt", interval, "-values", *motion, "-factor", asked.scale)
    ops.pattern("UniformExcitation", 2, 1, "-accel", 2)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("FullGeneral")
    # Operator splitting: one displacement a step, however stiff the rest of the frame is, and the stiffness at rest,
    # which is what is declared of the specimen.
    ops.algorithm("Linear", "-initial")
    ops.integrator("AlphaOS", 0.9)
    ops.analysis("Transient")
    path = []
    for step in range(round(asked.seconds / STEP_S)):
        if ops.analyze(1, STEP_S) != 0:
            raise SystemExit(f"OpenSees gave up at step {step}")
        path.append(ops.nodeDisp(floor, 1))
        if served and step % 100 == 99:
            print(f"{(step + 1) * STEP_S:.0f} s", file=sys.stderr)
    ops.wipe()
    return path


own = shake(served=False)
rig = shake(served=True)
peak = max(abs(u) for u in own)
errors = [a - b for a, b in zip(rig, own)]
print(
    json.dumps(
        {
            "steps": len(rig),
            "peak_m": peak,
            "peak_served_m": max(abs(u) for u in rig),
            "eps_rms": math.sqrt(sum(e * e for e in errors) / len(errors)) / peak,
            "eps_max": max(abs(e) for e in errors) / peak,
        }
    )
)
