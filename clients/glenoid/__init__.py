"""Client of the Glenoid calibration device over CAN.

    import glenoid

    with glenoid.open_device("slcan", "socket://127.0.0.1:5601") as device:
        result = glenoid.calibrate(device, decide=lambda review: review.worst_sigma_mm < 0.1)
        print(result.centre_mm)

    poses = glenoid.read_poses("run.blf")      # a recording of any format that python-can reads
"""

from .calibration import Result, Review, calibrate
from .device import BoardSilent, Device, DeviceError, NoAnswer, OtherProtocol, open_device
from .joint import Axis, Centre, Hinge
from .lock import read_key, unlock
from .parameters import Parameter, Parameters
from .recording import Pose, Run, read_poses, read_runs, write_csv
from .vocabulary import DATABASE, PROTOCOL, Message

__all__ = [
    "DATABASE", "PROTOCOL", "Axis", "BoardSilent", "Centre", "Device", "DeviceError", "Hinge", "Message", "NoAnswer",
    "OtherProtocol", "Parameter", "Parameters", "Pose", "Result", "Review", "Run", "calibrate", "open_device", "read_key",
    "read_poses", "read_runs", "unlock", "write_csv",
]
