"""`python -m glenoid numbering`: every cable is pulled and found at its own encoder, before the first accept."""

from __future__ import annotations

from conftest import Board, Client

import glenoid


def require_the_check(board: Board) -> None:
    with glenoid.open_device("slcan", board.channel) as device:
        parameters = glenoid.Parameters(device)
        parameters.set("numbering_check", 1)
        parameters.save()


def pull_all(board: Board) -> Client:
    """The check, with every cable pulled when it is asked for."""
    numbering = Client(board, command="numbering")
    for cable in range(1, 7):
        numbering.wait_for(f"pull cable {cable} ")
        board.order(f"pull {cable}")
        # it is let go before the next one is pulled
        numbering.wait_for(f"cable {cable} is where it belongs")
    return numbering


def test_the_first_accept_waits_for_the_check(board: Board) -> None:
    require_the_check(board)
    client = Client(board, answers=True)
    client.wait_for("Accept this centre?")
    client.answer("y")
    client.wait_for("the board did not obey: NumberingUnchecked: nobody has seen yet")
    numbering = pull_all(board)
    assert numbering.end() == 0, numbering.said
    # what was not obeyed is asked again, not done by itself
    assert client.said.count("Accept this centre?") == 2 and client.process.poll() is None
    client.answer("y")
    assert client.end() == 0, client.said


def test_a_client_that_needs_no_answer_accepts_once_the_cables_were_pulled(board: Board) -> None:
    require_the_check(board)
    client = Client(board, "--yes")
    client.wait_for("NumberingUnchecked")
    numbering = pull_all(board)
    assert (numbering.end(), client.end()) == (0, 0), numbering.said + client.said


def test_another_cable_than_the_named_one_is_named(board: Board) -> None:
    numbering = Client(board, command="numbering")
    numbering.wait_for("pull cable 1 (P1 to B1)")
    board.order("pull 5")
    assert numbering.end() == 2, numbering.said
    assert "cable 1 was to be pulled, but encoder 5 moved" in numbering.said
