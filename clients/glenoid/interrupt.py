"""What becomes of a run when the client is interrupted."""

from __future__ import annotations

from .calibration import UNDER_WAY
from .device import Device, DeviceError

JOIN = "start python -m glenoid calibrate again to join it"


def after_interrupt(device: Device, joined: bool) -> str:
    """Aborts the run that this client started, or says that the run of another goes on. Returns what to tell."""
    heartbeat = device.heartbeat
    if heartbeat is None or heartbeat["state"] not in UNDER_WAY:
        return f"interrupted; no run is under way, the {device.joint} in use stays as it is"
    run = int(heartbeat["run_id"])
    if joined:
        return f"interrupted; run {run} was joined and goes on at the board: {JOIN}"
    try:
        answer = device.ask("Abort", run)
        if answer["code"] == "Fine":
            # the report that the run ended waits for its acknowledgement
            device.ask("Acknowledge", run)
            return f"run {run} is aborted; the {device.joint} in use stays as it is"
        return f"interrupted; the board did not abort run {run} ({answer['code']})"
    except DeviceError as error:
        return f"interrupted, and the board does not answer ({error}). Run {run} may go on: {JOIN}"
