"""One calibration from the client's side: joins or starts a run, follows it, asks for the decision.

The device owns every time limit. This side only listens, passes the decision on, and never calls a centre accepted that
the device did not.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .device import SILENCE_S, BoardSilent, Device, DeviceError
from .joint import Centre, Heard, Hinge, Joint
from .reasons import explained
from .shown import Shown
from .vocabulary import Message, guidance

#: States in which a run is under way.
UNDER_WAY = ("Collecting", "Identifying", "Verifying", "Review")
#: Reasons of a refused start that pass when the person holds still or the encoders come.
WAITING = ("ArmMoving", "EncoderSilent", "EncoderFrozen", "EncoderJumped", "CableLoose", "Busy")
#: Argument of Start: the shoulder blade is held first.
TWO_PHASES = 2
#: A device that is silent for so long is given up, s. Its run may go on.
GIVE_UP_S = 60.0

#: Longest wait for a report that the device begins at once, s: an emulated board on a busy machine stands still for seconds.
REPORT_S = 10.0

Say = Callable[[str], None]


@dataclass(frozen=True)
class Review:
    """What is to be decided: the new centre, or a hinge's new axis, beside the one in use."""

    run: int
    new: Joint
    live: Joint | None
    deviation_mm: float
    limit_mm: float

    @property
    def worst_sigma_mm(self) -> float:
        """The largest standard deviation of a coordinate, mm."""
        return self.new.worst_sigma_mm


@dataclass(frozen=True)
class Result:
    """How a run ended. `accepted` only if the device says that what it found is in use now: a centre, or a hinge."""

    run: int
    reason: str
    accepted: bool
    centre_mm: tuple[float, float, float] | None = None
    sigma_mm: tuple[float, float, float] | None = None
    poses: int = 0
    notes: list[str] = field(default_factory=list)
    hinge: Hinge | None = None
    #: What the reason is about, in words: a cable, a pose, a size, a direction.
    about: str = ""


#: Decides on a review: True accepts, False rejects, None leaves it open (asked again with every message).
Decide = Callable[[Review], "bool | None"]


def calibrate(
    device: Device, decide: Decide, *, say: Say = lambda text: None, anew: bool = False, two_phases: bool = False
) -> Result:
    """Runs one calibration, or joins the one under way (`anew` aborts that and starts another).

    With `two_phases` the shoulder blade is held in the first poses: the centre of a moving joint is then known better.

    `say` gets one line of text for everything that a person should know. Raises `DeviceError` when the device is gone;
    the run may then go on, and another call joins it.
    """
    return _Calibration(device, decide, say, two_phases).run(anew)


