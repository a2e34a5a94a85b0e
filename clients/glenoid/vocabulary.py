"""The messages of `glenoid.dbc`, and the remedy for each reason."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import can
import cantools

DATABASE: Any = cantools.database.load_file(Path(__file__).with_name("glenoid.dbc"))
COMMAND: Any = DATABASE.get_message_by_name("Command")

#: Number of this vocabulary. A device that speaks another one is not talked to.
PROTOCOL = int(DATABASE.version)

#: What a client sends, and what goes by many times a second for controllers and views, is not decoded here.
_LEFT = ("Command", "ParameterRequest", "LiveSet", "Telemetry")
_SENT = {message.frame_id: message for message in DATABASE.messages if message.name not in _LEFT}

#: The identifiers of the board.
FIRST_ID, LAST_ID = COMMAND.frame_id, COMMAND.frame_id + 63

#: What a person should do, by the heartbeat's guidance.
GUIDANCE = {
    "Nothing": "",
    "MoveOn": "go on to another pose and hold it",
    "MoveFurther": "move further away from the poses so far",
    "TiltMore": "tilt the arm more",
    "TurnAboutLength": "turn the arm about its own length",
    "AnotherPlane": "tilt the arm in another plane",
    "HoldBlade": "hold the shoulder blade still, move the arm to another pose and hold it",
    "ReleaseBlade": "let the shoulder blade go, move the arm to another pose and hold it",
    "BendFurther": "bend the joint further before holding it",
    "TightenCable": "tighten the named cable",
    "CheckEncoders": "check the encoders",
    "Wait": "wait: the device computes",
    "Decide": "decide: accept or reject",
    "Acknowledge": "see why the run ended",
}

#: What differs where the joint is a hinge.
_GUIDANCE_OF_HINGE = {
    "MoveOn": "go on to another angle and hold it",
    "MoveFurther": "bend or straighten the joint further away from the angles so far",
}


def guidance(name: str, is_hinge: bool) -> str:
    """What a person should do, in words."""
    general = GUIDANCE.get(name, name)
    return _GUIDANCE_OF_HINGE.get(name, general) if is_hinge else general


@dataclass(frozen=True)
class Message:
    """A message of the device: its name in the DBC, its fields (codes by name), when it was received (s)."""

    name: str
    fields: dict[str, Any] = field(repr=False)
    timestamp: float = 0.0
    data: bytes = field(default=b"", repr=False)

    def __getitem__(self, name: str) -> Any:
        return self.fields[name]

    def __str__(self) -> str:
        return f"{self.name} " + " ".join(f"{name}={_short(value)}" for name, value in self.fields.items())


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def decode(frame: can.Message) -> Message | None:
    """The device's message in a frame; None for every other frame, and for one that is damaged."""
    message = _SENT.get(frame.arbitration_id)
    if message is None or frame.is_extended_id or frame.is_remote_frame or frame.is_error_frame:
        return None
    if len(frame.data) != message.length:
        return None
    # cantools gives names as objects of its own; a plain text compares as one expects
    fields = {
        name: value if isinstance(value, (int, float)) else str(value)
        for name, value in message.decode(bytes(frame.data)).items()
    }
    return Message(message.name, fields, frame.timestamp, bytes(frame.data))


def encode_command(opcode: str, run: int, argument: int, nonce: int, boot_low: int = 0) -> can.Message:
    """The frame of a command."""
    fields = {"opcode": opcode, "boot_low": boot_low, "nonce": nonce, "for_run": run, "argument": argument}
    return can.Message(arbitration_id=COMMAND.frame_id, is_extended_id=False, data=COMMAND.encode(fields))
