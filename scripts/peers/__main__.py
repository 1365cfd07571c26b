"""Answers of every peer, and of `outerloop diagnose`, to the questions in a folder. Called by scripts/diagnosis-peers."""

import functools
import json
import multiprocessing
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import methods
import records
import regressors

READINGS = {"": methods.as_picked, ", largest only": methods.largest}


def answer(channels, seconds):
    return {
        "seconds": seconds,
        "channels": [
            {"channel": name, "verdict": verdict, "effects": [{"name": e} for e in effects]}
            for name, verdict, effects in channels
        ],
    }


def peers(folder):
    found = records.channels(folder)
    libraries = [(c, *regressors.library(c)) for c in found]
    white = [(c.name, "none" if methods.white(y) else "unknown", []) for c, *_, y in libraries]
    yield "Ljung-Box", answer(white, 0.0)
    for peer, pick in methods.PICK.items():
        begin = time.perf_counter()
        sizes = [methods.picked(pick, *library) for _, *library in libraries]
        seconds = time.perf_counter() - begin
        for reading, name_them in READINGS.items():
            said = []
            for (c, *_), size in zip(libraries, sizes):
                effects = name_them(size)
                said.append((c.name, "effect" if effects else "none", effects))
            yield peer + reading, answer(said, seconds)


def ours(tool, folder):
    rest = np.loadtxt(folder / "rest.csv", delimiter=",", skiprows=1, ndmin=2)
    train = folder / "train.csv"
    call = [tool, "diagnose", "--json", "--model", folder / "model.toml", "--train", train, "--test", folder / "test.csv"]
    for begin, end in rest:
        call += ["--rest", f"{train}@{begin}..{end}"]
    done = subprocess.run([str(c) for c in call], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{folder.name}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def everybody(tool, folder):
    return folder, [("outerloop diagnose", ours(tool, folder)), *peers(folder)]


def main(questions, answers, tool):
    answers = Path(answers)
    answers.mkdir(parents=True)
    folders = sorted(Path(questions).iterdir())
    lines = {}
    with multiprocessing.Pool() as pool:
        for i, (folder, said) in enumerate(pool.imap(functools.partial(everybody, tool), folders)):
            for peer, answered in said:
                line = json.dumps({"record": folder.name, "answer": answered})
                lines.setdefault(peer, []).append(line)
            print(f"\r{i + 1} of {len(folders)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    for peer, said in lines.items():
        (answers / f"{peer}.jsonl").write_text("\n".join(said) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
