"""What a new centre, or a hinge's new axis, was shown as: an accept names it by a checksum, so nothing can be accepted that was not shown."""

from __future__ import annotations

import binascii

from .vocabulary import Message

#: The twelve frames of a ball, then the eight of its motion; then the thirteen of a hinge.
_MOTION, _HINGE, _END = 12, 20, 33
_PLACES = {"CandidateCentre": ("axis", ("x", "y", "z")), "CandidateRadius": ("end_point", ("p1", "p2", "p3"))}


class Shown:
    """The frames of a new centre as they were received: x, y, z, p1, p2, p3, offsets of L1 to L6, and of a centre that
    moves the eight parts of its motion. Of a hinge: axis and place in the base, then in the forearm, then what is left."""

    def __init__(self) -> None:
        self._frames: dict[int, Message] = {}
        self._naming: Message | None = None

    def take(self, message: Message) -> None:
        """Keeps what belongs to a new centre."""
        if message.name in _PLACES:
            field, names = _PLACES[message.name]
            self._frames[names.index(message[field]) + 3 * (message.name == "CandidateRadius")] = message
        elif message.name == "CandidateZero":
            self._frames[5 + message["cable"]] = message
        elif message.name == "CandidateMotion":
            self._frames[_MOTION + int(message["part"])] = message
        elif message.name in ("CandidateHingeAxis", "CandidateHingePlace"):
            body, component = divmod(int(message["hinge_index"]), 3)
            place = 3 if message.name == "CandidateHingePlace" and body < 2 else 0
            self._frames[_HINGE + 6 * body + place + component] = message
        elif message.name == "CandidateNaming":
            self._naming = message

    def named(self, run: int) -> tuple[int, int] | None:
        """Boot and checksum of this run's centre; None unless all of it was received."""
        heard = [k for k in range(_MOTION, _END) if k in self._frames and self._frames[k]["run_id"] == run]
        is_hinge = any(k >= _HINGE for k in heard)
        wanted = range(_HINGE, _END) if is_hinge else [*range(_MOTION), *heard]
        naming, frames = self._naming, [self._frames.get(k) for k in wanted]
        if naming is None or naming["run_id"] != run:
            return None
        if any(frame is None or frame["run_id"] != run for frame in frames):
            return None
        boot, wearer = int(naming["boot"]), int(naming["wearer"])
        data = boot.to_bytes(2, "little") + wearer.to_bytes(2, "little")
        # CRC-16/IBM-3740
        return boot, binascii.crc_hqx(data + b"".join(frame.data for frame in frames if frame), 0xFFFF)
