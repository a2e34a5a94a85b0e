"""Every command line of the documentation works: each is run here or in `.ci/run`, or held against what it names: the
command's own help, cargo's packages and targets, the scripts that are there."""

from __future__ import annotations

import functools
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import PATIENCE_S, ROOT, Board

from glenoid.__main__ import _parser

DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "clients" / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
#: Commands of other programs that need a network, a privilege or a board on the desk, and what they are.
ELSEWHERE = (
    "pip install", "rustup target add", "cargo install", "ip link", "git clone", "cd ", "candump", "probe-rs", "python -m can.",
)
#: What stands between backquotes and is a command line.
COMMANDS = r"cargo |python -m |clients/\S+\.py|\.ci/|board-model/run|npm |node |candump |probe-rs |ip link|rustup "
#: Scripts of the tree.
SCRIPTS = (".ci/", "board-model/run", "npm ", "node ")
#: cargo's own commands.
CARGO = ("fmt", "test", "build", "run", "bench", "doc", "fuzz", "+nightly")


def lines(document: Path) -> list[str]:
    """Command lines in fenced blocks, and between backquotes."""
    text = document.read_text(encoding="utf-8")
    found: list[str] = []
    for block in re.findall(r"^```(?:sh|bash)\n(.*?)^```", text, re.M | re.S):
        found += [line.split(" #")[0].strip() for line in block.splitlines()]
    outside = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    found += re.findall(rf"`((?:GLENOID_\w+=\S+ )?(?:{COMMANDS})[^`\n]*)`", outside)
    return [line for line in found if line and not line.startswith("#")]


ALL = [(document.relative_to(ROOT).as_posix(), line) for document in DOCUMENTS for line in lines(document)]


def test_there_are_command_lines() -> None:
    assert len(ALL) > 100 and any(line.startswith("python -m glenoid calibrate") for _, line in ALL)


def aliases() -> dict[str, str]:
    text = (ROOT / ".cargo" / "config.toml").read_text()
    return dict(re.findall(r'^([\w-]+) = "(.*)"$', text.split("[alias]")[1], re.M))


@functools.cache
def known_help(name: str, *words: str) -> str:
    """What `cargo NAME --help` prints, that of a subcommand with it; "" for an alias that is cargo's own build or run of an
    image."""
    alias = aliases()[name]
    if not alias.startswith("run --quiet --release") or "thumbv7em" in alias:
        return ""
    ask = ["cargo", name, *words, "--help"]
    return subprocess.run(ask, cwd=ROOT, capture_output=True, text=True, check=True).stdout




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
        known = known_help(name)
        if "\nCommands:" in known and not words[1].startswith("-"):
            known = known_help(name, words[1])
        for option in options:
            assert not known or option in known, f"{document}: cargo {name} has no {option}"


@pytest.mark.parametrize("line", sorted({line for _, line in ALL if re.match(r"cargo (study|campaign) \w", line)}))
def test_studies_and_campaigns_exist(line: str) -> None:
    command, *names = re.sub(r"\s--.*", "", line).split()[1:]
    words = ["cargo", command, "--list" if command == "study" else "--help"]
    known = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in " ".join(names).replace("\\|", " ").split():
        assert re.search(rf"^ *{name}\b", known, re.M), f"{line}: no {name}"


def targets() -> dict[str, set[str]]:
    """Names of packages, tests, examples and binaries, as cargo knows them."""
    found: dict[str, set[str]] = {"package": set(), "fuzz": {path.stem for path in (ROOT / "fuzz/fuzz_targets").iterdir()}}
    for manifest in ("Cargo.toml", "board-model/Cargo.toml"):
        ran = subprocess.run(
            ["cargo", "metadata", "--format-version", "1", "--no-deps", "--manifest-path", manifest],
            cwd=ROOT, capture_output=True, text=True, check=True,
        )
        for package in json.loads(ran.stdout)["packages"]:
            found["package"].add(package["name"])
            for target in package["targets"]:
                found.setdefault(target["kind"][0], set()).add(target["name"])
    return found


def test_cargos_own_commands_name_what_exists() -> None:
    known = targets()
    tests = "".join(path.read_text() for path in (ROOT / "host-tests" / "tests").rglob("*.rs"))
    looked = 0
    for document, line in ALL:
        words = line.split()
        if not ("cargo " in line and set(words) & set(CARGO) or line.startswith("board-model/run")):
            continue
        for option, kind in (("-p", "package"), ("--package", "package"), ("--test", "test"), ("--example", "example"),
                             ("--bin", "bin"), ("fuzz run", "fuzz")):
            for name in re.findall(rf"{option} (\S+)", line):
                looked += 1
                assert name in known[kind] or name.isupper(), f"{document}: {line}: no {kind} {name}"
        for name in re.findall(r"--test \S+ (\w+)", line):
            assert name in tests, f"{document}: {line}: no test has {name} in its name"
    assert looked > 8


def test_scripts_that_are_named_are_there() -> None:
    scripts = json.loads((ROOT / "page" / "package.json").read_text())["scripts"]
    for document, line in ALL:
        words = line.split()
        if line.startswith((".ci/", "board-model/run", "clients/")):
            assert os.access(ROOT / words[0], os.X_OK), f"{document}: {line}"
        elif words[0] == "npm":
            assert words[-1] in scripts or words[1] == "ci", f"{document}: {line}"
        elif words[0] == "node":
            assert (ROOT / "page" / words[1]).exists(), f"{document}: {line}"


@pytest.mark.parametrize(("document", "line"), [pair for pair in ALL if "-m glenoid" in pair[1]])
def test_client_lines_are_understood(document: str, line: str) -> None:
    words = re.sub(r"[\[\]]", " ", line).split()[3:]
    if not words or any(word.isupper() for word in words) or "|" in words:
        return  # a description of the command, not a call
    _parser().parse_args(words)


def test_every_line_is_of_a_known_kind() -> None:
    for document, line in ALL:
        known = "cargo " in line or "-m glenoid" in line or line.startswith((*ELSEWHERE, *SCRIPTS, "clients/"))
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
    # both have found the board before the run begins; what the recorder asks for may come before a heartbeat
    assert watcher.stdout is not None
    while "Heartbeat" not in (line := watcher.stdout.readline()):
        assert line and watcher.poll() is None, line
    end = time.monotonic() + PATIENCE_S
    while not (tmp_path / "run.blf").exists():
        assert time.monotonic() < end, "nothing is recorded"
        time.sleep(0.1)
    said, _ = run(calibrate, factory_board, tmp_path).communicate("y\n", timeout=PATIENCE_S)
    assert "accepted, in use now" in said, said
    for process in (recorder, watcher):
        process.send_signal(signal.SIGINT)
    heard, _ = watcher.communicate(timeout=PATIENCE_S)
    assert "Outcome" in heard and "Traceback" not in heard, heard
    kept, _ = recorder.communicate(timeout=PATIENCE_S)
    assert re.search(r"\d{3,} frames in run\.blf", kept), kept
    table, _ = run(poses, factory_board, tmp_path).communicate(timeout=PATIENCE_S)
    # Poses are in the recording if the board sends their lengths by itself.
    assert "poses" in table and "Traceback" not in table, table


def test_the_protocol_in_sixty_lines(board: Board, tmp_path: Path) -> None:
    script = (ROOT / "clients" / "calibrate.py").read_text()
    line = next(line.strip().split(" #")[0] for line in script.splitlines() if line.strip().startswith("clients/"))
    process = run(line, board, tmp_path)
    said, _ = process.communicate(timeout=PATIENCE_S)
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
    said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode != 0 and "was restarted" in said, said
