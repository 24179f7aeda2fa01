"""The fleet's network: one zenoh session, put and subscribed as PROTOCOL.md says."""

from __future__ import annotations

import json
import os
import secrets
import socket
from typing import Any, Callable, Sequence

# Read by zenoh when it is loaded: on two threads, links with certificates break, see PROTOCOL.md.
os.environ["ZENOH_RUNTIME"] = "(rx: (worker_threads: 1), tx: (handover: rx), acc: (handover: rx))"

import zenoh

from .identity import Identity, NoLink, check


def free_endpoint() -> str:
    """A free endpoint on the loopback, where the system has them with an address of its own: on the common one, the port of a program
    that is started again may meanwhile be another one's, or that of any connection."""
    with socket.socket() as listener:
        try:
            listener.bind((f"127.{secrets.randbelow(256)}.{secrets.randbelow(256)}.{1 + secrets.randbelow(254)}", 0))
        except OSError:
            listener.bind(("127.0.0.1", 0))
        return "tcp/{}:{}".format(*listener.getsockname())


class Network:
    """A session that finds nobody but whom it is told of."""

    def __init__(self, connect: Sequence[str] = (), listen: Sequence[str] = (), identity: Identity | None = None) -> None:
        check([*connect, *listen], identity)
        config = zenoh.Config()
        for key, value in {
            "mode": "peer",
            "connect/endpoints": list(connect),
            "listen/endpoints": list(listen),
            # The other side may come later, and come again.
            "connect/timeout_ms": -1,
            "connect/exit_on_failure": False,
            "connect/retry": {"period_init_ms": 100, "period_max_ms": 300, "period_increase_factor": 1.5},
            # With the usual two batches, and a millisecond for a sender that was not scheduled, a busy machine drops what is sent once.
            "transport/link/tx/queue/size/data": 16,
            "transport/link/tx/queue/congestion_control/drop/wait_before_drop": 5_000,
            # Nothing here is large enough for it, and a process that is killed leaves its files behind.
            "transport/shared_memory/enabled": False,
            "scouting/multicast/enabled": False,
            "scouting/gossip/enabled": False,
            **(identity.settings() if identity is not None else {}),
        }.items():
            config.insert_json5(key, json.dumps(value))
        try:
            self._session = zenoh.open(config)
        except zenoh.ZError as error:
            raise NoLink(f"found no way to open {', '.join([*connect, *listen])}, expected a free endpoint, and a key that goes with its "
                         f"certificate: {error}") from error
        self._kept: list[Any] = []

    def put(self, key: str, data: bytes) -> None:
        """Sends a message: it is dropped rather than waited for, and does not wait for others."""
        self._session.put(key, data, congestion_control=zenoh.CongestionControl.DROP, express=True)

    def subscribe(self, key: str, take: Callable[[str, bytes], None]) -> None:
        """Calls `take` with key and bytes of each message, from a thread of zenoh's."""
        def handler(sample: Any) -> None:
            take(str(sample.key_expr), sample.payload.to_bytes())

        self._kept.append(self._session.declare_subscriber(key, handler))

    def show_alive(self, key: str) -> None:
        """Declares a liveliness token, which is there until the session ends."""
        self._kept.append(self._session.liveliness().declare_token(key))

    def is_alive(self, key: str) -> bool:
        """Whether somebody has declared this token."""
        return any(reply.ok is not None for reply in self._session.liveliness().get(key, timeout=1.0))

    def ask(self, key: str, data: bytes, seconds: float) -> bytes | None:
        """The first answer to a query; None when there is none in time."""
        answers = (reply.ok for reply in self._session.get(key, payload=data, timeout=seconds))
        return next((answer.payload.to_bytes() for answer in answers if answer is not None), None)

    def is_linked(self) -> bool:
        """Whether anybody is at the other end."""
        return any(True for _ in self._session.info.peers_zid())

    def close(self) -> None:
        """Ends the session."""
        self._session.close()
