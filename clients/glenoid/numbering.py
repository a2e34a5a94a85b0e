"""The check of the cables' numbering: somebody pulls one cable after the other, the board looks which encoder moves.

A symmetric machine fits its lengths under a shifted or a mirrored numbering as well, with a centre that is somewhere else.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from .device import Device, DeviceError
from .reasons import explained

#: Where each cable runs: end-point of the platform, attachment point of the base.
RUNS = ("P1 to B1", "P1 to B2", "P2 to B2", "P2 to B3", "P3 to B3", "P3 to B1")
#: The same of a hinge, where each cable has ends of its own.
RUNS_OF_HINGE = tuple(f"base point {cable} to end {cable} on the forearm" for cable in range(1, 5))
#: So long somebody has for each cable, s; time between two looks.
PATIENCE_S, LOOK_S = 60.0, 0.3
#: What passes by itself: somebody moves the arm, or the encoders come.
_WAITING = ("CableNotPulled", "ArmMoving", "CableLoose", "EncoderSilent", "EncoderFrozen", "EncoderJumped")


def check_numbering(device: Device, say: Callable[[str], None]) -> bool:
    """Asks for every cable in turn; True when each moved its own encoder. Raises `DeviceError` when nobody pulls."""
    runs = RUNS_OF_HINGE[: device.cables] if device.is_hinge else RUNS
    for cable, run in enumerate(runs, 1):
        told = ""
        end = time.monotonic() + PATIENCE_S
        while (code := (answer := device.ask("CheckCable", argument=cable))["code"]) != "Fine":
            if code == "WrongCable":
                say(
                    f"cable {cable} was to be pulled, but encoder {answer['detail']} moved: is it labelled as in the rig's "
                    "drawing, and does it run over the drum of that number? Nothing is to be accepted until this is right."
                )
                return False
            if code not in _WAITING:
                raise DeviceError(f"the board does not look at cable {cable}: {explained(code)}")
            if time.monotonic() > end:
                raise DeviceError(f"cable {cable} was not pulled within {PATIENCE_S:.0f} s ({code})")
            # only now has the board noted where the cables are
            if code != told:
                say(
                    f"pull cable {cable} ({run}) by a finger's breadth, and let go; hold the arm and the other cables still"
                    if code == "CableNotPulled" else f"do not pull yet: {explained(code)}"
                )
            told = code
            for _ in device.listen(LOOK_S):
                pass
        say(f"cable {cable} is where it belongs")
    return True
