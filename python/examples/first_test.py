"""A first test from Python, cell by cell (`# %%` cells open as a notebook in VS Code, Spyder and Jupytext)."""

# %% What a late actuator does: the structure of Table 1, an actuator that is 4 ms late.
import pathlib

import numpy as np

import outerloop as ol

TABLE1 = pathlib.Path(__file__).resolve().parents[2] / "examples" / "table1.toml"
none, paper = ol.compare(TABLE1, ["none", "paper"])
print(f"without compensation: {none['verdict']}; with the paper's: eps_rms {100 * paper['eps_rms']:.3f} %")

# %% Every step of it, as arrays.
test = ol.run(TABLE1, duration=10, trace=True)
trace = test["trace"]
peak_m = np.abs(trace["target_m"]).max()
print(f"{len(trace['time_s'])} steps, largest displacement {1e3 * peak_m:.2f} mm")

# %% How late is the actuator? Asked of its own record.
found = ol.identify({name: trace[name] for name in ("time_s", "command_m", "displacement_m")})
print(f"the record says {found['delay_ms']:.2f} ms and a gain of {found['gain']:.4f}")

# %% A ground motion of one's own: a sine sweep from 0.5 to 4 Hz.
time_s = np.arange(0, 10, 0.01)
acc_g = 0.1 * np.sin(2 * np.pi * (0.5 + 0.175 * time_s) * time_s)
sweep = ol.run(TABLE1, record=(time_s, acc_g), trace=True)
print(f"under the sweep: eps_rms {100 * sweep['eps_rms']:.3f} %")
