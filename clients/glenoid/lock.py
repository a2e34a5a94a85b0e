"""The parameters' lock: the answer to the board's challenge, for whoever has the key.

SipHash-2-4 (Aumasson and Bernstein, 2012) over the challenge's four bytes; the lowest 32 bits of it open the lock.
"""

from __future__ import annotations

import re
from pathlib import Path

from .device import DeviceError
from .parameters import Parameters

KEY_BYTES = 16
_MASK = 2**64 - 1


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


def unlock(parameters: Parameters, key: bytes) -> None:
    """Opens the lock for ten minutes. Raises `DeviceError` for the wrong key, and within a second of another attempt."""
    challenge = parameters.ask("Challenge")
    parameters.ask("Unlock", value=(siphash_2_4(key, challenge) & 0xFFFF_FFFF).to_bytes(4, "little"))


def set_key(parameters: Parameters, key: bytes) -> None:
    """Prepares another key; `save` makes it hold. All zero: no lock."""
    for word in range(4):
        parameters.set(f"lock_key_{word + 1}", int.from_bytes(key[4 * word : 4 * word + 4], "little"))


def siphash_2_4(key: bytes, data: bytes) -> int:
    """SipHash-2-4 of some bytes under a key of sixteen."""
    k0, k1 = (int.from_bytes(key[half : half + 8], "little") for half in (0, 8))
    v = [k0 ^ 0x736F6D6570736575, k1 ^ 0x646F72616E646F6D, k0 ^ 0x6C7967656E657261, k1 ^ 0x7465646279746573]
    padded = data + bytes(-(len(data) + 1) % 8) + bytes([len(data) & 0xFF])
    for start in range(0, len(padded), 8):
        word = int.from_bytes(padded[start : start + 8], "little")
        v[3] ^= word
        _rounds(v, 2)
        v[0] ^= word
    v[2] ^= 0xFF
    _rounds(v, 4)
    return v[0] ^ v[1] ^ v[2] ^ v[3]


def _rounds(v: list[int], count: int) -> None:
    for _ in range(count):
        _half_round(v, 0, 1, 13, 32)
        _half_round(v, 2, 3, 16, 0)
        _half_round(v, 0, 3, 21, 0)
        _half_round(v, 2, 1, 17, 32)


def _half_round(v: list[int], a: int, b: int, turn: int, turn_sum: int) -> None:
    v[a] = (v[a] + v[b]) & _MASK
    v[b] = _turned(v[b], turn) ^ v[a]
    v[a] = _turned(v[a], turn_sum)


def _turned(word: int, bits: int) -> int:
    return (word << bits | word >> (64 - bits)) & _MASK
