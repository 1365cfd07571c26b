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
        {"path": "x/paper.csv", "made": "typed from the paper", "by_hand": "it is a drawing", "sha256": sha256("")},
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
    assert "x/paper.csv: https://github.com/someone/rig: typed from the paper; by hand, because it is a drawing" in said
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


def test_the_page_is_the_printed_one_and_gives_each_file_that_is_brought_by_hand_its_reason():
    page = subprocess.run([sys.executable, SCRIPT, "--markdown"], capture_output=True, text=True, check=True).stdout
    assert page == (SCRIPT.parents[1] / "docs" / "data.md").read_text(encoding="utf-8")
    listed = json.loads((SCRIPT.parent / "data-sources.json").read_text(encoding="utf-8"))["files"]
    assert all(("convert" in file) != ("by_hand" in file) for file in listed)
    assert page.count("| by hand: ") == sum("by_hand" in file for file in listed)


def test_without_a_network_it_says_so(tmp_path, mirror):
    listed, _ = mirror
    status, said = fetch(tmp_path, listed, "http://127.0.0.1:9")
    assert status == 1 and "is there a network?" in said
    assert "Traceback" not in said


# Invented samples in the form of each source, and what has to be made of them.
SEALS = "".join(f"{10 * i}.000\t3.6\t2.5\t5.5\t{i}.000\t5.000\t250.000\n" for i in range(18))
CONVERTED = [
    (
        {"convert": "columns", "columns": [["time_s", 0, 1, "%.3f"], ["displacement_mm", 2, 10, "%.2f"]]},
        ["t,r,y\n0,7,0.5\n0.1,7,-1e-3\n"],
        "time_s,displacement_mm\n0.000,5.00\n0.100,-0.01\n",
    ),
    (
        {"convert": "at2", "head": "# somebody's"},
        ["DATABASE\nA rig\nIN UNITS OF G\nNPTS =      3 , DT =   .020 SEC ,\n  .1E-01 -.2E-01\n  .3E-01\n"],
        "# somebody's\ntime_s,acc_g\n0.0000,1.00000000e-02\n0.0200,-2.00000000e-02\n0.0400,3.00000000e-02\n",
    ),
    (
        # 250 N - 5 bar x 4.908739 cm2
        {"convert": "seal", "diameter_mm": 25, "even": False},
        [SEALS],
        "time_s,displacement_mm,force_n\n0.000,15.0000,4.563\n0.010,16.0000,4.563\n0.020,17.0000,4.563\n",
    ),
    (
        # A stamp that came late: at 10 ms the way between the first two.
        {"convert": "seal", "diameter_mm": 25, "even": True},
        [SEALS.replace("160.000\t", "165.000\t")],
        "time_s,displacement_mm,force_n\n0.000,15.0000,4.563\n0.010,15.6667,4.563\n0.020,17.0000,4.563\n",
    ),
    (
        {"convert": "damper"},
        [json.dumps({"data": [[i / 1024, x, 1.0, 0.0] for i, x in enumerate([0, 1, 2, 3, 1, 1, 1, 1, 9])]})],
        "time_s,displacement_mm,force_n\n0.0000000,38.1000,4448.2\n0.0039062,25.4000,4448.2\n",
    ),
    (
        {"convert": "isolation"},
        [" 1e-3 2e-3 3e-3 4e-3 5", "1 1 1 1 9", "3 3 3 3 9"],
        "time_s,displacement_mm,force_1\n0.000,2.5000,-2000.000\n",
    ),
    (
        # Out by 2e-4 and back by 1e-4.
        {"convert": "coupon"},
        ["e,s\n0,0\n0,0\n2e-4,20\n1e-4,10\n"],
        "time_s,displacement_mm,force_1\n0.0,0.00000,0.0000\n0.1,0.10000,10.0000\n0.2,0.20000,20.0000\n0.3,0.10000,10.0000\n",
    ),
]


@pytest.mark.parametrize(("file", "originals", "made"), CONVERTED, ids=lambda part: part.get("convert") if isinstance(part, dict) else "")
def test_each_form_is_converted_to_what_the_tests_read(tmp_path, mirror, file, originals, made):
    _, base = mirror
    names = []
    for i, original in enumerate(originals):
        names.append(f"a folder/{i}.txt")
        (tmp_path / "served/someone/rig" / COMMIT / names[-1]).write_text(original)
    listed = {
        "sources": {"rig": {"title": "a rig", "repository": "someone/rig", "licence": "MIT"}},
        "files": [{"source": "rig", "commit": COMMIT, "path": "x.csv", "original": names, "sha256": sha256(made), **file}],
    }
    status, said = fetch(tmp_path, listed, base)
    assert (tmp_path / "data/x.csv").read_text() == made, said
    assert status == 0, said
    # Another form is no traceback.
    (tmp_path / "data/x.csv").unlink()
    for name in names:
        (tmp_path / "served/someone/rig" / COMMIT / name).write_text("<html>moved</html>")
    status, said = fetch(tmp_path, listed, base)
    assert status == 2 and "Traceback" not in said and "nothing is written" in said, said


def test_a_file_is_made_of_one_that_is_there(tmp_path, mirror):
    _, base = mirror
    file, (original,), made = CONVERTED[1]
    listed = {
        "sources": {"peer": {"title": "a database", "address": "https://example.org", "licence": "with an account"}},
        "files": [{"source": "peer", "path": "x.csv", "from": "x.AT2", "sha256": sha256(made), **file}],
    }
    status, said = fetch(tmp_path, listed, base)
    assert status == 0 and "it is made of x.AT2, which is not there" in said, said
    (tmp_path / "data").mkdir(exist_ok=True)
    (tmp_path / "data/x.AT2").write_text(original)
    status, said = fetch(tmp_path, listed, base)
    assert status == 0 and (tmp_path / "data/x.csv").read_text() == made, said


def test_an_original_that_is_gone_is_no_missing_network(tmp_path, mirror):
    listed, base = mirror
    listed["files"][0]["original"] = "a folder/renamed.csv"
    status, said = fetch(tmp_path, listed, base)
    assert status == 1 and "HTTP 404" in said and "is there a network?" not in said
