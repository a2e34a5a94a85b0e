"""A rig's file (RIG.toml, as `cargo identify` reads it) as parameters of the board."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from .device import DeviceError

#: Sections and keys that say nothing about parameters: the covariance is for `cargo identify`, the truth for tests.
_PASSED_OVER = ("covariance", "truth")


def parameters_of(path: str | Path) -> dict[str, float]:
    """The parameters that a rig's file sets, by name. What the file does not say is not among them.

    `[start]` is where the joint is expected: it sets the nominal centre and radii, and what is plausible about them.
    Raises `DeviceError` for a file that is no rig.
    """
    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise DeviceError(f"{path}: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DeviceError(f"{path}: no TOML file ({error})") from error
    if content.get("joint") == "hinge":
        return _elbow(path, content)
    found: dict[str, float] = {}
    for name, value in content.items():
        if name in _PASSED_OVER:
            continue
        if name not in _READERS:
            raise DeviceError(f"{path}: unknown key {name!r}; a rig's file may hold {', '.join(_READERS)}")
        try:
            found |= _READERS[name](value)
        except (TypeError, ValueError, KeyError, AttributeError) as error:
            raise DeviceError(f"{path}: {name}: {error}") from error
    if not any(name in content for name in ("base", "cable")):
        raise DeviceError(f"{path}: neither base and edges nor six [[cable]] tables: no rig")
    return found


def _numbers(value: Any, count: int) -> list[float]:
    if not isinstance(value, list) or len(value) != count or not all(isinstance(n, int | float) for n in value):
        raise ValueError(f"{count} numbers are wanted")
    return [float(number) for number in value]


def _named(names: Sequence[str], value: Any) -> dict[str, float]:
    return dict(zip(names, _numbers(value, len(names)), strict=True))


def _six(name: str) -> list[str]:
    return [f"{name}_{number}" for number in range(1, 7)]


def _base(value: Any) -> dict[str, float]:
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError("three points [x, y, z] are wanted")
    found = {"geometry": 0.0}
    for number, point in enumerate(value, 1):
        found |= _named([f"base_{number}_{axis}" for axis in "xyz"], point)
    return found


def _edges(value: Any) -> dict[str, float]:
    return _named(["edge_12", "edge_23", "edge_31"], value)


def _cables(value: Any) -> dict[str, float]:
    if not isinstance(value, list) or len(value) != 6:
        raise ValueError("six [[cable]] tables are wanted")
    return {"geometry": 1.0} | _ends(value)


def _ends(value: Sequence[Any]) -> dict[str, float]:
    found: dict[str, float] = {}
    for number, cable in enumerate(value, 1):
        for key in ("base", "end"):
            found |= _named([f"cable_{number}_{key}_{axis}" for axis in "xyz"], cable[key])
        axis = _numbers(cable.get("pulley_axis", [0, 0, 1]), 3)
        length = math.hypot(*axis)
        if not length > 0:
            raise ValueError(f"pulley_axis of cable {number} has no length")
        found[f"cable_{number}_pulley_radius"] = float(cable.get("pulley_radius", 0))
        found |= _named([f"cable_{number}_pulley_axis_{name}" for name in "xyz"], [part / length for part in axis])
    return found


def _hinge_cables(value: Any) -> dict[str, float]:
    if not isinstance(value, list) or not 2 <= len(value) <= 4:
        raise ValueError("two to four [[cable]] tables are wanted about a hinge")
    return {"geometry": 2.0, "hinge_cables": float(len(value))} | _ends(value)


def _hinge(value: Any) -> dict[str, float]:
    """The drawing of a hinge: its axis in either body, and how well it is known."""
    found: dict[str, float] = {"hinge_drawing": 1.0}
    for key, name in (("axis", "hinge_axis"), ("axis_in_platform", "hinge_end_axis")):
        axis = _numbers(value[key], 3)
        length = math.hypot(*axis)
        if not length > 0:
            raise ValueError(f"{key} has no length")
        found |= _named([f"{name}_{axis_name}" for axis_name in "xyz"], [part / length for part in axis])
    for key, name in (("point", "hinge_point"), ("point_in_platform", "hinge_end_point")):
        found |= _named([f"{name}_{axis_name}" for axis_name in "xyz"], value[key])
    if "range_deg" in value:
        lowest, highest = _numbers(value["range_deg"], 2)
        found |= {"hinge_lowest": math.radians(lowest), "hinge_highest": math.radians(highest)}
    if ("sigma_deg" in value) != ("sigma_mm" in value):
        raise ValueError("sigma_deg and sigma_mm belong together")
    if "sigma_deg" in value:
        turn, place = float(value["sigma_deg"]), float(value["sigma_mm"])
        found |= {
            "hinge_drawing": 2.0,
            "hinge_sigma_axis": math.radians(turn),
            "hinge_sigma_point": place,
            "hinge_sigma_end_axis": math.radians(float(value.get("sigma_in_platform_deg", turn))),
            "hinge_sigma_end_point": float(value.get("sigma_in_platform_mm", place)),
            "hinge_sigma_along": float(value.get("sigma_along_mm", place)),
        }
    return found


def _elbow(path: str | Path, content: dict[str, Any]) -> dict[str, float]:
    """The parameters of an elbow's rig. What is not stated of its machine is known exactly, as `cargo identify` takes it."""
    found = {f"tolerance_{name}": 0.0 for name in ("base", "edges", "offset", "drum")}
    for name, value in content.items():
        if name == "joint" or name in _PASSED_OVER:
            continue
        if name not in _ELBOW_READERS:
            raise DeviceError(f"{path}: unknown key {name!r}; an elbow's file may hold {', '.join(_ELBOW_READERS)}")
        try:
            found |= _ELBOW_READERS[name](value)
        except (TypeError, ValueError, KeyError, AttributeError) as error:
            raise DeviceError(f"{path}: {name}: {error}") from error
    if "cable" not in content:
        raise DeviceError(f"{path}: no [[cable]] tables: no rig")
    return found


