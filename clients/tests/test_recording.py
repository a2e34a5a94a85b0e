"""Recordings of every format give the poses back, and a damaged one says what is wrong."""

from __future__ import annotations

import io
import json
import struct
import subprocess
import time
from pathlib import Path

import can
import pytest
from conftest import PATIENCE_S, ROOT, Board, Client

import glenoid
from glenoid.__main__ import main

FORMATS = ["log", "asc", "blf", "trc", "csv", "db"]


def raw_length(run: int, index: int, cable: int, held_out: bool, length: float) -> can.Message:
    """RawLength (1679) written out by hand: run, index, cable and set, length in 2^-20 mm."""
    data = run.to_bytes(2, "little") + bytes([index, cable | held_out << 4]) + int(length * 2**20).to_bytes(4, "little")
    return can.Message(arbitration_id=0x68F, is_extended_id=False, data=data, timestamp=1.7e9 + index + cable / 10)


def run_frames(number: int, poses: int, held_out: int, offset: float = 0.0) -> list[can.Message]:
    frames = []
    for index in range(poses + held_out):
        second = index >= poses
        for cable in range(1, 7):
            length = 200 + 10 * cable + index + offset + 0.25
            frames.append(raw_length(number, index - poses * second, cable, second, length))
            frames.append(can.Message(arbitration_id=0x181, is_extended_id=False, data=b"\1\2", timestamp=1.7e9))
    return frames


def write(path: Path, frames: list[can.Message]) -> Path:
    with can.Logger(str(path)) as logger:
        for frame in frames:
            logger(frame)
    return path


@pytest.mark.parametrize("ending", FORMATS)
def test_every_format_gives_the_poses(tmp_path: Path, ending: str) -> None:
    path = write(tmp_path / f"run.{ending}", run_frames(3, 4, 2))
    first, both = glenoid.read_poses(path), glenoid.read_poses(path, held_out=None)
    assert [pose.index for pose in first] == [0, 1, 2, 3]
    assert first[2].lengths_mm == [212.25, 222.25, 232.25, 242.25, 252.25, 262.25]
    assert [pose.held_out for pose in both] == [False] * 4 + [True] * 2


def test_the_last_run_is_taken_and_any_can_be_asked_for(tmp_path: Path) -> None:
    path = write(tmp_path / "two.log", run_frames(3, 4, 0) + run_frames(4, 2, 0, 5.0))
    assert len(glenoid.read_poses(path)) == 2
    assert len(glenoid.read_poses(path, run=3)) == 4
    # a board that was reset may use a number twice
    again = write(tmp_path / "again.log", run_frames(3, 4, 0) + run_frames(3, 2, 0, 5.0))
    assert [len(run.whole_poses()) for run in glenoid.read_runs(again)] == [4, 2]


def test_the_table_is_read_by_cargo_identify_and_by_people(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path / "run.blf", run_frames(3, 2, 1))
    assert main(["poses", str(path), "-o", str(tmp_path / "poses.csv")]) == 0
    assert (tmp_path / "poses.csv").read_text().splitlines() == [
        "set,pose,l1,l2,l3,l4,l5,l6",
        "1,0,210.25,220.25,230.25,240.25,250.25,260.25",
        "1,1,211.25,221.25,231.25,241.25,251.25,261.25",
    ]
    assert "run 3, 2 poses" in capsys.readouterr().err
    assert main(["poses", str(path), "--set", "2"]) == 0
    assert capsys.readouterr().out.splitlines()[1].startswith("2,0,212.25")


