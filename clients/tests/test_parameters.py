"""Parameters: what the DBC describes, and the board's own table."""

from __future__ import annotations

import pytest
from conftest import Board

import glenoid
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