def _elbow_home(value: Any) -> dict[str, float]:
    if not isinstance(value, list) or not 2 <= len(value) <= 4:
        raise ValueError("as many lengths as cables are wanted")
    return _named([f"home_{number}" for number in range(1, len(value) + 1)], value)


def _tolerance(value: Any) -> dict[str, float]:
    names = {"base": "tolerance_base", "edges": "tolerance_edges", "zero": "tolerance_offset", "drum": "tolerance_drum"}
    return {names[key]: float(number) for key, number in value.items()}


def _noise(value: Any) -> dict[str, float]:
    # `samples` says of how many samples a row of a log is the mean: a board counts for itself
    return {"length_noise": float(value["pose"]), "sample_noise": float(value.get("sample", 0))}


def _start(value: Any) -> dict[str, float]:
    names = ["nominal_x", "nominal_y", "nominal_z", *(f"nominal_radius_{number}" for number in (1, 2, 3))]
    found = _named(names, value["values"])
    radii = [found[name] for name in names[3:]]
    # as the firmware judges a rig that is compiled in: within one radius, a third to three times
    plausible = {
        "plausible_centre": max(radii),
        "plausible_min_radius": min(radii) / 3,
        "plausible_max_radius": max(radii) * 3,
    }
    return found | plausible


_READERS: dict[str, Callable[[Any], dict[str, float]]] = {
    "base": _base,
    "edges": _edges,
    "cable": _cables,
    "home": lambda value: _named(_six("home"), value),
    "noise": _noise,
    "tolerance": _tolerance,
    "zeros": lambda value: _named(_six("offset"), value["mm"]),
    "drum": lambda value: _named(_six("scale"), value["scale"]),
    "start": _start,
}

_ELBOW_READERS: dict[str, Callable[[Any], dict[str, float]]] = {
    "cable": _hinge_cables,
    "home": _elbow_home,
    "tolerance": _tolerance,
    "hinge": _hinge,
}
