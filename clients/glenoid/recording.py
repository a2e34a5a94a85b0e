"""Recordings of the bus: what a run sent, read back.

Every format that python-can reads will do: candump's .log, .asc, .blf, .trc, .csv, .db, .mf4.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

import can

from .device import DeviceError
from .joint import Heard, Hinge
from .vocabulary import FIRST_ID, LAST_ID, Message, decode

#: Cables of a machine, unless the recording says that its joint is a hinge.
CABLES = 6


@dataclass
class Pose:
    """One captured pose: L1 to L6 as the device used them, mm (of a hinge L1 to L4 at most); whether it was held out to verify."""

    index: int
    held_out: bool
    lengths_mm: list[float | None] = field(default_factory=lambda: [None] * CABLES)

    @property
    def is_whole(self) -> bool:
        return all(length is not None for length in self.lengths_mm)


@dataclass
class Run:
    """What a recording holds of one run."""

    number: int
    poses: dict[tuple[bool, int], Pose] = field(default_factory=dict)
    outcome: Message | None = None
    centre_mm: dict[str, float] = field(default_factory=dict)
    cables: int = CABLES
    found: Heard = field(default_factory=lambda: Heard("Candidate"))

    @property
    def hinge(self) -> Hinge | None:
        """What an elbow's run has found."""
        joint = self.found.joint(self.number)
        return joint if isinstance(joint, Hinge) else None

    @property
    def found_text(self) -> str:
        """What the board has found, with every digit of a centre; "" when the recording does not say it whole."""
        if self.hinge is not None:
            return str(self.hinge)
        whole = len(self.centre_mm) == 3
        return " ".join(repr(self.centre_mm[axis]) for axis in "xyz") + " mm" if whole else ""

    def whole_poses(self, held_out: bool | None = None) -> list[Pose]:
        """Poses with all six lengths, in order; of one set or of both."""
        return [
            pose
            for (second, _), pose in sorted(self.poses.items())
            if pose.is_whole and (held_out is None or second == held_out)
        ]


def gaps(run: Run) -> list[str]:
    """What is not in the recording of a run, a line a pose: lengths that were lost, and poses of which nothing is left."""
    told, poses = [], run.poses
    for second in (False, True):
        last = max((index for held_out, index in poses if held_out == second), default=-1)
        for index in range(last + 1):
            pose = poses.get((second, index))
            lost = [f"L{k + 1}" for k in range(run.cables) if pose is None or pose.lengths_mm[k] is None]
            if lost:
                what = "no length" if len(lost) == run.cables else "not " + ", ".join(lost)
                told.append(f"pose {index} of set {second + 1} is left out: {what} of it is in the recording")
    return told


def read_messages(path: str | Path) -> Iterable[Message]:
    """The device's messages in a recording, in order."""
    path = Path(path)
    if not path.is_file():
        raise DeviceError(f"{path}: no such file")
    frames = ours = 0
    try:
        with can.LogReader(path) as reader:
            for frame in reader:
                frames += 1
                if (message := decode(frame)) is not None:
                    ours += 1
                    yield message
    except DeviceError:
        raise
    except ValueError as error:
        if frames == 0:
            raise _no_recording(path, error) from error
        if ours == 0:
            raise DeviceError(f"{path}: damaged after {frames} frames ({error})") from error
        # A recording that was cut: what stands before the cut is sound.
    except Exception as error:
        if frames == 0:
            raise _no_recording(path, error) from error
    if frames == 0:
        raise DeviceError(f"{path}: no frame in it; is it a recording of the bus?")
    if ours == 0:
        raise DeviceError(f"{path}: {frames} frames, but none of the board (identifiers {FIRST_ID:X} to {LAST_ID:X})")


def _no_recording(path: Path, error: Exception) -> DeviceError:
    return DeviceError(
        f"{path}: not a recording that python-can reads ({error}). The name's ending says which it is: .log of candump, "
        ".asc, .blf, .trc, .csv, .db"
    )


#: Messages that belong to a run.
_OF_A_RUN = ("RawLength", "Outcome", "CandidateCentre", "CandidateHingeAxis", "CandidateHingePlace")


def read_runs(path: str | Path) -> list[Run]:
    """All runs in a recording, in order. Raises `DeviceError` for a file that holds none."""
    runs: list[Run] = []
    cables = CABLES
    for message in read_messages(path):
        if message.name == "Module":
            # it may come after the first poses, but never changes within a run
            cables = int(message["cables_in_use"])
            if runs and runs[-1].outcome is None:
                runs[-1].cables = cables
            continue
        if message.name not in _OF_A_RUN or message["run_id"] == 0:
            continue
        run = _run_of(runs, message, cables)
        run.found.take(message)
        if message.name == "RawLength" and 1 <= message["cable"] <= CABLES:
            key = (bool(message["held_out"]), int(message["index"]))
            run.poses.setdefault(key, Pose(key[1], key[0])).lengths_mm[message["cable"] - 1] = message["length"]
        elif message.name == "Outcome":
            run.outcome = message
        elif message.name == "CandidateCentre":
            run.centre_mm[message["axis"]] = message["value"]
    for run in runs:
        if run.hinge is not None:
            run.cables = max((k + 1 for pose in run.poses.values() for k in range(CABLES) if pose.lengths_mm[k]), default=CABLES)
        for pose in run.poses.values():
            pose.lengths_mm = pose.lengths_mm[: run.cables]
    if not any(run.whole_poses() for run in runs):
        of_six = "six" if cables == CABLES else str(cables)
        raise DeviceError(
            f"{path}: no pose with all {of_six} lengths: record during the calibration (python -m glenoid record)"
        )
    return runs


def _run_of(runs: list[Run], message: Message, cables: int) -> Run:
    """The run that a message belongs to. A length that contradicts one of the same number begins another run."""
    if runs and runs[-1].number == message["run_id"]:
        if message.name != "RawLength":
            return runs[-1]
        pose = runs[-1].poses.get((bool(message["held_out"]), int(message["index"])))
        known = pose.lengths_mm[message["cable"] - 1] if pose and 1 <= message["cable"] <= CABLES else None
        if known is None or known == message["length"]:
            return runs[-1]
    runs.append(Run(int(message["run_id"]), cables=cables))
    return runs[-1]


def read_poses(path: str | Path, run: int | None = None, held_out: bool | None = False) -> list[Pose]:
    """The whole poses of one run (the last one with any, if `run` is None).

    `held_out` chooses the set: False the first, which identifies; True the second, which verifies; None both.
    """
    runs = [r for r in read_runs(path) if r.whole_poses() and (run is None or r.number == run)]
    if not runs:
        raise DeviceError(f"{path}: no whole pose of run {run}")
    return runs[-1].whole_poses(held_out)


def write_csv(poses: Iterable[Pose], out: IO[str]) -> None:
    """A table that `cargo identify` reads, mm."""
    poses = list(poses)
    cables = max((len(pose.lengths_mm) for pose in poses), default=CABLES)
    out.write(f"set,pose,{','.join(f'l{cable}' for cable in range(1, cables + 1))}\n")
    for pose in poses:
        lengths = ",".join(_digits(length) for length in pose.lengths_mm)
        out.write(f"{2 if pose.held_out else 1},{pose.index},{lengths}\n")


def _digits(length: float | None) -> str:
    # The length came as an integer times 2^-20 mm: twelve digits behind the point hold that exactly enough.
    return "" if length is None else f"{length:.12f}".rstrip("0").rstrip(".")
