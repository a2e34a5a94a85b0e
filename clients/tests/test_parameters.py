"""Parameters: what the DBC describes, and the board's own table."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from conftest import Board

import glenoid
from glenoid.__main__ import main
from glenoid.lock import answer
from glenoid.parameters import described


def test_the_dbc_describes_each_parameter_once_with_unit_and_sentence() -> None:
    known = described()
    assert len(known) > 100
    assert len({parameter.index for parameter in known.values()}) == len(known)
    base = known["base_1_x"]
    assert (base.unit, base.is_float) == ("mm", True) and base.comment
    # an IEEE single, little-endian, and an unsigned integer
    assert base.pack(150.0) == bytes.fromhex("00001643") and base.unpack(bytes.fromhex("00001643")) == 150.0
    assert known["geometry"].pack(1) == bytes([1, 0, 0, 0])


def test_what_cannot_be_sent_or_is_not_known_says_so() -> None:
    with pytest.raises(glenoid.DeviceError, match="geometry: -1 cannot be sent"):
        described()["geometry"].pack(-1)
    with pytest.raises(glenoid.DeviceError, match="no parameter is called 'base_9_x'; is one of these meant: base_1_x"):
        glenoid.Parameters(None).named("base_9_x")  # type: ignore[arg-type]


def test_the_board_reads_refuses_prepares_and_forgets(board: Board) -> None:
    with glenoid.open_device("slcan", board.channel) as device:
        parameters = glenoid.Parameters(device)
        before = parameters.get("base_1_x")
        assert before == parameters.get("base_1_x", "ReadDefault") == 150.0
        parameters.set("base_1_x", 151.5)
        assert (parameters.get("base_1_x"), parameters.get("base_1_x", "ReadPrepared")) == (150.0, 151.5)
        parameters.discard()
        assert parameters.get("base_1_x", "ReadPrepared") == 150.0
        with pytest.raises(glenoid.DeviceError, match="Write base_1_x was refused"):
            parameters.set("base_1_x", 1e6)


def test_the_answer_to_a_challenge_is_siphash() -> None:
    """The test vectors of its authors (Aumasson and Bernstein 2012, appendix A, and vectors_sip64 of their code)."""
    key = bytes(range(16))
    assert answer(key, bytes(range(15))) == (0xA129CA6149BE45E5).to_bytes(8, "little")[:4]
    assert answer(key, b"").hex() == "310e0edd"
    assert answer(key, bytes(range(8))).hex() == "6224939a"


def test_a_key_locks_and_opens(board: Board, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def run(*words: str) -> int:
        return main(["parameters", "-c", board.channel, *words])

    key, other = tmp_path / "key", tmp_path / "other"
    key.write_text("00112233 44556677 8899aabb ccddeeff\n")
    other.write_text("01112233 44556677 8899aabb ccddeeff\n")
    assert (run("key", str(key)), run("save")) == (0, 0)
    assert run("set", "base_1_x", "151") == 1 and "Locked" in capsys.readouterr().err
    assert run("unlock", str(other)) == 1 and "WrongKey" in capsys.readouterr().err
    # attempts are a second apart
    time.sleep(1.1)
    assert run("unlock", str(key)) == 0
    assert run("set", "base_1_x", "151") == 0
    assert run("lock") == 0
    assert run("set", "base_1_x", "152") == 1 and "Locked" in capsys.readouterr().err


@pytest.mark.parametrize(("content", "told"), [("0011", "32 hexadecimal digits, not 4"), ("key", "no key"), (None, "No such file")])
def test_a_file_that_is_no_key_says_so(tmp_path: Path, content: str | None, told: str) -> None:
    path = tmp_path / "key"
    if content is not None:
        path.write_text(content)
    with pytest.raises(glenoid.DeviceError, match=told):
        glenoid.read_key(path)


def test_a_board_with_other_identifiers_is_found_under_them(board: Board) -> None:
    with glenoid.open_device("slcan", board.channel) as device:
        parameters = glenoid.Parameters(device)
        parameters.set("base_id", 0x600)
        parameters.save()
    with pytest.raises(glenoid.BoardSilent):
        glenoid.open_device("slcan", board.channel)
    with glenoid.open_device("slcan", board.channel, base_id=0x600) as device:
        parameters = glenoid.Parameters(device)
        assert parameters.get("base_id") == 0x600
        assert device.ask("Query")["code"] == "Fine"
    for base_id in (0x601, 0x7E0, -64):
        with pytest.raises(glenoid.DeviceError, match="is no base identifier"):
            glenoid.open_device("slcan", board.channel, base_id=base_id)
