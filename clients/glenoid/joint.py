"""What a run finds: the centre of a ball, or the axis of a hinge, each number with its standard deviation."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .vocabulary import Message

Three = tuple[float, float, float]


@dataclass(frozen=True)
class Centre:
    """x, y, z in the base frame with their standard deviations, mm."""

    value_mm: Three
    sigma_mm: Three

    @property
    def worst_sigma_mm(self) -> float:
        """The largest standard deviation of a coordinate, mm."""
        return max(self.sigma_mm)


@dataclass(frozen=True)
class Axis:
    """A hinge's axis in one body: its direction, a unit vector, and the point of it next to the body's origin, mm."""

    direction: Three
    #: Of each component; the direction turns by so many radians.
    direction_sigma: Three
    point_mm: Three
    point_sigma_mm: Three

    @property
    def sigma_deg(self) -> float:
        """By how much the direction is uncertain in all, degrees."""
        return math.degrees(math.hypot(*self.direction_sigma))

    def __str__(self) -> str:
        direction = " ".join(f"{value:.5f}" for value in self.direction)
        point = " ".join(f"{value:.3f}" for value in self.point_mm)
        return f"{direction} through {point} mm"


@dataclass(frozen=True)
class Hinge:
    """The axis in the base, and in the frame of the cables' ends on the forearm."""

    base: Axis
    forearm: Axis
    #: How far the forearm's point of the axis stands from the base's, along the axis, mm.
    along_mm: float
    along_sigma_mm: float

    @property
    def worst_sigma_mm(self) -> float:
        """The largest standard deviation of a coordinate of the axis' place, mm."""
        return max(*self.base.point_sigma_mm, *self.forearm.point_sigma_mm, self.along_sigma_mm)

    def __str__(self) -> str:
        return f"axis {self.base}, in the forearm {self.forearm}"


Joint = Centre | Hinge


class Heard:
    """Collects the frames of a joint as they come: "Candidate" is what waits for a decision, "Live" what is in use."""

    def __init__(self, which: str) -> None:
        self._which = which
        self._frames: dict[tuple[str, object], Message] = {}

    def clear(self) -> None:
        """Forgets what was heard."""
        self._frames.clear()

    def take(self, message: Message) -> None:
        """Keeps what belongs to the joint."""
        if not message.name.startswith(self._which):
            return
        kind = message.name.removeprefix(self._which)
        if kind == "Centre":
            self._frames[kind, message["axis"]] = message
        elif kind in ("HingeAxis", "HingePlace"):
            self._frames[kind, int(message["hinge_index"])] = message

    def joint(self, run: int | None = None) -> Joint | None:
        """The joint, if all of it was heard: of this run, or all of one run."""
        return self._centre(run) or self._hinge(run)

    def _centre(self, run: int | None) -> Centre | None:
        three = self._whole([("Centre", axis) for axis in "xyz"], run)
        return None if three is None else Centre(_three(three, "value"), _three(three, "sigma"))

    def _hinge(self, run: int | None) -> Hinge | None:
        axes = self._whole([("HingeAxis", k) for k in range(6)], run)
        places = self._whole([("HingePlace", k) for k in range(7)], run)
        if axes is None or places is None or axes[0]["run_id"] != places[0]["run_id"]:
            return None
        base, forearm = (
            Axis(
                _three(axes[k : k + 3], "direction"), _three(axes[k : k + 3], "direction_sigma"),
                _three(places[k : k + 3], "place"), _three(places[k : k + 3], "place_sigma"),
            )
            for k in (0, 3)
        )
        return Hinge(base, forearm, places[6]["place"], places[6]["place_sigma"])

    def _whole(self, keys: list[tuple[str, object]], run: int | None) -> list[Message] | None:
        frames = [self._frames[key] for key in keys if key in self._frames]
        wanted = run if run is not None or not frames else frames[0]["run_id"]
        is_whole = len(frames) == len(keys) and all(frame["run_id"] == wanted for frame in frames)
        return frames if is_whole else None


def _three(frames: list[Message], field: str) -> Three:
    x, y, z = (frame[field] for frame in frames)
    return x, y, z