class _Calibration:
    def __init__(self, device: Device, decide: Decide, say: Say, two_phases: bool) -> None:
        self.device, self.decide, self.say = device, decide, say
        self.how = TWO_PHASES if two_phases else 0
        self.run_id = 0
        self.candidate, self.live = Heard("Candidate"), Heard("Live")
        self.shown = Shown()
        self.axis: Message | None = None
        self.verification: Message | None = None
        self.quality: Message | None = None
        self.notes: list[str] = []
        self.told = ""
        self.lost_since: float | None = None
        self.silence_told = 0.0
        self.decided = False

    def run(self, anew: bool) -> Result:
        self.run_id = self.begin(anew)
        # what was heard before belongs to the state, so it is asked for once more, whole
        self.device.ask("Query")
        while True:
            for message in self.device.listen(0.2):
                if (result := self.take(message)) is not None:
                    return result
            self.check_silence()
            if self.lost_since is not None and time.monotonic() - self.lost_since > 2.0:
                return self.lost()

    def begin(self, anew: bool) -> int:
        """Starts a run or joins one. Returns its number."""
        heartbeat = self.device.heartbeat
        assert heartbeat is not None, "the device was met"
        if heartbeat["state"] in UNDER_WAY and not anew:
            run = int(heartbeat["run_id"])
            self.say(f"run {run} is under way ({heartbeat['state']}, {heartbeat['poses']} poses): joined")
            return run
        if heartbeat["state"] in UNDER_WAY:
            self.say(f"aborting run {heartbeat['run_id']}")
            self.device.ask("Abort", int(heartbeat["run_id"]))
        while True:
            answer = self.device.ask("Start", argument=self.how)
            code = answer["code"]
            if code == "Fine":
                how = "bend the joint from angle to angle" if self.device.is_hinge else "move the arm from pose to pose"
                self.say(f"run {answer['run_id']} has begun: {how}, hold it still in each")
                return int(answer["run_id"])
            if code == "AcknowledgeFirst":
                self.acknowledge_leftover()
            elif code == "AlreadyRunning":
                run = int(answer["run_id"]) or self.run_under_way()
                self.say(f"run {run} was started by someone else: joined")
                return run
            elif code in WAITING:
                self.tell(f"cannot start yet: {explained(code)}")
                for _ in self.device.listen(0.3):
                    pass
                self.check_silence()
            else:
                raise DeviceError(f"the board refuses to start: {explained(code)}")

    def run_under_way(self) -> int:
        for message in self.device.listen(REPORT_S):
            if message.name == "Heartbeat" and message["state"] in UNDER_WAY:
                return int(message["run_id"])
        raise BoardSilent("the board says that a run is under way, but its heartbeat does not; try again")

    def acknowledge_leftover(self) -> None:
        heartbeat = self.device.heartbeat
        assert heartbeat is not None
        self.say(f"run {heartbeat['run_id']} before this one ended with {heartbeat['reason']}: acknowledged")
        self.device.ask("Acknowledge", int(heartbeat["run_id"]))

    def take(self, message: Message) -> Result | None:
        name = message.name
        self.shown.take(message)
        self.live.take(message)
        if name.startswith("Candidate") and message["run_id"] == self.run_id:
            self.candidate.take(message)
        if name == "Heartbeat":
            self.heartbeat(message)
        elif name == "Pose" and message["run_id"] == self.run_id:
            self.pose(message)
        elif name == "Axis" and message["run_id"] == self.run_id:
            self.axis = message
        elif name == "Verification" and message["run_id"] == self.run_id:
            self.verification = message
        elif name == "Quality" and message["run_id"] == self.run_id:
            self.quality = message
        elif name == "Fault" and message["active"]:
            cable = f" (cable {message['cable']})" if message["cable"] else ""
            self.tell(f"fault{cable}: {explained(message['code'])}")
            self.note(message["code"])
        elif name == "Versions":
            # it answers a Query, and comes by itself at power-up
            self.device.versions = message
        elif name == "Outcome" and message["run_id"] == self.run_id:
            return self.outcome(message)
        return None

    def heartbeat(self, message: Message) -> None:
        if self.silence_told:
            self.say("the board is heard again")
            self.silence_told = 0.0
        if message["run_id"] == self.run_id and message["state"] in (*UNDER_WAY, "Failed"):
            self.lost_since = None
            told = guidance(message["guidance"], self.device.is_hinge)
            if message["reason"] not in ("Fine", "AlreadyRunning"):
                told += f" ({explained(message['reason'])})"
            if told and message["state"] in ("Collecting", "Verifying"):
                self.tell(told)
        elif self.lost_since is None:
            # The run is not there any more. Its outcome may still be on the way.
            self.lost_since = time.monotonic()
            self.device.ask("Query")

    def pose(self, message: Message) -> None:
        number, held_out = message["index"] + 1, message["held_out"]
        if message["reason"] != "Fine":
            self.tell(f"pose not taken: {explained(message['reason'])}")
            return
        sigma = f", expected sigma {message['predicted_sigma']:.3f} mm" if message["predicted_sigma_known"] else ""
        self.say(f"pose {number} {'held out to verify' if held_out else 'taken'}{sigma}")

    def outcome(self, message: Message) -> Result | None:
        reason = message["reason"]
        if reason == "Fine":
            self.review()
            return None
        if reason == "Accepted" and message["live"]:
            if self.live.joint(self.run_id) is None:
                # the accepted values are part of the report; ask until they are whole
                self.device.ask("Query")
                for other in self.device.listen(REPORT_S):
                    self.live.take(other)
                    if self.live.joint(self.run_id) is not None:
                        break
        self.device.ask("Acknowledge", self.run_id)
        return self.result(reason, bool(message["live"]), int(message["poses"]), self.about(message))

    def about(self, outcome: Message) -> str:
        """What the reason of an outcome is about."""
        parts = [f"cable {outcome['cable']}"] if outcome["cable"] else []
        if outcome["pose_known"]:
            parts.append(f"pose {outcome['pose'] + 1}")
        if outcome["size_known"]:
            parts.append(f"{outcome['size']:.2f} mm")
        if self.axis is not None:
            direction = " ".join(f"{self.axis[f'axis_{name}']:.3f}" for name in "xyz")
            parts.append(f"direction {direction} in the {'forearm' if self.device.is_hinge else 'base'}")
        return ", ".join(parts)

    def review(self) -> None:
        if self.decided:
            return
        new = self.candidate.joint(self.run_id)
        named = self.shown.named(self.run_id)
        if new is None or self.verification is None or named is None:
            self.device.ask("Query")
            return
        verdict = self.decide(
            Review(self.run_id, new, self.live.joint(), self.verification["deviation"], self.verification["limit"])
        )
        if verdict is None:
            return
        self.decided = True
        boot, checksum = named
        answer = (
            self.device.ask("Accept", self.run_id, checksum, boot) if verdict
            else self.device.ask("Reject", self.run_id)
        )
        if answer["code"] != "Fine":
            self.decided = False
            self.tell(f"the board did not obey: {explained(answer['code'])}")

    def lost(self) -> Result:
        """The run is gone and its outcome was not heard: only what is in use now can tell how it ended."""
        self.live.clear()
        self.device.ask("Query")
        for message in self.device.listen(REPORT_S):
            self.live.take(message)
            if self.live.joint() is not None:
                break
            if message.name == "Heartbeat" and not message["live"]:
                # nothing is in use, so nothing will be reported
                break
            elif message.name == "Outcome" and message["run_id"] == self.run_id and message["reason"] != "Fine":
                return self.result(message["reason"], bool(message["live"]), int(message["poses"]))
        accepted = self.live.joint(self.run_id) is not None
        versions = self.device.versions
        cause = f" (its last start: {versions['reset_cause']})" if versions else ""
        if accepted:
            return self.result("Accepted", True, 0)
        self.say(f"run {self.run_id} is lost: the board was restarted{cause}; the {self.device.joint} in use is the old one")
        return self.result("Lost", False, 0)

    def result(self, reason: str, live: bool, poses: int, about: str = "") -> Result:
        accepted = reason == "Accepted" and live
        joint = self.live.joint(self.run_id) if accepted else None
        value_mm, sigma_mm = (joint.value_mm, joint.sigma_mm) if isinstance(joint, Centre) else (None, None)
        hinge = joint if isinstance(joint, Hinge) else None
        return Result(self.run_id, reason, accepted, value_mm, sigma_mm, poses, self.notes, hinge, about)

    def check_silence(self) -> None:
        silent_s = self.device.silent_s
        if silent_s > GIVE_UP_S:
            raise BoardSilent(
                f"the board has been silent for {silent_s:.0f} s. If it is on, its run goes on: start this again to "
                "join it."
            )
        if silent_s > SILENCE_S and silent_s - self.silence_told > 5.0:
            self.silence_told = silent_s
            self.say(f"the board has been silent for {silent_s:.0f} s: is it on, is the bus connected?")

    def tell(self, text: str) -> None:
        """Says what is not a repetition."""
        if text != self.told:
            self.told = text
            self.say(text)

    def note(self, code: Any) -> None:
        if code not in self.notes:
            self.notes.append(str(code))
