#!/usr/bin/env python3
"""A MainDevice that was not written for our segment, SOEM, turns a wheel of the drive on a network interface.

usage: stranger_soem.py INTERFACE [--product 0x01705011] [--speed 5.0]

Needs pysoem (pip install pysoem) and CAP_NET_RAW. Prints what it saw. Exit code 0: everything was as it should be;
1: something was not, the last line says what; 2: it could not be tried.
"""

import argparse
import struct
import sys
import time

OUTPUT_BYTES, INPUT_BYTES = 36, 172
# Velocity mode, both motors enabled.
DRIVE = 0x000B
CURRENT_LIMIT_A = 20.0
CYCLE_S = 0.002
AL_WATCHDOG = 0x001B
SM2_CONTROL, WATCHDOG_ENABLED = 0x0814, 0x64
STATE_ERROR = 0x10


class Unexpected(Exception):
    """The segment did something that it should not."""


def check(condition, what):
    print(("ok    " if condition else "WRONG ") + what, flush=True)
    if not condition:
        raise Unexpected(what)


def outputs(speed_rad_s):
    """Both wheels forward at this speed: motor 1, the right wheel, is mirrored."""
    a = CURRENT_LIMIT_A
    return struct.pack("<HHffffffQ", DRIVE, 0, -speed_rad_s, speed_rad_s, a, -a, a, -a, 0)


class Inputs:
    def __init__(self, data):
        self.status1, self.status2, self.sensor_ts, self.setpoint_ts = struct.unpack_from("<HHQQ", data, 0)
        self.encoder1, self.velocity1 = struct.unpack_from("<ff", data, 20)
        self.encoder2, self.velocity2 = struct.unpack_from("<ff", data, 68)
        self.pivot, _, self.bus_voltage = struct.unpack_from("<fff", data, 116)


def exchange(master, seconds):
    """Exchanges process data for a time; returns cycles and how many had the wrong working counter."""
    cycles = wrong = 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        master.send_processdata()
        wrong += master.receive_processdata(20_000) != master.expected_wkc
        cycles += 1
        time.sleep(CYCLE_S)
    return cycles, wrong


def reach_op(pysoem, master):
    """Asks for OP while process data flows."""
    master.state = pysoem.OP_STATE
    master.write_state()
    for _ in range(100):
        exchange(master, 0.02)
        if master.state_check(pysoem.OP_STATE, 1_000) == pysoem.OP_STATE:
            return True
    master.read_state()
    print(f"      state {master.slaves[0].state:#04x}, AL status code {master.slaves[0].al_status:#06x}")
    return False


def session(pysoem, master, arguments):
    check(master.config_init() == 1, "config_init finds one SubDevice")
    drive = master.slaves[0]
    print(f"      name {drive.name!r}, vendor {drive.man:#010x}, product {drive.id:#010x}, revision {drive.rev:#x}")
    check(drive.id == arguments.product, f"product code {drive.id:#010x}")
    check(drive.man != 0, "a vendor id")
    check("KELO" in drive.name, "the name says KELO")
    check(master.config_dc(), "distributed clocks are supported")
    master.config_map()
    check(len(drive.output) == OUTPUT_BYTES, f"{len(drive.output)} bytes of outputs")
    check(len(drive.input) == INPUT_BYTES, f"{len(drive.input)} bytes of inputs")
    check(master.state_check(pysoem.SAFEOP_STATE, 2_000_000) == pysoem.SAFEOP_STATE, "SAFEOP")
    control = drive._fprd(SM2_CONTROL, 1)[0]
    check(control == WATCHDOG_ENABLED, f"outputs' SyncManager control {control:#04x}: watchdog enabled")

    drive.output = bytes(OUTPUT_BYTES)
    check(reach_op(pysoem, master), "OP")
    before = Inputs(drive.input)
    drive.output = outputs(arguments.speed)
    cycles, wrong = exchange(master, 0.6)
    driving = Inputs(drive.input)
    check(wrong == 0, f"{cycles} cycles with working counter {master.expected_wkc}, {wrong} with another")
    turned1, turned2 = driving.encoder1 - before.encoder1, driving.encoder2 - before.encoder2
    print(f"      turned {turned1:+.3f} and {turned2:+.3f} rad, now {driving.velocity1:+.2f} and "
          f"{driving.velocity2:+.2f} rad/s, {driving.bus_voltage:.1f} V")
    check(turned1 < -0.3 and turned2 > 0.3, "both wheels turn forward, motor 1 mirrored")
    check((driving.status1, driving.status2) == (63, 2051), f"status {driving.status1}, {driving.status2}")
    check(driving.sensor_ts > before.sensor_ts and driving.setpoint_ts > before.setpoint_ts, "time stamps advance")

    time.sleep(0.3)
    master.read_state()
    check(drive.state == pysoem.SAFEOP_STATE | STATE_ERROR and drive.al_status == AL_WATCHDOG,
          f"300 ms of silence: state {drive.state:#04x}, AL status code {drive.al_status:#06x}")
    drive.state = pysoem.SAFEOP_STATE | pysoem.STATE_ACK
    drive.write_state()
    check(drive.state_check(pysoem.SAFEOP_STATE, 1_000_000) == pysoem.SAFEOP_STATE, "SAFEOP after acknowledgement")
    exchange(master, 1.0)
    first = Inputs(drive.input)
    exchange(master, 0.1)
    second = Inputs(drive.input)
    check(second.sensor_ts > first.sensor_ts, "sensors go on")
    check(abs(second.encoder2 - first.encoder2) < 1e-3, "the watchdog has stopped the wheels")
    check(second.status1 & 3 == 0, "motors are off")

    drive.output = bytes(OUTPUT_BYTES)
    check(reach_op(pysoem, master), "OP again")
    master.state = pysoem.INIT_STATE
    master.write_state()
    check(master.state_check(pysoem.INIT_STATE, 1_000_000) == pysoem.INIT_STATE, "INIT")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("interface")
    parser.add_argument("--product", type=lambda text: int(text, 0), default=0x01705011)
    parser.add_argument("--speed", type=float, default=5.0, help="wheel speed in rad/s")
    arguments = parser.parse_args()
    try:
        import pysoem
    except ImportError as error:
        print(f"pysoem is not installed: {error}")
        return 2
    master = pysoem.Master()
    try:
        master.open(arguments.interface)
    except ConnectionError as error:
        print(f"cannot open {arguments.interface}: {error}")
        return 2
    try:
        session(pysoem, master, arguments)
    except Unexpected as what:
        print(f"failed: {what}")
        return 1
    finally:
        master.close()
    print("SOEM believes it")
    return 0


if __name__ == "__main__":
    sys.exit(main())
