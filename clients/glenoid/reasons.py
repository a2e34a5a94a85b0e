"""What a reason code means and what to do about it, in words: the table of docs/reasons.md."""

from __future__ import annotations

import re
from pathlib import Path

_ROW = re.compile(r"^\| \d+ \| `(\w+)` \| (.*?) \| (.*?) \|$", re.M)

#: Name of the code: what happened, what to do.
REASONS: dict[str, tuple[str, str]] = {
    name: (what, remedy)
    for name, what, remedy in _ROW.findall(Path(__file__).with_name("reasons.md").read_text(encoding="utf-8"))
}

#: Remedies that say nothing.
_NONE = "none"


def explained(code: str) -> str:
    """The code's name with what happened and what to do; one that is not in the table by its name alone."""
    if code not in REASONS:
        return code
    what, remedy = REASONS[code]
    return f"{code}: {what}" if remedy == _NONE else f"{code}: {what}. What to do: {remedy}"
