"""Asks the person at the terminal whether to accept, without ceasing to listen to the board."""

from __future__ import annotations

import queue
import sys
import threading

from .calibration import Review, Say


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
        self.say("Accept this centre? Type y or n and press Enter.")

    def read(self) -> None:
        for line in sys.stdin:
            self.answers.put(line)
        self.answers.put(None)


def table(review: Review) -> str:
    """The new centre beside the one in use."""
    lines = [f"run {review.run} is complete:", "          new centre               in use"]
    for k, axis in enumerate("xyz"):
        new = f"{review.new.value_mm[k]:9.3f} +- {review.new.sigma_mm[k]:.3f} mm"
        old = "none"
        if review.live is not None:
            old = f"{review.live.value_mm[k]:9.3f} +- {review.live.sigma_mm[k]:.3f} mm"
        lines.append(f"  {axis}  {new:>24}   {old:>24}")
    lines.append(f"  deviation of the second set {review.deviation_mm:.3f} mm, limit {review.limit_mm:.3f} mm")
    return "\n".join(lines)
