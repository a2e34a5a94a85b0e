"""An elbow's board: told of its rig, calibrated, watched and recorded; what an elbow has not is said by name."""

from __future__ import annotations

import math
import re
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import PATIENCE_S, ROOT, Board, Client

import glenoid
from glenoid.__main__ import main
from glenoid.reasons import REASONS, explained
from glenoid.vocabulary import DATABASE, guidance

RIG = ROOT / "examples" / "elbow.toml"
#: What is found may be so many standard deviations off, and this much beyond: lengths are rounded to counts.
SIGMAS, GRANTED_MM, GRANTED_DEG = 5.0, 0.05, 0.02


@pytest.fixture
def elbow(boards: Callable[..., Board]) -> Board:
    """A board that was told of the elbow that sits at it."""
    return told(boards("--rig", str(RIG)))


def told(board: Board, **settings: float) -> Board:
    assert main(["parameters", "-c", board.channel, "load", str(RIG)]) == 0
    for name, value in settings.items():
        assert main(["parameters", "-c", board.channel, "set", name, str(value)]) == 0
    assert main(["parameters", "-c", board.channel, "save"]) == 0
    heard = board.hear(lambda message: message.name == "Module" and message["joint"] == "Hinge")
    assert heard and heard["cables_in_use"] == 4
    return board


def shown(said: str) -> dict[str, tuple[float, float]]:
    """The rows of the table: value and standard deviation."""
    row = re.compile(r"^  ((?:direction|point) in the \w+ [xyz]|along the axis) +(\S+) \+- (\S+)", re.M)
    return {name: (float(value), float(sigma)) for name, value, sigma in row.findall(said)}


def three(rows: dict[str, tuple[float, float]], name: str) -> tuple[list[float], list[float]]:
    values, sigmas = zip(*(rows[f"{name} {axis}"] for axis in "xyz"), strict=True)
    return list(values), list(sigmas)


def cross(a: list[float], b: list[float]) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def assert_near_the_true_axis(rows: dict[str, tuple[float, float]], board: Board) -> None:
    """In both bodies the direction, and how far the true axis passes by the point that was found, within the bars."""
    for body, (direction, point) in zip(("base", "forearm"), (board.true_axis[:2], board.true_axis[2:]), strict=True):
        found, sigma = three(rows, f"direction in the {body}")
        angle_deg = math.degrees(math.asin(min(1.0, math.hypot(*cross(found, direction)))))
        assert angle_deg <= SIGMAS * math.degrees(math.hypot(*sigma)) + GRANTED_DEG, (body, angle_deg, rows)
        place, sigma = three(rows, f"point in the {body}")
        off_mm = math.hypot(*cross([a - b for a, b in zip(place, point, strict=True)], direction))
        assert off_mm <= SIGMAS * math.hypot(*sigma) + GRANTED_MM, (body, off_mm, rows)
        # bars that say something
        assert math.hypot(*sigma) < 5.0, rows


def test_a_whole_run_shows_the_axis_and_puts_it_in_use(elbow: Board) -> None:
    client = Client(elbow, answers=True)
    client.wait_for("has begun: bend the joint from angle to angle")
    client.wait_for("go on to another angle and hold it")
    client.wait_for("Accept this axis?")
    client.answer("y")
    assert client.end() == 0, client.said
    rows = shown(client.said)
    assert len(rows) == 13, client.said
    assert_near_the_true_axis(rows, elbow)
    assert "none" in client.said and "deviation of the second set" in client.said
    # the angle as it is now, in degrees, of a person who bends by 0 to 120 of them
    said = re.search(r"now: HingeAngle (\S+) degrees, which leaves (\S+) mm", client.said)
    assert said and -150 < float(said[1]) < 30 and 0 <= float(said[2]) < 1, client.said
    # what is in use now stands beside the next one
    again = Client(elbow, "--yes")
    assert again.end() == 0, again.said
    direction, _ = rows["direction in the base x"]
    assert re.search(rf"direction in the base x .* {direction:.5f} \+-", again.said), again.said


def test_guidance_is_about_the_joint_that_there_is() -> None:
    assert guidance("BendFurther", is_hinge=True) == "bend the joint further before holding it"
    assert guidance("MoveOn", is_hinge=True) == "go on to another angle and hold it"
    assert guidance("MoveOn", is_hinge=False) == "go on to another pose and hold it"


