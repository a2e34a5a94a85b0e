"""The parameters' lock: the answer to the board's challenge, for whoever has the key.

SipHash-2-4 (Aumasson and Bernstein, 2012) over the challenge's four bytes; the lowest 32 bits of it open the lock.
"""

from __future__ import annotations

import re
from pathlib import Path

from siphash24 import siphash24

from .device import DeviceError
from .parameters import Parameters

KEY_BYTES = 16


def read_key(path: str | Path) -> bytes:
    """The key in a file: 32 hexadecimal digits, lock_key_1 first, each word's lowest byte first; blanks do not count."""
    try:
        digits = re.sub(r"\s", "", Path(path).read_text(encoding="ascii"))
        key = bytes.fromhex(digits)
    except OSError as error:
        raise DeviceError(f"{path}: {error.strerror}") from error
    except (UnicodeDecodeError, ValueError) as error:
        raise DeviceError(f"{path}: no key: {KEY_BYTES * 2} hexadecimal digits are wanted") from error
    if len(key) != KEY_BYTES:
        raise DeviceError(f"{path}: a key has {KEY_BYTES * 2} hexadecimal digits, not {len(digits)}")
    return key


def answer(key: bytes, challenge: bytes) -> bytes:
    """What opens the lock: the first four bytes of the challenge's digest."""
    return bytes(siphash24(challenge, key=key).digest()[:4])


def unlock(parameters: Parameters, key: bytes) -> None:
    """Opens the lock for ten minutes. Raises `DeviceError` for the wrong key, and within a second of another attempt."""
    challenge = parameters.ask("Challenge")
    parameters.ask("Unlock", value=answer(key, challenge))


def set_key(parameters: Parameters, key: bytes) -> None:
    """Prepares another key; `save` makes it hold. All zero: no lock."""
    for word in range(4):
        parameters.set(f"lock_key_{word + 1}", int.from_bytes(key[4 * word : 4 * word + 4], "little"))
