"""SOEM brings one SubDevice to OP, and exchanges process data with it.

usage: python3 -c SCRIPT INTERFACE LENGTH_NS PERIOD_NS TIMEOUT_US PRIORITY CORE

Prints how many nanoseconds Python takes of each exchange; then for each exchange when it began and ended, in nanoseconds of the
clock that goes on while the computer sleeps. Priority 0 is none.
"""

import functools
import gc
import os
import sys
import time

import pysoem

# Exchanges on the way to OP, each with a look at the state.
ATTEMPTS = 500
# Calls whose mean is Python's part.
CALLS = 1_000


def reach_op(master):
    """Asks for OP while process data flows."""
    master.state = pysoem.OP_STATE
    master.write_state()
    for _ in range(ATTEMPTS):
        master.send_processdata()
        master.receive_processdata(20_000)
        if master.state_check(pysoem.OP_STATE, 1_000) == pysoem.OP_STATE:
            return
    sys.exit("the SubDevice does not reach OP")


def exchanges(master, length_ns, period_ns, timeout_us):
    """When each exchange began and ended."""
    times = []
    # As the stalls of the machine are told.
    clock = functools.partial(time.clock_gettime_ns, time.CLOCK_BOOTTIME)
    send, receive, sleep = master.send_processdata, master.receive_processdata, time.sleep
    following_ns = clock()
    for _ in range(length_ns // period_ns):
        began_ns = clock()
        send()
        receive(timeout_us)
        times.append((began_ns, clock()))
        following_ns = max(following_ns + period_ns, clock())
        sleep(max(following_ns - clock(), 0) * 1e-9)
    return times


def python_ns():
    """What two calls from Python take, beside what they do: of a function in C that does next to nothing."""
    clock = time.monotonic_ns
    began_ns = clock()
    for _ in range(CALLS):
        abs(0)
        abs(0)
    return (clock() - began_ns) // CALLS


def main():
    interface = sys.argv[1]
    length_ns, period_ns, timeout_us, priority, core = (int(text) for text in sys.argv[2:])
    master = pysoem.Master()
    master.open(interface)
    try:
        if master.config_init() != 1:
            sys.exit("SOEM does not find one SubDevice")
        master.config_map()
        if master.state_check(pysoem.SAFEOP_STATE, 2_000_000) != pysoem.SAFEOP_STATE:
            sys.exit("the SubDevice does not reach SAFEOP")
        reach_op(master)
        os.sched_setaffinity(0, {core})
        if priority > 0:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        gc.disable()
        own_ns = python_ns()
        times = exchanges(master, length_ns, period_ns, timeout_us)
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        master.state = pysoem.INIT_STATE
        master.write_state()
    finally:
        master.close()
    print(own_ns)
    print("\n".join(f"{began_ns} {ended_ns}" for began_ns, ended_ns in times))


main()
