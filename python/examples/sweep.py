"""How late may an actuator be? A sweep over delays and compensations on a Dask cluster, here two workers on this machine.

    python python/examples/sweep.py

Each test is one task. A worker that is lost takes nothing along: its tests run again on another one, and since a test is
repeated to the bit by its seed, the table is the same. ``--scheduler tcp://HOST:8786`` takes a cluster that runs already.
"""

import argparse
import pathlib

import outerloop as ol

TABLE1 = pathlib.Path(__file__).resolve().parents[2] / "examples" / "table1.toml"
DELAYS_MS = (1.0, 2.0, 4.0, 8.0)
COMPENSATIONS = ("none", "paper", "lagrange")


def case(delay_ms, compensation, duration=10.0):
    """eps_rms and verdict of one test."""
    override = {"plant.actuator.delay_ms": delay_ms}
    test = ol.run(TABLE1, compensation=compensation, set=override, duration=duration)
    return delay_ms, compensation, test["eps_rms"], test["verdict"]


def cases():
    return [(delay_ms, name) for delay_ms in DELAYS_MS for name in COMPENSATIONS]


def sweep(client):
    """The whole table on a cluster."""
    futures = [client.submit(case, *each, pure=False) for each in cases()]
    return client.gather(futures)


def main():
    from distributed import Client, LocalCluster

    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--scheduler", help="address of a cluster that runs already")
    asked = arguments.parse_args()
    where = asked.scheduler or LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with Client(where) as client:
        for delay_ms, compensation, eps_rms, verdict in sweep(client):
            print(f"{delay_ms:4.1f} ms  {compensation:10s}  eps_rms {100 * eps_rms:10.3g} %  {verdict}")


if __name__ == "__main__":
    main()
