"""python -m glenoid: the device from a terminal.

Exit status of `calibrate`: 0 only when the board says that the new centre is in use; 2 when the run ended otherwise;
1 when the board could not be talked to or the command line is wrong; 130 after Ctrl-C.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from . import __doc__ as package_doc
from .ask import Asker
from .calibration import calibrate
from .device import Device, DeviceError, open_device
from .interrupt import after_interrupt
from .lock import read_key, set_key, unlock
from .numbering import check_numbering
from .parameters import Parameters, Refused
from .recording import gaps, read_poses, read_runs, write_csv
from .reasons import explained
from .rig import parameters_of
from .vocabulary import FIRST_ID, Message, encode_command
from .watching import angle_text, record, watch

ACCEPTED, TROUBLE, NOT_ACCEPTED, INTERRUPTED = 0, 1, 2, 130
#: Longest wait for the angle of a hinge that was just accepted, s: a board may send no telemetry.
ANGLE_S = 2.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command; returns its exit status."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.run(options))
    except DeviceError as error:
        print(f"glenoid: {error}", file=sys.stderr)
        return TROUBLE
    except BrokenPipeError:
        return TROUBLE
    except OSError as error:
        # a file that cannot be written, a folder that is not there
        print(f"glenoid: {error}", file=sys.stderr)
        return TROUBLE
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED


class _Parser(argparse.ArgumentParser):
    """Ends with 1: 2 is the exit status of a run that ended without an accepted centre."""

    def error(self, message: str) -> NoReturn:
        self.print_usage(sys.stderr)
        self.exit(TROUBLE, f"{self.prog}: {message}\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="python -m glenoid", description=(package_doc or "").split("\n")[0])
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, run: object, text: str, bus: bool = True) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text)
        sub.set_defaults(run=run)
        if bus:
            _add_bus(sub)
        return sub

    sub = command("calibrate", _calibrate, "Run a calibration, or join the one under way, and decide on its result.")
    sub.add_argument("--yes", action="store_true", help="accept a verified centre without asking")
    sub.add_argument("--two-phases", action="store_true", help="hold the shoulder blade in the first poses")
    sub.add_argument("--new", action="store_true", help="abort a run under way and start another")

    command("numbering", _numbering, "Check that the cables are numbered as the rig says: pull one after the other.")

    sub = command("watch", _watch, "Show what the board says.")
    sub.add_argument("--all", action="store_true", help="every message, heartbeats too")
    sub.add_argument("--seconds", type=float, help="end after so long")

    sub = command("record", _record, "Record the bus into a file: .log, .asc, .blf, .trc, .csv, by its name.")
    sub.add_argument("file")
    sub.add_argument("--seconds", type=float, help="end after so long")

    sub = command("parameters", _parameters, "The board's parameters: read, set, saved.")
    actions = sub.add_subparsers(required=True, metavar="ACTION", dest="action")

    def action(name: str, text: str) -> argparse.ArgumentParser:
        one = actions.add_parser(name, help=text, description=text)
        # before the action or behind it
        _add_bus(one, given=False)
        return one

    action("list", "all of them, with unit, range and default")
    action("get", "the value in use").add_argument("name")
    setting = action("set", "prepare a value; nothing changes before save")
    setting.add_argument("name")
    setting.add_argument("value", type=float)
    loading = action("load", "prepare what a rig's file says; nothing changes before save")
    loading.add_argument("file", help="RIG.toml, as cargo identify reads it")
    action("save", "check the prepared values together and store them; the board starts anew")
    action("discard", "forget the prepared values")
    opening = action("unlock", "open the lock for ten minutes")
    opening.add_argument("key", help="file with the key: 32 hexadecimal digits")
    action("lock", "close the lock")
    keying = action("key", "prepare another key of the lock; it holds after save")
    keying.add_argument("key", help="file with the key: 32 hexadecimal digits; all 0: no lock")

    sub = command("poses", _poses, "The poses of a recorded run as a table for cargo identify.", bus=False)
    sub.add_argument("recording")
    sub.add_argument("-o", "--output", help="file for the table (default: the standard output)")
    sub.add_argument("--set", choices=("1", "2", "both"), default="1", help="1 identifies (default), 2 verifies")
    sub.add_argument("--run", dest="number", type=int, help="number of the run (default: the last with poses)")
    return parser


def _add_bus(parser: argparse.ArgumentParser, given: bool = True) -> None:
    """The bus that a command talks to; not `given`: only what is named, the rest is given elsewhere."""

    def add(*names: str, default: object, **keys: Any) -> None:
        parser.add_argument(*names, default=default if given else argparse.SUPPRESS, **keys)

    add("-i", "--interface", default="slcan", help="python-can's interface (default: slcan)")
    add(
        "-c", "--channel", default="socket://127.0.0.1:5601",
        help="its channel (default: the emulated board, socket://127.0.0.1:5601)",
    )
    add("-b", "--bitrate", type=int, default=500_000, help="bit/s (default: 500000)")
    add(
        "--base-id", type=lambda text: int(text, 0), default=FIRST_ID, metavar="ID",
        help=f"first identifier of the board, where the parameter base_id is not {FIRST_ID:#x}",
    )


def _open(options: argparse.Namespace) -> Device:
    return open_device(options.interface, options.channel, options.bitrate, base_id=options.base_id)


def _say(text: str) -> None:
    print(text, flush=True)


def _calibrate(options: argparse.Namespace) -> int:
    asker = Asker(always=options.yes, say=_say)
    with _open(options) as device:
        under_way = device.heartbeat is not None and device.heartbeat["state"] in (
            "Collecting", "Identifying", "Verifying", "Review",
        )
        joined = under_way and not options.new
        try:
            result = calibrate(device, asker.decide, say=_say, anew=options.new, two_phases=options.two_phases)
        except KeyboardInterrupt:
            _say(after_interrupt(device, joined))
            return INTERRUPTED
        angle = _angle(device, result.run) if result.hinge is not None else None
    if result.accepted:
        centre = " ".join(f"{value:.3f}" for value in result.centre_mm or ())
        _say(f"run {result.run}: accepted, in use now: {result.hinge or f'{centre} mm'}".rstrip())
        if angle is not None:
            _say(f"  now: {angle_text(angle)}")
        for note in result.notes:
            _say(f"  but note: {explained(note)}")
        return ACCEPTED
    about = f" ({result.about})" if result.about else ""
    print(f"run {result.run} ended with {explained(result.reason)}{about}; nothing was accepted", file=sys.stderr)
    return NOT_ACCEPTED


def _angle(device: Device, run: int) -> Message | None:
    """How far the hinge of this run bends now; None when the board does not say it."""
    heard = device.listen(ANGLE_S)
    return next((message for message in heard if message.name == "HingeAngle" and message["run_id"] == run), None)


def _numbering(options: argparse.Namespace) -> int:
    with _open(options) as device:
        return 0 if check_numbering(device, _say) else NOT_ACCEPTED


def _watch(options: argparse.Namespace) -> int:
    with _open(options) as device:
        watch(device, _say, every=options.all, seconds=options.seconds)
    return 0


def _record(options: argparse.Namespace) -> int:
    with _open(options) as device:
        # what answers this says in the recording which joint the board is about
        device.send(encode_command("Query", 0, 0, 0))
        frames = record(device.bus, options.file, options.seconds)
    _say(f"{frames} frames in {options.file}")
    return 0


def _shown(parameters: Parameters, name: str, operation: str) -> str:
    try:
        return f"{parameters.get(name, operation):g}"
    except Refused:
        # the key of the lock cannot be read
        return "-"


def _parameters(options: argparse.Namespace) -> int:
    with _open(options) as device:
        parameters = Parameters(device)
        if options.action == "list":
            for name, parameter in parameters.known.items():
                value, default, least, most = (
                    _shown(parameters, name, operation)
                    for operation in ("Read", "ReadDefault", "ReadMinimum", "ReadMaximum")
                )
                _say(f"{name} = {value} {parameter.unit}  (default {default}, {least} to {most})  {parameter.comment}")
        elif options.action == "get":
            _say(f"{parameters.get(options.name):.9g} {parameters.named(options.name).unit}".rstrip())
        elif options.action == "set":
            parameters.set(options.name, options.value)
            _say(f"{options.name} is prepared; python -m glenoid parameters save makes it so")
        elif options.action == "load":
            values = parameters_of(options.file)
            for name, number in values.items():
                parameters.set(name, number)
            _say(f"{len(values)} parameters are prepared; python -m glenoid parameters save makes it so")
        elif options.action == "unlock":
            unlock(parameters, read_key(options.key))
            _say("the lock is open for ten minutes")
        elif options.action == "lock":
            parameters.ask("Lock")
            _say("the lock is closed")
        elif options.action == "key":
            set_key(parameters, read_key(options.key))
            _say("the key is prepared; python -m glenoid parameters save makes it so")
        elif options.action == "save":
            parameters.save()
            _say("saved; the board starts anew with it")
        else:
            parameters.discard()
            _say("the prepared values are forgotten")
    return 0


def _poses(options: argparse.Namespace) -> int:
    held_out = {"1": False, "2": True, "both": None}[options.set]
    runs = [run for run in read_runs(options.recording) if run.whole_poses()]
    poses = read_poses(options.recording, options.number, held_out)
    if options.output:
        with open(options.output, "w", encoding="utf-8", newline="\n") as out:
            write_csv(poses, out)
    else:
        write_csv(poses, sys.stdout)
    chosen = options.number or runs[-1].number
    others = f", the last of {len(runs)} runs" if len(runs) > 1 and not options.number else ""
    run = next(run for run in reversed(runs) if run.number == chosen)
    found = f"; the board found {run.found_text}" if run.found_text else ""
    print(f"{options.recording}: run {chosen}{others}, {len(poses)} poses{found}", file=sys.stderr)
    for gap in gaps(run):
        print(f"{options.recording}: {gap}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
