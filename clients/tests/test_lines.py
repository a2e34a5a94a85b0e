"""What goes wrong between client and board: a silent line, an adapter that is pulled out, a board of another vocabulary.

The adapter is a pseudo-terminal: no emulator is needed for it.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import select
import struct
import subprocess
import sys
import termios
import threading
import time
import tty
from collections.abc import Iterator

import pytest
from conftest import PATIENCE_S, ROOT

import glenoid
from glenoid.__main__ import _parser, main
from glenoid.vocabulary import DATABASE


def line_of(name: str, **fields: object) -> bytes:
    """A message of the board as a line of SLCAN; every field that is not named is 0."""
    message = DATABASE.get_message_by_name(name)
    data = message.encode({signal.name: 0 for signal in message.signals} | fields)
    return f"t{message.frame_id:03X}{len(data)}{data.hex().upper()}\r".encode()


class Adapter:
    """An SLCAN adapter on a pseudo-terminal, with a board behind it that beats, answers and tells its version."""

    def __init__(self, protocol: int = glenoid.PROTOCOL, silent: bool = False) -> None:
        self.ours, theirs = pty.openpty()
        tty.setraw(theirs)
        self.path, self.protocol, self.silent = os.ttyname(theirs), protocol, silent
        self.heard: list[bytes] = []
        self.beats = 0
        self.plugged = True
        self.theirs = theirs
        self.threads = [threading.Thread(target=work, daemon=True) for work in (self.beat, self.listen)]
        for thread in self.threads:
            thread.start()

    def beat(self) -> None:
        while self.plugged:
            if not self.silent:
                self.say(line_of("Heartbeat", state="Collecting", run_id=7))
                self.beats += 1
            time.sleep(0.1)

    def listen(self) -> None:
        waiting = b""
        while self.plugged:
            if not select.select([self.ours], [], [], 0.05)[0]:
                continue
            with contextlib.suppress(OSError):
                waiting += os.read(self.ours, 1024)
            *lines, waiting = waiting.split(b"\r")
            for line in lines:
                self.heard.append(line)
                if line.startswith(b"t6808") and not self.silent:
                    command = DATABASE.get_message_by_name("Command").decode(bytes.fromhex(line[5:].decode()))
                    self.say(line_of("Answer", opcode=command["opcode"], nonce=command["nonce"], run_id=7))
                    if command["opcode"] == "Query":
                        self.say(line_of("Versions", protocol=self.protocol))
                        self.say(line_of("Module", cables_in_use=6))

    def say(self, line: bytes) -> None:
        with contextlib.suppress(OSError):
            os.write(self.ours, line)

    def wait_for_beats(self, count: int) -> None:
        """Until the client has taken so many more heartbeats from the line."""
        last, end = self.beats + count, time.monotonic() + PATIENCE_S
        while self.beats < last or self.unread():
            assert time.monotonic() < end, "the client does not read"
            time.sleep(0.02)

    def unread(self) -> int:
        """Bytes that wait for the client."""
        (count,) = struct.unpack("i", fcntl.ioctl(self.theirs, termios.FIONREAD, bytes(4)))
        return int(count)

    def unplug(self) -> None:
        if self.plugged:
            self.plugged = False
            # a line that somebody reads from would stay open
            for thread in self.threads:
                thread.join()
            os.close(self.theirs)
            os.close(self.ours)


@pytest.fixture
def adapters() -> Iterator[type[Adapter]]:
    made: list[Adapter] = []

    class Kept(Adapter):
        def __init__(self, **options: object) -> None:
            super().__init__(**options)  # type: ignore[arg-type]
            made.append(self)

    yield Kept
    for adapter in made:
        adapter.unplug()


def client(adapter: Adapter, *arguments: str) -> subprocess.Popen[str]:
    words = [sys.executable, "-u", "-m", "glenoid", *arguments, "-i", "slcan", "-c", adapter.path]
    return subprocess.Popen(
        words, cwd=ROOT / "clients", stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def test_an_adapter_that_hears_nothing_is_no_board(adapters: type[Adapter]) -> None:
    """As with a wrong bit rate, a board that is off, a bus without its end."""
    adapter = adapters(silent=True)
    process = client(adapter, "calibrate")
    said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1, said
    assert "no heartbeat" in said and "is the bit rate 500 kbit/s" in said and "Traceback" not in said, said
    # the adapter was told that rate, and to open
    assert b"S6" in adapter.heard and b"O" in adapter.heard, adapter.heard


@pytest.mark.parametrize("command", ["calibrate", "watch"])
def test_an_adapter_that_is_pulled_out_is_gone(adapters: type[Adapter], command: str) -> None:
    adapter = adapters()
    process = client(adapter, command)
    assert process.stdout is not None
    # `calibrate` joins the run, `watch` shows the first heartbeat
    first = process.stdout.readline()
    assert "run 7 is under way" in first or "Heartbeat" in first, first
    adapter.wait_for_beats(5)
    adapter.unplug()
    said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1, said
    assert "is gone" in said and "start this again to join it" in said and "Traceback" not in said, said


def test_a_recording_whose_adapter_is_pulled_out_keeps_what_was_heard(adapters: type[Adapter], tmp_path: object) -> None:
    adapter, path = adapters(), f"{tmp_path}/run.log"
    process = client(adapter, "record", path)
    # it asks for the version, and records from then on
    end = time.monotonic() + PATIENCE_S
    while not any(line.startswith(b"t6808") for line in adapter.heard):
        assert time.monotonic() < end, "the client does not ask"
        time.sleep(0.05)
    adapter.wait_for_beats(20)
    adapter.unplug()
    said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1 and "is gone" in said and "Traceback" not in said, said
    assert len(open(path).readlines()) > 5


def test_parameters_of_a_board_whose_adapter_is_pulled_out(adapters: type[Adapter]) -> None:
    adapter = adapters()
    process = client(adapter, "parameters", "list")
    # it asks for the first one, and nobody answers
    end = time.monotonic() + PATIENCE_S
    while not any(line.startswith(b"t698") for line in adapter.heard):
        assert time.monotonic() < end, "the client does not ask"
        time.sleep(0.05)
    adapter.unplug()
    said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1 and "is gone" in said and "Traceback" not in said, said


def test_a_board_of_another_vocabulary_is_not_talked_to(adapters: type[Adapter]) -> None:
    adapter = adapters(protocol=glenoid.PROTOCOL + 1)
    process = client(adapter, "calibrate")
    said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1, said
    assert f"the board speaks version {glenoid.PROTOCOL + 1}" in said and "install the client that came with" in said, said
    assert not any(line.startswith(b"t680801") for line in adapter.heard), "it was told to start"


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("calibrate --frobnicate", "unrecognized arguments: --frobnicate"),
        ("parameters set hold_time", "the following arguments are required: value"),
        ("parameters set hold_time long", "invalid float value: 'long'"),
        ("", "the following arguments are required: COMMAND"),
    ],
)
def test_a_wrong_command_line_is_told_and_is_not_the_end_of_a_run(
    line: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(line.split())
    assert ended.value.code == 1 and told in capsys.readouterr().err


def test_the_bus_may_be_named_before_or_behind_what_is_to_be_done() -> None:
    for line in ("parameters -c x list", "parameters list -c x"):
        options = _parser().parse_args(line.split())
        assert (options.channel, options.interface) == ("x", "slcan")


def test_a_recording_that_cannot_be_written_is_told(adapters: type[Adapter], tmp_path: object) -> None:
    for path, told in ((f"{tmp_path}/nowhere/run.log", "cannot be written"), (f"{tmp_path}/run", "take a name that ends in")):
        said, _ = (process := client(adapters(), "record", path)).communicate(timeout=PATIENCE_S)
        assert process.returncode == 1 and told in said and "Traceback" not in said, said


def test_a_device_that_is_not_there_says_so(tmp_path: object) -> None:
    with pytest.raises(glenoid.DeviceError, match="Is the adapter plugged in, and may this user open it"):
        glenoid.open_device("slcan", f"{tmp_path}/ttyACM0")
    with pytest.raises(glenoid.DeviceError, match="cannot open nonsense.*python-can knows .*slcan, socketcan"):
        glenoid.open_device("nonsense", "can0")
