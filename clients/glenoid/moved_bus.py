"""A bus whose board was given other identifiers (parameter base_id): seen as if it had those of the DBC."""

from __future__ import annotations

import copy
import time

import can

from .vocabulary import FIRST_ID, LAST_ID


class MovedBus:
    """`recv`, `send` and `shutdown` of a bus of python-can. Frames in the DBC's own block belong to others, and are left out."""

    def __init__(self, bus: can.BusABC, base_id: int) -> None:
        self.bus, self.by = bus, base_id - FIRST_ID

    def recv(self, timeout: float | None = None) -> can.Message | None:
        end = None if timeout is None else time.monotonic() + timeout
        while (frame := self.bus.recv(timeout)) is not None:
            ours = not frame.is_extended_id and FIRST_ID <= frame.arbitration_id - self.by <= LAST_ID
            others = not frame.is_extended_id and FIRST_ID <= frame.arbitration_id <= LAST_ID
            if ours:
                frame.arbitration_id -= self.by
            if ours or not others:
                return frame
            if end is not None:
                timeout = max(0.0, end - time.monotonic())
        return None

    def send(self, message: can.Message, timeout: float | None = None) -> None:
        moved = copy.copy(message)
        moved.arbitration_id += self.by
        self.bus.send(moved, timeout)

    def shutdown(self) -> None:
        self.bus.shutdown()
