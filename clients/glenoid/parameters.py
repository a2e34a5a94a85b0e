"""The parameters of the device: read, set, saved.

What there is stands in the DBC: every parameter is a multiplexed signal of the messages ParameterRequest and Parameter. A
value that is set is prepared first; `save` checks the prepared set as a whole, stores it, and the board starts anew with it.
"""

from __future__ import annotations

import struct
import time
from dataclasses import dataclass

import can

from .device import ANSWER_S, TRIES, Device, DeviceError, NoAnswer
from .reasons import explained
from .vocabulary import DATABASE

_REQUEST = DATABASE.get_message_by_name("ParameterRequest")
_ANSWER = DATABASE.get_message_by_name("Parameter")
_CODES = _ANSWER.get_signal_by_name("code").choices
_OPERATIONS = {str(name): code for code, name in _REQUEST.get_signal_by_name("operation").choices.items()}
#: The signal for requests that are about no parameter.
_PLAIN = "plain"


class Refused(DeviceError):
    """The board does not do what was asked for. The text names its reason."""


@dataclass(frozen=True)
class Parameter:
    """One parameter as the DBC describes it."""

    name: str
    index: int
    unit: str
    is_float: bool
    comment: str

    def pack(self, value: float) -> bytes:
        """The four bytes of a value. Raises `DeviceError` for one that they cannot hold."""
        try:
            return struct.pack("<f", value) if self.is_float else struct.pack("<I", int(value))
        except (struct.error, OverflowError, ValueError) as error:
            raise DeviceError(f"{self.name}: {value} cannot be sent ({error})") from error

    def unpack(self, data: bytes) -> float:
        """The value in four bytes."""
        value: float = struct.unpack("<f" if self.is_float else "<I", data)[0]
        return value


def described() -> dict[str, Parameter]:
    """All parameters that the DBC knows, by name, in the order of their indices."""
    found = [
        Parameter(signal.name, index, signal.unit or "", bool(signal.is_float), signal.comment or "")
        for signal in _ANSWER.signals
        if signal.name != _PLAIN
        for index in signal.multiplexer_ids or ()
    ]
    return {parameter.name: parameter for parameter in sorted(found, key=lambda parameter: parameter.index)}


class Parameters:
    """The parameters of an open device."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self.known = described()
        self._nonce = time.time_ns() // 1000 & 0xFF

    def named(self, name: str) -> Parameter:
        """The parameter with this name."""
        if name not in self.known:
            near = [known for known in self.known if name.split("_")[0] in known]
            hint = f"; is one of these meant: {', '.join(near[:8])}?" if near else ""
            raise DeviceError(f"no parameter is called {name!r}{hint}")
        return self.known[name]

    def get(self, name: str, operation: str = "Read") -> float:
        """The value in use; "ReadPrepared", "ReadDefault", "ReadMinimum", "ReadMaximum" give others."""
        parameter = self.named(name)
        return parameter.unpack(self.ask(operation, parameter.index, name=name))

    def set(self, name: str, value: float) -> None:
        """Prepares a value. Nothing changes before `save`."""
        parameter = self.named(name)
        self.ask("Write", parameter.index, parameter.pack(value), name=name)

    def save(self) -> None:
        """Checks the prepared set, stores it; the board starts anew with it."""
        self.ask("Save")

    def discard(self) -> None:
        """The prepared set becomes the one in use."""
        self.ask("Discard")

    def ask(self, operation: str, index: int = 0, value: bytes = bytes(4), name: str = "") -> bytes:
        """Sends a request and returns the four bytes of its answer. Raises `Refused` for a refusal."""
        while (answer := self._ask_once(operation, index, value, name)) is None:
            # the board remembers 64 requests of a second
            time.sleep(0.2)
        return answer

    def _ask_once(self, operation: str, index: int, value: bytes, name: str) -> bytes | None:
        """The answer; None when the board has been asked too much within a second."""
        self._nonce = self._nonce % 0xFF + 1
        head = struct.pack("<HBB", _OPERATIONS[operation] | index << 4, self._nonce, 0)
        frame = can.Message(arbitration_id=_REQUEST.frame_id, is_extended_id=False, data=head + value)
        for _ in range(TRIES):
            self.device.send(frame)
            end = time.monotonic() + ANSWER_S
            while (left := end - time.monotonic()) > 0:
                heard = self.device.receive(left)
                if heard is None or heard.arbitration_id != _ANSWER.frame_id or len(heard.data) != 8:
                    continue
                first, nonce, code = struct.unpack("<HBB", heard.data[:4])
                if nonce != self._nonce or first & 0xF != _OPERATIONS[operation]:
                    continue
                if str(_CODES.get(code)) == "TooManyCommands":
                    return None
                if code != 0:
                    about = f" {name}" if name else ""
                    raise Refused(f"{operation}{about} was refused: {explained(str(_CODES.get(code, code)))}")
                return bytes(heard.data[4:])
        raise NoAnswer(f"no answer to {operation} on {self.device.called}")
