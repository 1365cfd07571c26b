"""Fast pseudodynamic tests from Python: the library of ``outerloop``, with NumPy arrays in and out."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Union

import numpy as np

from . import _native
from ._native import Refused, __version__

__all__ = ["Refused", "__version__", "compare", "diagnose", "identify", "model", "read_record", "run"]

Path = Union[str, "os.PathLike[str]"]
#: A file, or the times in s and the accelerations in g.
GroundMotion = Union[Path, "tuple[Sequence[float], Sequence[float]]"]
#: A file, with or without a span (``chirp.csv@2..8``), or columns by name.
Recording = Union[Path, Mapping[str, Sequence[float]]]


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
    motion = None if record is None else _ground_motion(record)
    summary, steps = _native.run(os.fspath(test), _overrides(set), motion, compensation, seed, duration, trace)
    if trace:
        summary["trace"] = steps
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
    motions = [_ground_motion(record) for record in records]
    return _native.compare(os.fspath(test), _overrides(set), motions, list(compensations), seed, duration)


def identify(recording: Recording) -> dict[str, Any]:
    """Gain, transport delay, lag and offset of an actuator from a recorded command and displacement; ``doubt`` says what
    speaks against them, such as a reversed sign, or is None."""
    found, doubt = _native.identify(_recording(recording))
    return {**found, "doubt": doubt}


def diagnose(
    declared: Path | Mapping[str, Any],
    train: Recording | Sequence[Recording],
    test: Recording | Sequence[Recording],
    *,
    rest: Iterable[Recording] = (),
) -> dict[str, Any]:
    """What the declared model lacks, found in ``train`` and judged on ``test``; ``model`` is the improved one, TOML."""
    if isinstance(declared, Mapping):
        text = ("the declared model", model(declared))
    else:
        text = (os.fspath(declared), _read(declared))
    found, improved = _native.diagnose(text, _recordings(train), _recordings(test), [_recording(r) for r in rest])
    return {**found, "model": improved}


def read_record(file: Path) -> dict[str, np.ndarray]:
    """The columns of a recording by their names as they stand in it: CSV in any dialect, as ``run --out`` writes it or an
    instrument, MAT or HDF5."""
    return _native.read_record(os.fspath(file))


def model(declared: Mapping[str, Any]) -> str:
    """A declared model as TOML from values and tolerances, ``{"actuator": {"delay_ms": (5, 1)}}``."""
    text = ""
    for table, parameters in declared.items():
        text += f"[{table}]\n"
        for name, (value, tolerance) in parameters.items():
            text += f"{name} = {{ value = {float(value)!r}, tolerance = {float(tolerance)!r} }}\n"
    return text


def _read(file):
    try:
        return pathlib.Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as why:
        raise Refused(f"{os.fspath(file)}: cannot be read ({why}): accepted is a declared model, TOML") from why


def _overrides(overrides):
    return [f"{path}={_toml(value)}" for path, value in (overrides or {}).items()]


def _toml(value):
    if isinstance(value, (bool, str)):
        return json.dumps(value)
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ",".join(_toml(v) for v in value) + "]"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return repr(float(value))


def _numbers(values):
    return np.ascontiguousarray(np.asarray(values, dtype=float).ravel())


def _ground_motion(record):
    if isinstance(record, tuple):
        time_s, acc_g = record
        return _numbers(time_s), _numbers(acc_g)
    return os.fspath(record)


def _recording(recording):
    if isinstance(recording, Mapping):
        return [(name, _numbers(values)) for name, values in recording.items()]
    return os.fspath(recording)


def _recordings(parts):
    several = isinstance(parts, Sequence) and not isinstance(parts, (str, os.PathLike))
    return [_recording(part) for part in (parts if several else [parts])]
