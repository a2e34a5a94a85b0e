"""Listening without deciding: what the board says, and recordings."""

from __future__ import annotations

import time
from pathlib import Path

import can

from .calibration import Say
from .device import SILENCE_S, Device, DeviceError
from .moved_bus import MovedBus


def watch(device: Device, say: Say, *, every: bool = False, seconds: float | None = None) -> None:
    """Says each message; of heartbeats only those that bring something new, unless `every`."""
    end = None if seconds is None else time.monotonic() + seconds
    last: tuple[object, ...] | None = None
    silent = False
    while end is None or time.monotonic() < end:
        for message in device.listen(0.2):
            if message.name == "Heartbeat" and not every:
                new = tuple(message[k] for k in ("run_id", "state", "guidance", "poses", "reason", "live", "encoders"))
                if new == last:
                    continue
                last = new
            say(f"{time.strftime('%H:%M:%S')} {message}")
        if (device.silent_s > SILENCE_S) != silent:
            silent = not silent
            say("the board is silent" if silent else "the board is heard again")


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
