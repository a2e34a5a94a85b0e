"""Listening without deciding: what the board says, and recordings."""

from __future__ import annotations

import math
import time
from pathlib import Path

import can

from .calibration import Say
from .device import SILENCE_S, Device, DeviceError
from .moved_bus import MovedBus
from .vocabulary import Message

#: An angle is said again when it differs by so much from the one that was said last, degrees.
NEW_ANGLE_DEG = 1.0


def watch(device: Device, say: Say, *, every: bool = False, seconds: float | None = None) -> None:
    """Says each message; of heartbeats and angles only those that bring something new, unless `every`."""
    end = None if seconds is None else time.monotonic() + seconds
    last: tuple[object, ...] | None = None
    angle_deg: float | None = None
    silent = False
    while end is None or time.monotonic() < end:
        for message in device.listen(0.2):
            if message.name == "Heartbeat" and not every:
                new = tuple(message[k] for k in ("run_id", "state", "guidance", "poses", "reason", "live", "encoders"))
                if new == last:
                    continue
                last = new
            if message.name == "HingeAngle" and not every:
                new_deg = math.degrees(message["angle"])
                if angle_deg is not None and abs(new_deg - angle_deg) < NEW_ANGLE_DEG:
                    continue
                angle_deg = new_deg
            text = angle_text(message) if message.name == "HingeAngle" else str(message)
            say(f"{time.strftime('%H:%M:%S')} {text}")
        if (device.silent_s > SILENCE_S) != silent:
            silent = not silent
            say("the board is silent" if silent else "the board is heard again")


def angle_text(message: Message) -> str:
    """How far a hinge bends, in words."""
    return (
        f"HingeAngle {math.degrees(message['angle']):.1f} degrees, which leaves {message['angle_residual']:.3f} mm of the lengths"
        f" (run {message['run_id']})"
    )


def record(bus: can.BusABC | MovedBus, path: str | Path, seconds: float | None = None) -> int:
    """Writes every frame of the bus into a file until Ctrl-C or for so long. Returns how many."""
    if Path(path).exists():
        raise DeviceError(f"{path} is there already; it is not overwritten")
    try:
        logger = can.Logger(str(path))
    except OSError as error:
        raise DeviceError(f"{path} cannot be written: {error}") from error
    except ValueError as error:
        raise DeviceError(f"{path}: {error}; take a name that ends in .log, .asc, .blf, .trc or .csv") from error
    frames, end = 0, None if seconds is None else time.monotonic() + seconds
    try:
        while end is None or time.monotonic() < end:
            try:
                frame = bus.recv(0.2)
            except Exception as error:  # each interface of python-can has errors of its own
                raise DeviceError(f"the bus is gone ({error}); {frames} frames are in {path}") from error
            if frame is not None:
                logger(frame)
                frames += 1
    except KeyboardInterrupt:
        pass
    finally:
        logger.stop()
    return frames
