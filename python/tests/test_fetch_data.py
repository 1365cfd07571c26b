"""scripts/fetch-data against a server on this machine."""

import functools
import hashlib
import http.server
import json
import pathlib
import subprocess
import sys
import threading

import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "fetch-data"
COMMIT = "0123456789abcdef"
# Two samples as that laboratory's acquisition writes them.
ACQUIRED = """Sample Count:  2
Sample Number, Date/Time, CHANNEL0, CHANNEL1, CHANNEL2, Events
         1,   06/29/2022 04:05:36.674 PM, -0.0209, -0.0166, -0.0169, DAQ Start
         2,   06/29/2022 04:05:36.675 PM, -0.0221, -0.0175, -0.0176
"""
MADE = """time_s,command_mm,displacement_mm,force_n
0.000,-0.16900,-0.20900,-162.79
0.001,-0.17600,-0.22100,-171.62
"""


def sha256(text):
    return hashlib.sha256(text.encode()).hexdigest()


@pytest.fixture
def mirror(tmp_path):
    served = tmp_path / "served" / "someone" / "rig" / COMMIT / "a folder"
    served.mkdir(parents=True)
    (served / "plain.csv").write_text("a,b\n1,2\n")
    (served / "raw.txt").write_text(ACQUIRED)

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    handler = functools.partial(Quiet, directory=str(tmp_path / "served"))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    files = [
        {"path": "x/plain.csv", "original": "a folder/plain.csv", "convert": "as published", "sha256": sha256("a,b\n1,2\n")},
        {"path": "x/made.csv", "original": "a folder/raw.txt", "convert": "utfsm", "sha256": sha256(MADE)},
        {"path": "x/paper.csv", "made": "typed from the paper", "sha256": sha256("")},
    ]
    listed = {
        "sources": {"rig": {"title": "a rig", "repository": "someone/rig", "licence": "MIT"}},
        "files": [{"source": "rig", "commit": COMMIT, **file} for file in files],
    }
    yield listed, f"http://127.0.0.1:{server.server_port}"
    server.shutdown()


def fetch(tmp_path, listed, base):
    sources = tmp_path / "sources.json"
    sources.write_text(json.dumps(listed))
    call = [sys.executable, SCRIPT, "--to", tmp_path / "data", "--sources", sources, "--base", base, "--timeout-s", "5"]
    done = subprocess.run([str(word) for word in call], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def test_files_are_brought_converted_checked_and_left(tmp_path, mirror):
    listed, base = mirror
    status, said = fetch(tmp_path, listed, base)
    assert status == 0, said
    assert (tmp_path / "data/x/made.csv").read_text() == MADE
    assert "2 brought, 1 by hand, of 3 files" in said
    assert "x/paper.csv: https://github.com/someone/rig: typed from the paper" in said
    status, said = fetch(tmp_path, listed, base)
    assert status == 0 and "1 by hand, 2 there" in said


def test_a_file_of_another_content_is_neither_written_nor_replaced(tmp_path, mirror):
    listed, base = mirror
    listed["files"][0]["sha256"] = sha256("something else")
    status, said = fetch(tmp_path, listed, base)
    assert status == 2 and "nothing is written" in said
    assert not (tmp_path / "data/x/plain.csv").exists()
    own = tmp_path / "data/x/made.csv"
    own.write_text("mine")
    status, said = fetch(tmp_path, listed, base)
    assert status == 2 and "is another file" in said
    assert own.read_text() == "mine"
    assert not [left for left in own.parent.iterdir() if left.name.startswith("tmp")]


def test_without_a_network_it_says_so(tmp_path, mirror):
    listed, _ = mirror
    status, said = fetch(tmp_path, listed, "http://127.0.0.1:9")
    assert status == 1 and "is there a network?" in said
    assert "Traceback" not in said
