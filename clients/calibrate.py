#!/usr/bin/env python3
"""The protocol in sixty lines: runs one calibration, shows the new centre beside the one in use, accepts it.

    pip install python-can cantools pyserial
    clients/calibrate.py slcan socket://127.0.0.1:5601    # the emulated board (cargo emulate)
    clients/calibrate.py socketcan can0                   # a real bus

Somebody moves the arm from pose to pose and holds it still in each; the device captures by itself and says what next.
For daily use there is `python -m glenoid calibrate`, which joins, resumes, asks and aborts.
"""
import binascii, pathlib, struct, sys, time, can, cantools

DBC = cantools.database.load_file(pathlib.Path(__file__).resolve().parent.parent / "glenoid.dbc")
COMMAND = DBC.get_message_by_name("Command")
SENT = {m.frame_id: m for m in DBC.messages if m.senders == ["Glenoid"] and not m.is_multiplexed()}

class Client:
    def __init__(self, bus):
        self.bus, self.nonce = bus, int(time.time()) & 0xFFFF
    def listen(self, silence=15, seconds=float("inf")):
        """Yields the device's messages as (name, fields), for so many seconds. The device owns every time limit of a run."""
        begin = heard = time.monotonic()
        while (now := time.monotonic()) < begin + seconds:
            if (frame := self.bus.recv(min(0.2, begin + seconds - now))) and (message := SENT.get(frame.arbitration_id)):
                heard = now
                yield message.name, dict(message.decode(frame.data), data=bytes(frame.data))
            elif now > heard + silence:
                sys.exit("the device is silent; if it is on, its run goes on")
    def ask(self, opcode, run=0, argument=0, boot=0):
        """Sends a command, returns its answer. Asks again when that is lost: the nonce keeps it from acting twice."""
        self.nonce = self.nonce % 0xFFFF + 1
        data = COMMAND.encode(dict(opcode=opcode, boot_low=boot & 255, nonce=self.nonce, for_run=run, argument=argument))
        for _ in range(40):
            self.bus.send(can.Message(arbitration_id=COMMAND.frame_id, is_extended_id=False, data=data))
            for name, answer in self.listen(seconds=0.3):
                if name == "Answer" and answer["nonce"] == self.nonce:
                    return answer
        sys.exit(f"no answer to {opcode}: is the device on this bus?")

def calibrate(client):
    client.ask("Query")
    module = next((m for name, m in client.listen(seconds=2) if name == "Module"), None)
    if module and module["joint"] == "Hinge":
        sys.exit("this board's joint is a hinge, which has no centre: python -m glenoid calibrate finds its axis")
    while (answer := client.ask("Start"))["code"] != "Fine":
        if answer["code"] in ("AlreadyRunning", "AcknowledgeFirst"):
            sys.exit(f"{answer['code']}: python -m glenoid calibrate goes on from there")
        print(f"cannot start yet: {answer['code']}", end="\r")
        time.sleep(0.2)
    run, centre, verification, shown = answer["run_id"], {}, None, {}
    for name, m in client.listen():
        if name.startswith("Candidate"):  # centre, radii, offsets, and what names them; in this order
            shown[name, str(m.get("axis", m.get("end_point", m.get("cable"))))] = m
        if name == "Pose":
            sigma = f", expected sigma {m['predicted_sigma']:.3f} mm" if m["predicted_sigma_known"] else ""
            print(f"pose {m['index'] + 1} of set {m['held_out'] + 1}: {m['reason']}{sigma}; now: {m['guidance']}")
        elif name in ("CandidateCentre", "LiveCentre"):
            centre[name, str(m["axis"])] = f"{m['value']:9.3f} +- {m['sigma']:.3f} mm"
        elif name == "Verification":
            verification = m
        elif name == "Versions" or (name == "Heartbeat" and m["state"] == "Idle" and not verification):
            sys.exit(f"the device was restarted; run {run} is lost, the old centre stays in use")
        elif name == "Outcome" and m["run_id"] == run and m["reason"] == "Fine":  # complete, and not decided yet
            for axis in "xyz":
                print(f"{axis}: {centre['CandidateCentre', axis]}   in use: {centre.get(('LiveCentre', axis), 'none')}")
            print(f"deviation of the second set: {verification['deviation']:.3f} mm (limit {verification['limit']:.3f})")
            naming = shown.pop(("CandidateNaming", "None"))  # accept what was shown: CRC-16/IBM-3740 over its frames
            data = struct.pack("<HH", naming["boot"], naming["wearer"]) + b"".join(m["data"] for m in shown.values())
            client.ask("Accept", run, binascii.crc_hqx(data, 0xFFFF), naming["boot"])
        elif name == "Outcome" and m["run_id"] == run:
            client.ask("Acknowledge", run)
            sys.exit(0 if m["reason"] == "Accepted" else f"run {run}: {m['reason']}, see docs/reasons.md")
interface, channel = sys.argv[1:3] if len(sys.argv) == 3 else sys.exit(__doc__)
extra = {"sleep_after_open": 0} if interface == "slcan" else {}
with can.Bus(interface=interface, channel=channel, bitrate=500_000, **extra) as bus:
    calibrate(Client(bus))
