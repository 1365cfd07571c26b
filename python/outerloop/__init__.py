"""Fast pseudodynamic tests from Python: the program ``outerloop``, with NumPy arrays in and out."""

from __future__ import annotations

import contextlib
import csv
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Union

import numpy as np

__all__ = ["Refused", "compare", "diagnose", "identify", "model", "program", "read_record", "run"]

Path = Union[str, "os.PathLike[str]"]
#: A file, or the times in s and the accelerations in g.
GroundMotion = Union[Path, "tuple[Sequence[float], Sequence[float]]"]
#: A file, with or without a span (``chirp.csv@2..8``), or columns by name.
Recording = Union[Path, Mapping[str, Sequence[float]]]


class Refused(ValueError):
    """What was given cannot be used: what, where, which value, and what would be accepted."""


def program() -> str:
    """The program that is called: ``OUTERLOOP``, else the one on the path, else that of the checkout around this file."""
    named = os.environ.get("OUTERLOOP") or shutil.which("outerloop")
    if named:
        return named
    name = "outerloop.exe" if os.name == "nt" else "outerloop"
    built = pathlib.Path(__file__).resolve().parents[2] / "target" / "release" / name
    if built.is_file():
        return str(built)
    raise Refused("the program outerloop is not found: accepted is one on the path, or its file in the variable OUTERLOOP")


def run(
    test: Path,
    *,
    record: GroundMotion | None = None,
    compensation: str | None = None,
    set: Mapping[str, Any] | None = None,
    seed: int = 1,
    duration: float | None = None,
    trace: bool = False,
) -> dict[str, Any]:
    """One closed-loop test. ``set`` overrides values of the test file by their paths; with ``trace`` every control step is
    in ``trace``, a NumPy array a column. A test that trips or runs away is a result and says so in ``verdict``."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["run", os.fspath(test), "--json", *_common(folder, [record], set, seed, duration)]
        if compensation is not None:
            words += ["--compensation", compensation]
        out = os.path.join(folder, "out")
        if trace:
            words += ["--out", out]
        summary = _ask(words)
        if trace:
            summary["trace"] = read_record(os.path.join(out, "record.csv"))
        return summary


def compare(
    test: Path,
    compensations: Iterable[str],
    *,
    records: Iterable[GroundMotion] = (),
    set: Mapping[str, Any] | None = None,
    seed: int = 1,
    duration: float | None = None,
) -> list[dict[str, Any]]:
    """The same test under several compensations, one dictionary a row."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["compare", os.fspath(test), "--json", "--compensations", ",".join(compensations)]
        words += _common(folder, records, set, seed, duration)
        return _ask(words)["rows"]


def identify(recording: Recording) -> dict[str, Any]:
    """Gain, transport delay, lag and offset of an actuator from a recorded command and displacement."""
    with tempfile.TemporaryDirectory() as folder:
        return _ask(["identify", _recording(folder, "recording", recording), "--json"])


def diagnose(
    declared: Path | Mapping[str, Any],
    train: Recording,
    test: Recording,
    *,
    rest: Iterable[Recording] = (),
) -> dict[str, Any]:
    """What the declared model lacks, found in ``train`` and judged on ``test``."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["diagnose", "--json", "--model", model(declared, folder)]
        words += ["--train", _recording(folder, "train", train)]
        words += ["--test", _recording(folder, "test", test)]
        for number, still in enumerate(rest):
            words += ["--rest", _recording(folder, f"rest{number}", still)]
        return _ask(words)


def read_record(file: Path) -> dict[str, np.ndarray]:
    """The columns of a recording, CSV as ``run --out`` writes it, by their names; lines that begin with # are comments."""
    with open(file, newline="", encoding="utf-8") as lines:
        rows = csv.reader(line for line in lines if not line.startswith("#"))
        names = next(rows)
        values = np.array([[float(cell) for cell in row] for row in rows if row]).reshape(-1, len(names))
    return {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(names)}


def model(declared: Path | Mapping[str, Any], folder: Path) -> str:
    """A declared model as a file; a dictionary ``{"actuator": {"delay_ms": (5, 1)}}`` of values and tolerances is written."""
    if not isinstance(declared, Mapping):
        return os.fspath(declared)
    text = ""
    for table, parameters in declared.items():
        text += f"[{table}]\n"
        for name, (value, tolerance) in parameters.items():
            text += f"{name} = {{ value = {float(value)!r}, tolerance = {float(tolerance)!r} }}\n"
    file = os.path.join(folder, "model.toml")
    pathlib.Path(file).write_text(text, encoding="utf-8")
    return file


def _common(folder, records, overrides, seed, duration):
    words = ["--seed", str(seed)]
    for number, record in enumerate(records):
        if record is not None:
            words += ["--record", _ground_motion(folder, f"record{number}", record)]
    for path, value in (overrides or {}).items():
        words += ["--set", f"{path}={_toml(value)}"]
    if duration is not None:
        words += ["--duration", repr(float(duration))]
    return words


def _toml(value):
    if isinstance(value, (bool, str)):
        return json.dumps(value)
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ",".join(_toml(v) for v in value) + "]"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return repr(float(value))


def _ground_motion(folder, name, record):
    if isinstance(record, tuple):
        time_s, acc_g = record
        return _write(folder, name, {"time_s": time_s, "acc_g": acc_g})
    return os.fspath(record)


def _recording(folder, name, recording):
    if isinstance(recording, Mapping):
        return _write(folder, name, recording)
    return os.fspath(recording)


def _write(folder, name, columns):
    arrays = {key: np.asarray(values, dtype=float).ravel() for key, values in columns.items()}
    lengths = {key: len(values) for key, values in arrays.items()}
    if len({*lengths.values()}) > 1:
        raise Refused(f"the columns are of different lengths, {lengths}: accepted are columns of one length")
    file = os.path.join(folder, f"{name}.csv")
    with open(file, "w", newline="", encoding="utf-8") as out:
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow(arrays)
        # Python writes as many digits as a number needs to come back the same.
        rows.writerows(zip(*(values.tolist() for values in arrays.values())))
    return file


def _ask(words):
    done = subprocess.run([program(), *words], capture_output=True, text=True, encoding="utf-8", check=False)
    answer = None
    with contextlib.suppress(json.JSONDecodeError):
        answer = json.loads(done.stdout)
    # 1 is a result that is not good; what it says is in the answer.
    if answer is not None and done.returncode in (0, 1):
        return answer
    said = done.stderr.strip().splitlines()
    raise Refused(said[-1].removeprefix("outerloop: ") if said else f"outerloop ended with status {done.returncode}")
