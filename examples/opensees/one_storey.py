"""One storey in OpenSees whose spring stands in the laboratory, beside the same storey with OpenSees' own spring.

    outerloop serve examples/opensees.toml
    python examples/opensees/one_storey.py

prints one JSON object: the peak, by how much the two differ as a share of it, and how many steps a second were made.
With --late-every and --late-ms the model takes that long for some of its steps, as a large one would.
"""

import argparse
import json
import math
import time

import openseespy.opensees as ops

MASS_KG, STIFFNESS_N_PER_M, DAMPING_RATIO = 1000.0, 158e3, 0.02

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--port", type=int, default=8090)
arguments.add_argument("--steps", type=int, default=3000)
arguments.add_argument("--dt", type=float, default=0.01, help="integration step, s")
arguments.add_argument("--integrator", nargs="+", default=["NewmarkExplicit", "0.5"])
arguments.add_argument("--algorithm", default="Linear")
arguments.add_argument("--late-every", type=int, default=0)
arguments.add_argument("--late-ms", type=float, default=0.0)
asked = arguments.parse_args()


def ground(t):
    """Ground acceleration, m/s^2: a beat near the structure's 2 Hz."""
    return 3.0 * math.sin(11.0 * t) * math.sin(0.7 * t)


def numbers(words):
    return [words[0], *(float(w) for w in words[1:])]


def run(served):
    """The displacements of the storey, m, and the seconds that they took."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, MASS_KG)
    if served:
        ops.element("genericClient", 1, "-node", 2, "-dof", 1, "-server", asked.port)
    else:
        ops.uniaxialMaterial("Elastic", 1, STIFFNESS_N_PER_M)
        ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.rayleigh(2.0 * DAMPING_RATIO * math.sqrt(STIFFNESS_N_PER_M / MASS_KG), 0.0, 0.0, 0.0)
    motion = [ground(i * asked.dt) for i in range(asked.steps + 2)]
    ops.timeSeries("Path", 1, "-dt", asked.dt, "-values", *motion)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    # An explicit integrator or operator splitting, and an algorithm that does not iterate: one displacement a step.
    ops.test("NormUnbalance", 1e-6, 10)
    ops.algorithm(asked.algorithm)
    ops.integrator(*numbers(asked.integrator))
    ops.analysis("Transient")
    path, began = [], time.perf_counter()
    for step in range(1, asked.steps + 1):
        if served and asked.late_every and step % asked.late_every == 0:
            time.sleep(asked.late_ms / 1e3)
        if ops.analyze(1, asked.dt) != 0:
            raise SystemExit(f"OpenSees gave up at step {step} of {asked.steps}")
        path.append(ops.nodeDisp(2, 1))
    seconds = time.perf_counter() - began
    # Tells the rig that this was the last step.
    ops.wipe()
    return path, seconds


own, _ = run(served=False)
rig, seconds = run(served=True)
peak = max(abs(u) for u in own)
apart = max(abs(a - b) for a, b in zip(own, rig))
print(json.dumps({"peak_m": peak, "apart": apart / peak, "steps_per_s": len(rig) / seconds}))
