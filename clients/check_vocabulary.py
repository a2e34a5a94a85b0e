#!/usr/bin/env python3
"""Holds the firmware's codec against cantools, both ways, with random values: every message of glenoid.dbc.

    pip install cantools
    clients/check_vocabulary.py [COUNT]
"""
import pathlib, random, subprocess, sys
import cantools

ROOT = pathlib.Path(__file__).resolve().parent.parent
DBC = cantools.database.load_file(ROOT / "glenoid.dbc")
COUNT = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000


def vocabulary(*arguments, lines=""):
    """Runs the firmware's own codec, compiled for this machine."""
    command = ["cargo", "run", "--quiet", "--release", "--package", "host-tests", "--bin", "vocabulary", "--", *arguments]
    return subprocess.run(command, cwd=ROOT, input=lines, capture_output=True, text=True, check=True).stdout.splitlines()


def fields_of(words):
    return {name: float(value) for name, value in (word.split("=") for word in words)}


def fail(text):
    sys.exit(f"check_vocabulary: {text}")


def encoded_here_decoded_there():
    """What the firmware packs, cantools decodes to the same value within half a step."""
    for line in vocabulary("encode", str(COUNT)):
        identifier, data, name, *words = line.split()
        message = DBC.get_message_by_frame_id(int(identifier, 16))
        decoded = message.decode(bytes.fromhex(data), decode_choices=False)
        for field, value in fields_of(words).items():
            step = message.get_signal_by_name(field).scale
            if abs(decoded[field] - value) > step / 2:
                fail(f"{name}.{field}: {value} here, {decoded[field]} by cantools")


def random_fields(message):
    """Random values within each signal's range, on its steps; codes among those that have a name."""
    fields = {}
    for signal in message.signals:
        if signal.choices:
            fields[signal.name] = random.choice(list(signal.choices))
        else:
            steps = random.randint(round(signal.minimum / signal.scale), round(signal.maximum / signal.scale))
            fields[signal.name] = steps * signal.scale
    # a value that is not known is sent as 0
    for known in [name for name in fields if name.endswith("_known")]:
        fields[known.removesuffix("_known")] *= fields[known]
    return fields


def encoded_there_decoded_here():
    """What cantools packs, the firmware decodes to the same value, to the digits of a single."""
    sent = [message for message in DBC.messages if message.senders != ["Client"] and not message.is_multiplexed()]
    cases = [(message, random_fields(message)) for message in (random.choice(sent) for _ in range(COUNT))]
    lines = "".join(f"{message.frame_id:03x} {message.encode(fields).hex()}\n" for message, fields in cases)
    for (message, fields), line in zip(cases, vocabulary("decode", lines=lines), strict=True):
        name, *words = line.split()
        decoded = fields_of(words)
        if name != message.name or decoded.keys() != fields.keys():
            fail(f"{message.name} became {line}")
        for field, value in fields.items():
            if abs(decoded[field] - value) > abs(value) * 2**-24:
                fail(f"{name}.{field}: {value} by cantools, {decoded[field]} here")


random.seed(1)
encoded_here_decoded_there()
encoded_there_decoded_here()
print(f"{COUNT} messages each way: the firmware and cantools {cantools.__version__} agree")