def test_every_code_of_the_vocabulary_has_its_words() -> None:
    codes = DATABASE.get_message_by_name("Answer").get_signal_by_name("code").choices
    assert {str(name) for name in codes.values()} == set(REASONS)
    assert explained("SecondAxis") == (
        "SecondAxis: the joint turns about a second axis as well: it is no hinge. What to do: look for play in the orthosis; "
        "keep the forearm from turning about its length"
    )
    assert explained("Lost") == "Lost"


def test_a_rejected_axis_is_not_in_use(elbow: Board) -> None:
    client = Client(elbow, answers=True)
    client.wait_for("Accept this axis?")
    client.answer("n")
    assert client.end() == 2, client.said
    assert "ended with Rejected" in client.said
    heartbeat = elbow.hear(lambda message: message.name == "Heartbeat")
    assert heartbeat and not heartbeat["live"]


def test_an_elbow_that_never_bends_is_refused_by_name_with_the_remedy(boards: Callable[..., Board]) -> None:
    board = told(boards("--rig", str(RIG), "--person", "straight"), collecting_timeout=6000)
    client = Client(board, "--yes")
    assert client.end() == 2, client.said
    assert "pose not taken: PoseTooNear" in client.said, client.said
    assert "bend or straighten the joint further away from the angles so far" in client.said, client.said
    assert "ended with TooAlike: all poses are alike. What to do: move the arm further between the poses" in client.said


def test_what_an_elbow_has_not_is_said(elbow: Board, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", "-c", elbow.channel, "--two-phases"]) == 1
    told = capsys.readouterr().err
    assert "NotOfHinge: the joint of this board is a hinge" in told and "no phase with the shoulder blade held" in told
    script = [sys.executable, str(ROOT / "clients" / "calibrate.py"), "slcan", elbow.channel]
    ran = subprocess.run(script, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert ran.returncode == 1 and "this board's joint is a hinge" in ran.stderr, ran


def test_the_cables_of_an_elbow_are_pulled_four_in_all(elbow: Board) -> None:
    numbering = Client(elbow, command="numbering")
    for cable in range(1, 5):
        numbering.wait_for(f"pull cable {cable} (base point {cable} to end {cable} on the forearm)")
        elbow.order(f"pull {cable}")
        numbering.wait_for(f"cable {cable} is where it belongs")
    assert numbering.end() == 0, numbering.said
    assert "cable 5" not in numbering.said


def test_a_run_is_watched_and_recorded_and_identified_again(
    elbow: Board, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, csv = tmp_path / "run.log", tmp_path / "poses.csv"
    recorder, watcher = Client(elbow, str(path), command="record"), Client(elbow, command="watch")
    end = time.monotonic() + PATIENCE_S
    while not path.exists():
        assert time.monotonic() < end and recorder.process.poll() is None, recorder.said
        time.sleep(0.05)
    watcher.wait_for("Module joint=Hinge")
    client = Client(elbow, "--yes")
    assert client.end() == 0, client.said
    # only an angle that is another one is said
    watcher.wait_for("degrees, which leaves")
    for process in (recorder, watcher):
        process.process.send_signal(2)
        process.end()
    assert "CandidateHingeAxis" in watcher.said and "LiveHingePlace" in watcher.said
    assert watcher.said.count("HingeAngle") < 10, watcher.said
    assert main(["poses", str(path), "-o", str(csv)]) == 0
    assert "the board found axis" in capsys.readouterr().err
    lines = csv.read_text().splitlines()
    assert lines[0] == "set,pose,l1,l2,l3,l4" and len(lines) > 20
    # the host finds the same axis from the table
    identify = ROOT / "target" / "release" / "identify"
    ran = subprocess.run([identify, csv, "--rig", RIG, "--json"], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran
    rows = shown(client.said)
    numbers = re.findall(r"-?\d+\.\d+(?:e-?\d+)?", ran.stdout.split('"axis"')[1])[:3]
    for number, value, sigma in zip(map(float, numbers), *three(rows, "direction in the base"), strict=True):
        assert abs(number - value) < sigma + 2e-5, (ran.stdout, rows)
