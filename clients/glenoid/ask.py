"""Asks the person at the terminal whether to accept, without ceasing to listen to the board."""

from __future__ import annotations

import queue
import sys
import threading

from .calibration import Review, Say
from .joint import Axis, Centre, Hinge, Joint


class Asker:
    """Shows a review once, then reads an answer in the background."""

    def __init__(self, always: bool, say: Say) -> None:
        self.always, self.say = always, say
        self.shown: Review | None = None
        #: A question stands. Once it is answered, to be asked for a verdict again means that the board did not obey.
        self.asked = False
        self.answers: queue.Queue[str | None] = queue.Queue()

    def decide(self, review: Review) -> bool | None:
        """True to accept, False to reject, None as long as nobody has answered."""
        if self.shown is None or self.shown.run != review.run:
            self.shown, self.asked = review, False
            self.say(table(review))
            if not self.always:
                threading.Thread(target=self.read, daemon=True).start()
        if self.always:
            return True
        if not self.asked:
            self.question()
        try:
            answer = self.answers.get_nowait()
        except queue.Empty:
            return None
        if answer is None:
            self.say("nobody answers here: decide with the button, or start this again (with --yes to accept)")
            return None
        self.asked = False
        if answer.strip().lower() in ("y", "yes"):
            return True
        if answer.strip().lower() in ("n", "no"):
            return False
        self.question()
        return None

    def question(self) -> None:
        self.asked = True
        joint = "axis" if self.shown is not None and isinstance(self.shown.new, Hinge) else "centre"
        self.say(f"Accept this {joint}? Type y or n and press Enter.")

    def read(self) -> None:
        for line in sys.stdin:
            self.answers.put(line)
        self.answers.put(None)


def table(review: Review) -> str:
    """What was found beside what is in use, number by number."""
    new, old = _rows(review.new), _rows(review.live)
    joint = "axis" if isinstance(review.new, Hinge) else "centre"
    width = max(len(value) for value in new.values())
    label = max(len(name) for name in new)
    lines = [f"run {review.run} is complete:", f"  {'':{label}}  {f'new {joint}':>{width}}   {'in use':>{width}}"]
    lines += [f"  {name:{label}}  {value:>{width}}   {old.get(name, 'none'):>{width}}" for name, value in new.items()]
    if isinstance(review.new, Hinge):
        base, forearm = review.new.base.sigma_deg, review.new.forearm.sigma_deg
        lines.append(f"  the direction is known to {base:.2f} degrees in the base, to {forearm:.2f} degrees in the forearm (1 sigma)")
    lines.append(f"  deviation of the second set {review.deviation_mm:.3f} mm, limit {review.limit_mm:.3f} mm")
    return "\n".join(lines)


def _rows(joint: Joint | None) -> dict[str, str]:
    """The numbers of a joint with their standard deviations and units."""
    if isinstance(joint, Centre):
        return {axis: f"{joint.value_mm[k]:9.3f} +- {joint.sigma_mm[k]:.3f} mm" for k, axis in enumerate("xyz")}
    if isinstance(joint, Hinge):
        along = {"along the axis": f"{joint.along_mm:.3f} +- {joint.along_sigma_mm:.3f} mm"}
        return _axis_rows("in the base", joint.base) | _axis_rows("in the forearm", joint.forearm) | along
    return {}


def _axis_rows(body: str, axis: Axis) -> dict[str, str]:
    """A direction has no unit; its standard deviation is an angle in rad."""
    rows = {
        f"direction {body} {name}": f"{axis.direction[k]:.5f} +- {axis.direction_sigma[k]:.5f}" + " " * 3
        for k, name in enumerate("xyz")
    }
    return rows | {
        f"point {body} {name}": f"{axis.point_mm[k]:.3f} +- {axis.point_sigma_mm[k]:.3f} mm" for k, name in enumerate("xyz")
    }
