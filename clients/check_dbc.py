#!/usr/bin/env python3
"""Reads glenoid.dbc as bus tools do: strictly, through canmatrix and back, and through SYM without loss.

    pip install cantools canmatrix
    clients/check_dbc.py
"""
import pathlib, sys, tempfile
import cantools
import canmatrix.formats

DBC = pathlib.Path(__file__).resolve().parent.parent / "glenoid.dbc"


def layout(database):
    """Every message and signal with all that a bus tool decodes by."""
    return {
        (message.frame_id, message.name, message.length): {
            signal.name: (
                signal.start, signal.length, signal.byte_order, signal.is_signed and not signal.is_float, signal.is_float, signal.scale,
                signal.offset, signal.unit or "", signal.multiplexer_ids and list(signal.multiplexer_ids),
                signal.choices and {int(k): str(v) for k, v in signal.choices.items()},
            )
            for signal in message.signals
        }
        for message in database.messages
    }


def as_in_sym(described, source):
    """SYM has no signal that is always there in a multiplexed message: it repeats it with every index."""
    return {
        message: {
            name: signal[:8] + ((None if source[message][name][8] is None else signal[8]),) + signal[9:]
            for name, signal in signals.items()
        }
        for message, signals in described.items()
    }


def same(what, one, other):
    if one != other:
        wrong = [key for key in one.keys() | other.keys() if one.get(key) != other.get(key)]
        sys.exit(f"check_dbc: {what}: {wrong[:3]} differ")
    print(f"{what}: {len(one)} messages, {sum(map(len, one.values()))} signals, all alike")


source = cantools.database.load_file(DBC, strict=True)
for message in source.messages:
    assert message.comment, message.name
    assert message.send_type, message.name
    for signal in message.signals:
        assert signal.comment, f"{message.name}.{signal.name}"
assert all(node.comment for node in source.nodes)
cycle = {message.name: message.cycle_time for message in source.messages if message.cycle_time}
assert {"Heartbeat": 100, "Identity": 100, "LiveSet": 100, "Telemetry": 20}.items() <= cycle.items(), cycle

# one layout and one table of values a name, wherever the signal stands
layouts = {}
for message in source.messages:
    for signal in message.signals:
        choices = signal.choices and tuple(sorted((int(k), str(v)) for k, v in signal.choices.items()))
        mine = (signal.length, signal.byte_order, signal.is_signed, signal.is_float, signal.scale, signal.unit, choices)
        assert layouts.setdefault(signal.name, mine) == mine, f"{message.name}.{signal.name} has two layouts"

with tempfile.TemporaryDirectory() as folder:
    there, back = f"{folder}/there.sym", f"{folder}/back.dbc"
    cantools.database.dump_file(source, there)
    in_sym = as_in_sym(layout(cantools.database.load_file(there, strict=True)), layout(source))
    same("DBC to SYM", layout(source), in_sym)
    matrix = canmatrix.formats.loadp_flat(str(DBC))
    canmatrix.formats.dumpp({"": matrix}, back)
    same("through canmatrix", layout(source), layout(cantools.database.load_file(back, strict=True)))