def test_a_length_comes_back_to_the_last_bit() -> None:
    out, step = io.StringIO(), 2.0**-20
    poses = [glenoid.Pose(0, False, [210 + k * step for k in (1, 3, 12345, 999_999, 2**19 + 1, 0)])]
    glenoid.write_csv(poses, out)
    numbers = [float(cell) for cell in out.getvalue().splitlines()[1].split(",")[2:]]
    assert [round(number / step) for number in numbers] == [round(length / step) for length in poses[0].lengths_mm if length]


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.log", b"", "no frame in it"),
        ("a.log", b"(1.0) can0 181#0102\n", "none of the board"),
        ("a.log", b"(1.0) can0 682#0000000000000000\n", "no pose with all six lengths"),
        ("a.txt", b"hello", "not a recording that python-can reads"),
        ("a.blf", b"this is no BLF file at all" * 10, "not a recording that python-can reads"),
        ("a.log", b"\x00\x01\x02 nonsense", "not a recording that python-can reads"),
    ],
)
def test_a_file_that_is_no_recording_says_so(tmp_path: Path, name: str, content: bytes, told: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(glenoid.DeviceError, match=told):
        glenoid.read_poses(tmp_path / name)
    assert main(["poses", str(tmp_path / name)]) == 1


def test_a_recording_that_was_cut_gives_what_stands_before_the_cut(tmp_path: Path) -> None:
    path = write(tmp_path / "run.log", run_frames(3, 4, 2))
    text = path.read_text()
    path.write_text(text[: len(text) * 2 // 3 - 7])
    assert 1 < len(glenoid.read_poses(path, held_out=None)) < 6


def test_a_recording_with_gaps_says_which_pose_lacks_what(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def lost(frame: can.Message) -> bool:
        """Two lengths of pose 1, all of pose 2, one of the first pose that verifies."""
        pose, cable = frame.data[2:3], frame.data[3:4]
        return pose == b"\2" and cable < b"\x10" or bytes(pose + cable) in (b"\1\2", b"\1\5", b"\0\x16")

    path = write(tmp_path / "run.log", [frame for frame in run_frames(3, 5, 2) if not lost(frame)])
    assert main(["poses", str(path), "--set", "both"]) == 0
    table, told = capsys.readouterr()
    assert [line.split(",")[:2] for line in table.splitlines()[1:]] == [["1", "0"], ["1", "3"], ["1", "4"], ["2", "1"]]
    assert told.splitlines()[1:] == [
        f"{path}: pose 1 of set 1 is left out: not L2, L5 of it is in the recording",
        f"{path}: pose 2 of set 1 is left out: no length of it is in the recording",
        f"{path}: pose 0 of set 2 is left out: not L6 of it is in the recording",
    ]


def centre_in_use(board: Board) -> list[float]:
    with glenoid.open_device("slcan", board.channel) as device:
        device.ask("Query")
        values: dict[str, float] = {}
        for message in device.listen(PATIENCE_S):
            if message.name == "LiveCentre":
                values[message["axis"]] = message["value"]
            if len(values) == 3:
                return [values[axis] for axis in "xyz"]
    raise AssertionError(f"of the centre in use only {values} is told")


def test_a_recorded_run_identifies_the_centre_that_the_board_found(
    board: Board, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What `record` wrote during a run: `poses` and `cargo identify` give the board's own centre."""
    path = tmp_path / "run.log"
    recorder = Client(board, str(path), command="record")
    # it has opened the bus before it opens its file: no pose is missed
    end = time.monotonic() + PATIENCE_S
    while not path.exists():
        assert time.monotonic() < end and recorder.process.poll() is None, recorder.said
        time.sleep(0.05)
    client = Client(board, "--yes")
    assert client.end() == 0, client.said
    recorder.process.send_signal(2)
    assert recorder.end() == 0, recorder.said
    centre = centre_in_use(board)
    identify = ROOT / "target" / "release" / "identify"
    # the recording itself: the board's own arithmetic once more, and what the board showed, to the last digit
    ran = subprocess.run([identify, path, "--json"], capture_output=True, text=True)
    note = next(line for line in ran.stderr.splitlines() if "the board found" in line)
    assert "in run 1; its calculation gives the same here, to the last digit" in note, ran
    # printed with as many digits as a single-precision number needs
    shown = [struct.pack("<f", float(word)) for word in note.split("the board found ")[1].split()[:3]]
    assert shown == [struct.pack("<f", value) for value in centre]
    # the table of its poses, on the machine that is compiled in
    csv = tmp_path / "poses.csv"
    assert main(["poses", str(path), "-o", str(csv)]) == 0
    assert f"the board found {centre[0]!r} {centre[1]!r} {centre[2]!r} mm" in capsys.readouterr().err
    arguments = [identify, csv, "--json", "--noise", "0.057735026"]
    ran = subprocess.run(arguments, capture_output=True, text=True)
    assert ran.returncode == 0, ran
    found = json.loads(ran.stdout)["centre_mm"]
    assert all(abs(a - b) < 2e-4 for a, b in zip(found, centre, strict=True)), (found, centre)


def consumer(lines: list[str]) -> list[str]:
    """What the example of a consumer says to a recording."""
    command = ["cargo", "run", "--quiet", "--release", "--example", "live_consumer"]
    ran = subprocess.run(command, cwd=ROOT, input="\n".join(lines), capture_output=True, text=True, check=True)
    return [line.split(": ", 1)[1] for line in ran.stdout.splitlines()]


def test_a_consumer_goes_by_the_centre_in_use_and_by_no_broken_set(board: Board, tmp_path: Path) -> None:
    client = Client(board, "--yes")
    assert client.end() == 0, client.said
    path = tmp_path / "run.log"
    recorder = Client(board, str(path), "--seconds", "6", command="record")
    assert recorder.end() == 0, recorder.said
    # a frame a millisecond: how evenly they came is not the board's alone
    lines = [f"({k / 1000:.6f}){line.split(')', 1)[1]}" for k, line in enumerate(path.read_text().splitlines())]
    pieces = [at for at, line in enumerate(lines) if " 69A#" in line]
    assert len(pieces) > 16 * 10
    told = consumer(lines)
    # before the first set is whole there is no centre; then there is one, the one in use, and nothing else is said
    assert told[0] == "no centre" and len(told) == 2, told
    used = [float(word) for word in told[1].removeprefix("centre [").rstrip("]").split(", ")]
    centre = centre_in_use(board)
    assert all(abs(a - b) < 1e-4 for a, b in zip(used, centre, strict=True)), (used, centre)

    first = next(k for k, at in enumerate(pieces) if int(lines[at].split("#")[1][:2], 16) & 0x1F == 0)
    sets = [pieces[k : k + 16] for k in range(first, len(pieces) - 15, 16)]
    piece = lambda of, at: lines[sets[of][at]].split("#")[1].split()[0]  # noqa: E731
    damaged = list(lines)
    # a set whose end is another one's, one with another byte, one that lacks a piece, one that comes again
    for at in range(8, 16):
        damaged[sets[3][at]] = damaged[sets[3][at]].replace(piece(3, at), piece(2, at))
    byte = piece(5, 9)
    damaged[sets[5][9]] = damaged[sets[5][9]].replace(byte, byte[:-1] + format(int(byte[-1], 16) ^ 1, "X"))
    damaged[sets[7][4]] = ""
    for at in range(16):
        damaged[sets[9][at]] = damaged[sets[9][at]].replace(piece(9, at), piece(8, at))
    told = consumer(damaged)
    assert [line for line in told if line.startswith("centre")] == [f"centre {used}"], told
    assert any("refused" in line for line in told) and any("repeated" in line for line in told), told
    assert any("sets lost" in line for line in told), told
    # silence: what was good is stale
    later = [f"({float(lines[-1][1:].split(')')[0]) + 0.6:.6f}) can0 001#00"]
    assert consumer([*lines, *later])[-1] == "no centre"
