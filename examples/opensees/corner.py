"""The corner of a frame in OpenSees, which is displaced and turned. One half of its stiffness stands in the laboratory: two actuators
on one coupler. Beside it the same corner with both halves in OpenSees.

    outerloop serve examples/coupled-frame.toml --set serve.settle_ms=100 --set serve.average_ms=50
    python examples/opensees/corner.py

prints one JSON object: the peaks, m and rad, and by how much the two differ as a share of them. The brace of that file yields, and is
nobody's in OpenSees: --set "plant.coupled.specimen.springs=[]" takes it out.
"""

import argparse
import json
import math

import openseespy.opensees as ops

MASS_KG, INERTIA_KG_M2, DAMPING_PER_S = 1000.0, 60.0, 1.2
# Of each half, N/m, N/rad (N m/m), N m/rad: those of `[coupled.specimen]`.
K_XX, K_XR, K_RR = 104e3, 30e3, 96e3
# A column below the corner, 12 EI / H^3, 6 EI / H^2 and 4 EI / H, and a beam beside it that holds the rotation, are such a half.
HEIGHT_M = 2.0 * K_XR / K_XX
EI_N_M2 = K_XX * HEIGHT_M**3 / 12.0
BEAM_N_M_PER_RAD = K_RR - 4.0 * EI_N_M2 / HEIGHT_M

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--port", type=int, default=8090)
arguments.add_argument("--steps", type=int, default=300)
arguments.add_argument("--dt", type=float, default=0.01, help="integration step, s")
asked = arguments.parse_args()


def ground(t):
    """Ground acceleration, m/s^2: a beat near the first mode, 2.2 Hz."""
    return 2.0 * math.sin(11.0 * t) * math.sin(0.7 * t)


def run(served):
    """x, m, and rotation, rad, of the corner, step by step."""
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node, height_m in [(1, 0.0), (2, HEIGHT_M), (3, HEIGHT_M)]:
        ops.node(node, 0.0, height_m)
    ops.fix(1, 1, 1, 1)
    ops.fix(2, 0, 1, 0)
    ops.fix(3, 1, 1, 1)
    ops.mass(2, MASS_KG, 0.0, INERTIA_KG_M2)
    halves = 1 if served else 2
    ops.geomTransf("Linear", 1)
    ops.element("elasticBeamColumn", 1, 1, 2, 1.0, halves * EI_N_M2, 1.0, 1)
    ops.uniaxialMaterial("Elastic", 1, halves * BEAM_N_M_PER_RAD)
    ops.element("zeroLength", 2, 3, 2, "-mat", 1, "-dir", 6)
    if served:
        ops.element("genericClient", 3, "-node", 2, "-dof", 1, 3, "-server", asked.port, "-noRayleigh")
    ops.rayleigh(DAMPING_PER_S, 0.0, 0.0, 0.0)
    motion = [ground(i * asked.dt) for i in range(asked.steps + 2)]
    ops.timeSeries("Path", 1, "-dt", asked.dt, "-values", *motion)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator("NewmarkExplicit", 0.5)
    ops.analysis("Transient")
    path = []
    for step in range(1, asked.steps + 1):
        if ops.analyze(1, asked.dt) != 0:
            raise SystemExit(f"OpenSees gave up at step {step} of {asked.steps}")
        path.append((ops.nodeDisp(2, 1), ops.nodeDisp(2, 3)))
    # Tells the rig that this was the last step.
    ops.wipe()
    return path


own = run(served=False)
rig = run(served=True)
peaks = [max(abs(u[j]) for u in own) for j in (0, 1)]
apart = [max(abs(a[j] - b[j]) for a, b in zip(own, rig)) / peaks[j] for j in (0, 1)]
print(json.dumps({"peak_m": peaks[0], "peak_rad": peaks[1], "apart_x": apart[0], "apart_rotation": apart[1]}))
