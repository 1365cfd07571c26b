"""The marks of every peer as one table. Called by scripts/diagnosis-peers."""

import json
import sys
from pathlib import Path

ORDER = ["outerloop", "PySINDy", "stepwise", "LassoLarsIC", "sysidentpy", "Ljung-Box"]
RIGHT = {"exact", "set", "family"}
COLUMNS = [
    ("matched: exact", ["matched"], {"exact"}),
    ("unseen: exact", ["unseen"], {"exact"}),
    ("unseen: right", ["unseen"], RIGHT),
    ("unseen: wrong", ["unseen"], {"wrong"}),
    ("two: both", ["two"], RIGHT),
    ("confounded: right", ["confounded"], RIGHT),
    ("outside: abstains", ["outside"], {"exact"}),
    ("clean: says something", ["clean"], {"wrong", "alarm"}),
    ("clean: names something", ["clean"], {"wrong"}),
]


def share(records, classes, marks):
    of = [r["mark"] for r in records if r["class"] in classes and r["detection_size"] is None]
    return f"{100.0 * sum(m in marks for m in of) / len(of):.0f} %" if of else "-"


def main(folder):
    files = sorted(Path(folder).glob("*.json"), key=lambda f: (next(i for i, o in enumerate(ORDER) if f.stem.startswith(o)), f.stem))
    counts = {}
    print("| | " + " | ".join(head for head, *_ in COLUMNS) + " |")
    print("|---" * (len(COLUMNS) + 1) + "|")
    for file in files:
        records = json.loads(file.read_text())["records"]
        for r in records:
            counts.setdefault(r["class"], set()).add(r["seed"])
        row = [share(records, classes, marks) for _, classes, marks in COLUMNS]
        print(f"| {file.stem} | " + " | ".join(row) + " |")
    print("\nRecords: " + ", ".join(f"{len(seeds)} {name}" for name, seeds in counts.items()))


main(sys.argv[1])
