"""One device on a bus: hears its messages, sends commands, notices when it falls silent."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Iterator
from types import TracebackType
from typing import Any

import can
import serial

from . import lines
from .moved_bus import MovedBus
from .vocabulary import FIRST_ID, PROTOCOL, Message, decode, encode_command

#: The heartbeat comes every 100 ms; after so long without one the device is called silent, s.
SILENCE_S = 2.0
#: Longest wait for an answer before the command is sent again, s, and how often it is sent: an emulated board on a busy machine
#: stands still for seconds.
ANSWER_S, TRIES = 0.4, 75


if lines.__name__ not in serial.protocol_handler_packages:
    serial.protocol_handler_packages.append(lines.__name__)


class DeviceError(Exception):
    """The device cannot be talked to. The text says why and what to do."""


class NoAnswer(DeviceError):
    """A command was not answered."""


class BoardSilent(DeviceError):
    """No heartbeat."""


class OtherProtocol(DeviceError):
    """The device speaks another vocabulary."""


def open_device(
    interface: str, channel: str, bitrate: int = 500_000, *, base_id: int = FIRST_ID, **options: Any
) -> Device:
    """Opens a bus and finds the device on it. `base_id` is the parameter of that name, where it is not the default.

    `interface` and `channel` are python-can's: "socketcan" and "can0", "slcan" and "/dev/ttyACM0" or
    "socket://127.0.0.1:5601", "pcan" and "PCAN_USBBUS1".
    """
    line = channel
    if interface == "slcan":
        options.setdefault("sleep_after_open", 0)
        if channel.startswith("socket://"):
            line = f"quick{channel}"
    if base_id % 64 or not 0 <= base_id <= 0x7C0:
        raise DeviceError(f"{base_id:#x} is no base identifier: a multiple of 64 up to 0x7c0 is")
    try:
        bus = can.Bus(interface=interface, channel=line, bitrate=bitrate, **options)
    except Exception as error:  # each interface of python-can has errors of its own
        raise DeviceError(f"cannot open {interface} {channel}: {error}. {_hint(interface, channel)}") from error
    moved = bus if base_id == FIRST_ID else MovedBus(bus, base_id)
    device = Device(moved, owns_bus=True, called=f"{interface} {channel}")
    try:
        device.meet()
    except BaseException:
        device.close()
        raise
    return device


def _hint(interface: str, channel: str) -> str:
    if interface not in can.VALID_INTERFACES:
        return f"python-can knows {', '.join(sorted(can.VALID_INTERFACES))}."
    if channel.startswith("socket://"):
        return "Is the emulated board running (cargo emulate --wearer)?"
    if interface == "socketcan":
        return f"Is the interface up (ip link set {channel} up type can bitrate 500000)?"
    return "Is the adapter plugged in, and may this user open it?"


class Device:
    """The device on an open bus. Messages that come while an answer is awaited are kept for `listen`."""

    def __init__(self, bus: can.BusABC | MovedBus, *, owns_bus: bool = False, called: str = "this bus") -> None:
        self.bus = bus
        self.called = called
        self.heartbeat: Message | None = None
        self.versions: Message | None = None
        self.module: Message | None = None
        self._owns_bus = owns_bus
        self._kept: deque[Message] = deque()
        self._nonce = time.time_ns() // 1000 & 0xFFFF
        self._heard = time.monotonic()

    def __enter__(self) -> Device:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Leaves the bus, if it was opened for this device. A run under way goes on."""
        if self._owns_bus:
            # an adapter that was pulled out cannot be told
            with contextlib.suppress(Exception):
                self.bus.shutdown()

    def meet(self, limit_s: float = 10.0) -> None:
        """Waits for a heartbeat, checks the vocabulary's version, and hears which joint the board is about."""
        end = time.monotonic() + limit_s
        while self.heartbeat is None:
            left = end - time.monotonic()
            if left <= 0:
                raise BoardSilent(
                    f"no heartbeat on {self.called} within {limit_s:.0f} s. Is the board on, is the bit rate "
                    "500 kbit/s, is the bus terminated? A serial line takes one client at a time: is another one "
                    "connected to it?"
                )
            self._receive(left)
        self.ask("Query")
        end = time.monotonic() + limit_s
        while self.versions is None:
            if time.monotonic() > end:
                raise BoardSilent(f"the board on {self.called} does not tell its version; ask again, or restart it")
            self._receive(0.1)
        if self.versions["protocol"] != PROTOCOL:
            raise OtherProtocol(
                f"the board speaks version {self.versions['protocol']} of the vocabulary, this client version "
                f"{PROTOCOL}: install the client that came with the board's firmware"
            )
        # it comes behind the versions
        while self.module is None and time.monotonic() < end:
            self._receive(0.1)

    @property
    def is_hinge(self) -> bool:
        """The board's joint is a hinge: an elbow."""
        return self.module is not None and self.module["joint"] == "Hinge"

    @property
    def cables(self) -> int:
        """Cables of the machine."""
        return int(self.module["cables_in_use"]) if self.module is not None else 6

    @property
    def joint(self) -> str:
        """What a calibration of this board finds, in a word."""
        return "axis" if self.is_hinge else "centre"

    @property
    def silent_s(self) -> float:
        """How long no heartbeat has come, s."""
        return time.monotonic() - self._heard

    def listen(self, seconds: float) -> Iterator[Message]:
        """Yields the device's messages until so many seconds have passed."""
        end = time.monotonic() + seconds
        while True:
            if self._kept:
                yield self._kept.popleft()
            elif (left := end - time.monotonic()) > 0:
                self._receive(left)
            else:
                return

    def ask(self, opcode: str, run: int = 0, argument: int = 0, boot: int = 0) -> Message:
        """Sends a command and returns its answer. `boot` is named by Accept and Confirm only.

        Asks again when the answer is lost: the nonce keeps the device from obeying twice.
        """
        self._nonce = self._nonce % 0xFFFF + 1
        frame = encode_command(opcode, run, argument, self._nonce, boot & 0xFF)
        for _ in range(TRIES):
            self.send(frame)
            end = time.monotonic() + ANSWER_S
            while (left := end - time.monotonic()) > 0:
                message = self._receive(left)
                if message is not None and message.name == "Answer" and message["nonce"] == self._nonce:
                    return message
        raise NoAnswer(f"no answer to {opcode} on {self.called}: is the board still on, is the bus still connected?")

    def send(self, frame: can.Message) -> None:
        """Sends a frame. Raises `DeviceError` when the bus is gone."""
        try:
            self.bus.send(frame, timeout=1.0)
        except Exception as error:
            raise self._gone(error) from error

    def receive(self, limit_s: float) -> can.Message | None:
        """The next frame, whosoever it is; None when there is none in time. Raises `DeviceError` when the bus is gone."""
        try:
            return self.bus.recv(limit_s)
        except Exception as error:
            raise self._gone(error) from error

    def _receive(self, limit_s: float) -> Message | None:
        """One frame, kept for `listen` as well."""
        frame = self.receive(limit_s)
        message = decode(frame) if frame is not None else None
        if message is None:
            return None
        if message.name == "Heartbeat":
            self.heartbeat, self._heard = message, time.monotonic()
        elif message.name == "Versions":
            self.versions = message
        elif message.name == "Module":
            self.module = message
        self._kept.append(message)
        return message

    def _gone(self, error: Exception) -> DeviceError:
        return DeviceError(
            f"{self.called} is gone ({error}). A run under way goes on at the board; start this again to join it."
        )
