"""The emulated board with a person at its arm, for tests of the client."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import glenoid
import pytest

ROOT = Path(__file__).resolve().parents[2]
EMULATE = ROOT / "target" / "release" / "emulate"


#: Settings of most tests: a run that says nothing about accuracy need not take the poses that accuracy needs.
QUICK = {"hold_time": 150, "enough_poses": 8, "target_sigma": 0.5, "verification_poses": 3}
#: The person of most tests holds a pose just as long, and moves as fast as the drums may turn, ms.
NIMBLE = ("--hold", "300", "--move", "400")


#: Longest wait for anything, s: a machine that has too much to do gets the time that it needs.
PATIENCE_S = 300.0


class Board:
    """A running `cargo emulate --wearer`."""

    def __init__(self, *arguments: str) -> None:
        command = [EMULATE, "--yes", "--wearer", "--can-port", "0", "--rig-port", "0"]
        self.process = subprocess.Popen(
            [*command, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            # a group of its own, so that `kill` reaches the emulator too
            start_new_session=True,
        )
        assert self.process.stdout is not None
        self.said = ""
        for line in self.process.stdout:
            self.said += line
            if "Ctrl-C ends" in line:
                break
        match = re.search(r"true centre (\S+) (\S+) (\S+) mm", self.said)
        axis = re.search(r"true axis (.*) through (.*) mm, in the forearm (.*) through (.*) mm", self.said)
        channel = re.search(r"-c (socket://\S+)", self.said)
        assert (match or axis) and channel, self.said
        #: A ball's centre; of a hinge the axis: direction and place in the base, direction and place in the forearm.
        self.truth = tuple(float(number) for number in match.groups()) if match else ()
        self.true_axis = [[float(word) for word in part.split()] for part in axis.groups()] if axis else []
        self.channel = channel[1]

    def order(self, word: str) -> None:
        """press, release, silent, sound, reset."""
        assert self.process.stdin is not None
        self.process.stdin.write(word + "\n")
        self.process.stdin.flush()

    def hear(self, found: Callable[[glenoid.Message], bool], seconds: float = PATIENCE_S) -> glenoid.Message | None:
        """The board's first message from now on that is the wanted one; None when there is none in so many seconds."""
        with glenoid.open_device("slcan", self.channel) as device:
            device.ask("Query")
            return next((message for message in device.listen(seconds) if found(message)), None)

    def wait_for_state(self, name: str) -> None:
        assert self.hear(lambda message: message.name == "Heartbeat" and message["state"] == name), name

    def wait_for_fault(self, code: str) -> None:
        assert self.hear(lambda message: message.name == "Fault" and message["active"] and message["code"] == code), code

    def start_by_button(self) -> None:
        """Once more, if no run begins: on a busy machine a press may last too long or too short."""
        for _ in range(10):
            self.press(2.2)
            if self.hear(lambda message: message.name == "Heartbeat" and message["state"] != "Idle", 10):
                return
        raise AssertionError("the button did not start a run")

    def press(self, seconds: float) -> None:
        self.order("press")
        time.sleep(seconds)
        self.order("release")

    def accept_by_button(self, checksum: int) -> None:
        """As many short presses as the LED blinks, then a long one."""
        for _ in range(checksum % 3 + 2):
            self.press(0.3)
            time.sleep(0.4)
        self.press(2.2)

    def stall(self, seconds: float) -> None:
        """The emulator gets no processor for so long, as on a machine that has too much to do."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        # the emulator was started by another thread than the first, perhaps
        if not children:
            tasks = Path(f"/proc/{self.process.pid}/task").iterdir()
            children = [child for task in tasks for child in (task / "children").read_text().split()]
        for child in map(int, children):
            os.kill(child, signal.SIGSTOP)
        time.sleep(seconds)
        for child in map(int, children):
            os.kill(child, signal.SIGCONT)

    def kill(self) -> None:
        """As when the power goes: the board and the emulator beneath it."""
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait(PATIENCE_S)

    def end(self) -> None:
        self.process.send_signal(signal.SIGINT)
        self.process.wait(PATIENCE_S)


class Client:
    """A running `python -m glenoid COMMAND` on a board."""

    def __init__(self, board: Board, *arguments: str, command: str = "calibrate", answers: bool = False) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-u", "-m", "glenoid", command, "-i", "slcan", "-c", board.channel, *arguments],
            stdin=subprocess.PIPE if answers else subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT / "clients",
            # a shell that runs the tests in the background lets them ignore Ctrl-C
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL) and None,
        )
        self.said = ""
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def wait_for(self, text: str, seconds: float = PATIENCE_S) -> None:
        end = time.monotonic() + seconds
        while text not in self.said:
            if self.process.poll() is not None or time.monotonic() > end:
                self.reader.join(1)
                assert text in self.said, f"{text!r} is not said (exit {self.process.poll()}): {self.said}"
            time.sleep(0.05)

    def answer(self, text: str) -> None:
        assert self.process.stdin is not None
        # one that has ended needs no answer
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.write(text + "\n")
            self.process.stdin.flush()

    def end(self, seconds: float = PATIENCE_S) -> int:
        """The exit status, when it has ended by itself."""
        end = time.monotonic() + seconds
        while self.process.poll() is None:
            assert time.monotonic() < end, f"the client does not end: {self.said}"
            time.sleep(0.05)
        self.reader.join(1)
        return self.process.returncode

    def read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.said += line


@pytest.fixture(scope="session")
def quick_flash(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The flash of a board that holds the quick settings: saved once over the bus, copied for every board."""
    flash = tmp_path_factory.mktemp("flash") / "quick"
    board = Board("--record", str(flash))
    with glenoid.open_device("slcan", board.channel) as device:
        parameters = glenoid.Parameters(device)
        for name, value in QUICK.items():
            parameters.set(name, value)
        parameters.save()
    board.end()
    return flash


@pytest.fixture
def boards(quick_flash: Path, tmp_path: Path) -> Iterator[Callable[..., Board]]:
    """Starts boards that end with the test: with the quick settings and a nimble person, or as they come from the factory."""
    if not EMULATE.exists():
        pytest.fail(f"{EMULATE} is not built: cargo build --release --package host-tests --bin emulate")
    running: list[Board] = []

    def start(*arguments: str, quick: bool = True) -> Board:
        if quick:
            flash = shutil.copy(quick_flash, tmp_path / f"flash-{len(running)}")
            arguments = (*NIMBLE, "--record", str(flash), *arguments)
        running.append(Board(*arguments))
        return running[-1]

    yield start
    for board in running:
        board.end()


@pytest.fixture
def board(boards: Callable[..., Board]) -> Board:
    """With the quick settings."""
    return boards()


@pytest.fixture
def factory_board(boards: Callable[..., Board]) -> Board:
    """As it comes from the factory."""
    return boards(quick=False)
