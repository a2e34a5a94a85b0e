"""Every command line of the documentation works: each is run, or its options are held against the command's own help."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import ROOT, Board

from glenoid.__main__ import _parser

DOCUMENTS = [ROOT / "README.md", ROOT / "clients" / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
#: Commands of other programs that need a network, a privilege or a board on the desk, and what they are.
ELSEWHERE = ("pip install", "rustup target add", "cargo install", "npm ", "ip link", "git clone", "cd ")
#: cargo's own commands.
CARGO = ("test", "build", "run", "bench", "doc", "fuzz", "+nightly")


def lines(document: Path) -> list[str]:
    """Command lines in fenced blocks, and `cargo …` or `python -m glenoid …` between backquotes."""
    text = document.read_text(encoding="utf-8")
    found: list[str] = []
    for block in re.findall(r"^```(?:sh|bash)\n(.*?)^```", text, re.M | re.S):
        found += [line.split(" #")[0].strip() for line in block.splitlines()]
    outside = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    found += re.findall(r"`((?:GLENOID_\w+=\S+ )?(?:cargo|python -m glenoid|clients/\S+\.py) [^`]+)`", outside)
    return [line for line in found if line and not line.startswith("#")]


ALL = [(document.relative_to(ROOT).as_posix(), line) for document in DOCUMENTS for line in lines(document)]


def test_there_are_command_lines() -> None:
    assert len(ALL) > 60 and any(line.startswith("python -m glenoid calibrate") for _, line in ALL)


def aliases() -> dict[str, str]:
    text = (ROOT / ".cargo" / "config.toml").read_text()
    return dict(re.findall(r'^([\w-]+) = "(.*)"$', text.split("[alias]")[1], re.M))


def help_of(name: str) -> str:
    """What `cargo NAME --help` prints; "" for an alias that is cargo's own build or run of an image."""
    alias = aliases()[name]
    if not alias.startswith("run --quiet --release") or "thumbv7em" in alias:
        return ""
    return subprocess.run(["cargo", name, "--help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout


_HELP: dict[str, str] = {}


@pytest.mark.parametrize(("document", "line"), [pair for pair in ALL if "cargo " in pair[1]])
def test_cargo_lines_name_options_that_exist(document: str, line: str) -> None:
    words = re.sub(r"[\[\]…|]", " ", line).split()
    words = words[words.index("cargo") + 1 :]
    name = words[0]
    if line.startswith(ELSEWHERE) or name in CARGO:
        return
    assert name in aliases(), f"{document}: cargo {name} is no command"
    options = [word.split("=")[0] for word in words[1:] if word.startswith("--") and word != "--"]
    if options:
        known = _HELP.setdefault(name, help_of(name))
        for option in options:
            assert not known or option in known, f"{document}: cargo {name} has no {option}"


@pytest.mark.parametrize(("document", "line"), [pair for pair in ALL if "-m glenoid" in pair[1]])
def test_client_lines_are_understood(document: str, line: str) -> None:
    words = re.sub(r"[\[\]]", " ", line).split()[3:]
    if not words or any(word.isupper() for word in words) or "|" in words:
        return  # a description of the command, not a call
    _parser().parse_args(words)


def test_every_line_is_of_a_known_kind() -> None:
    for document, line in ALL:
        known = "cargo " in line or "-m glenoid" in line or line.startswith((*ELSEWHERE, "clients/"))
        known = known or line.startswith("python -m can")
        assert known, f"{document}: {line!r} is run by no test"


def run(line: str, board: Board, folder: Path, seconds: float = 0, answer: str = "") -> subprocess.Popen[str]:
    """Starts a documented line with this board for the documented one."""
    words = shlex.split(line.replace("socket://127.0.0.1:5601", board.channel))
    if words[0] == "python":
        words[0] = sys.executable
        if words[3] in ("calibrate", "watch", "record") and "-c" not in words:
            words += ["-c", board.channel]
    else:
        words = [sys.executable, str(ROOT / words[0]), *words[1:]]
    return subprocess.Popen(
        words, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL) and None,
    )


def test_the_package_as_documented(factory_board: Board, tmp_path: Path) -> None:
    """README of the package, in its order, as somebody at a terminal would."""
    documented = lines(ROOT / "clients" / "README.md")
    calibrate, watch, record, poses = (
        next(line for line in documented if line.startswith(f"python -m glenoid {command}"))
        for command in ("calibrate", "watch", "record", "poses")
    )
    recorder, watcher = run(record, factory_board, tmp_path), run(watch, factory_board, tmp_path)
    # both have found the board before the run begins
    assert watcher.stdout is not None and "Heartbeat" in watcher.stdout.readline()
    end = time.monotonic() + 60
    while not (tmp_path / "run.blf").exists():
        assert time.monotonic() < end, "nothing is recorded"
        time.sleep(0.1)
    said, _ = run(calibrate, factory_board, tmp_path).communicate("y\n", timeout=120)
    assert "accepted, in use now" in said, said
    for process in (recorder, watcher):
        process.send_signal(signal.SIGINT)
    heard, _ = watcher.communicate(timeout=20)
    assert "Outcome" in heard and "Traceback" not in heard, heard
    kept, _ = recorder.communicate(timeout=20)
    assert re.search(r"\d{3,} frames in run\.blf", kept), kept
    table, _ = run(poses, factory_board, tmp_path).communicate(timeout=20)
    # Poses are in the recording if the board sends their lengths by itself.
    assert "poses" in table and "Traceback" not in table, table


def test_the_protocol_in_sixty_lines(board: Board, tmp_path: Path) -> None:
    script = (ROOT / "clients" / "calibrate.py").read_text()
    line = next(line.strip().split(" #")[0] for line in script.splitlines() if line.strip().startswith("clients/"))
    process = run(line, board, tmp_path)
    said, _ = process.communicate(timeout=120)
    assert process.returncode == 0, said
    found = [float(number) for number in re.findall(r"^[xyz]: +(-?[\d.]+)", said, re.M)]
    assert all(abs(a - b) < 0.5 for a, b in zip(found, board.truth, strict=True)), (said, board.truth)


def test_the_protocol_in_sixty_lines_ends_when_the_board_is_reset(board: Board, tmp_path: Path) -> None:
    process = run("clients/calibrate.py slcan socket://127.0.0.1:5601", board, tmp_path)
    assert process.stdout is not None
    # the run has begun
    while "pose" not in (line := process.stdout.readline()):
        assert line and process.poll() is None, line
    board.order("reset")
    said, _ = process.communicate(timeout=60)
    assert process.returncode != 0 and "was restarted" in said, said
