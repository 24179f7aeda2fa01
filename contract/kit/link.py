"""A robot's link to its mediator, and the next one while that takes over: certificates end, and robots are heard all the time."""

from __future__ import annotations

import math
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable

from . import wire
from .identity import RENEWS, Identity, NoLink, Request, check
from .network import Network

# After the start: the link is up by then.
FIRST_REQUEST_S = 5.0
# Between a request that was not answered, or was refused, and the next.
RETRY_S = 60.0
# Between two looks at the file, over which somebody may copy another one.
LOOK_S = 2.0
# Nothing is heard for so long over a link that lives: another session is tried.
UNHEARD_S = 10.0
# How long a request may wait for its answer, and the next session for its link.
PATIENCE_S = 10.0


class Link:
    """What a robot says and hears. `take` gets the mediator's messages, from threads of zenoh's."""

    def __init__(self, endpoint: str, prefix: str, robot_id: str, file: str | None, take: Callable[[bytes], None]) -> None:
        self._endpoint, self._key, self._take = endpoint, f"{prefix}/robots/{robot_id}", take
        self._mine = f"{prefix}/mediator/to/{robot_id}"
        self._file = Path(file) if file else None
        # As the file was read or written last.
        self._filed = Identity.read(self._file) if self._file else None
        check([endpoint], self._filed)
        self._heard_at = time.monotonic()
        self._network, self._identity, self._told = self._open(self._filed), self._filed, ""
        if self._file:
            threading.Thread(target=self._look_after, daemon=True).start()

    def put(self, name: str, message: Any) -> None:
        """Sends a message under one of the robot's keys."""
        self._network.put(f"{self._key}/{name}", message.SerializeToString())

    def _open(self, identity: Identity | None) -> Network:
        network = Network(connect=[self._endpoint], identity=identity)
        network.subscribe(self._mine, lambda _, data: self._hear(data))
        network.show_alive(f"{self._key}/alive")
        return network

    def _hear(self, data: bytes) -> None:
        self._heard_at = time.monotonic()
        self._take(data)

    def _look_after(self) -> None:
        """Takes over what somebody puts in place of the file, asks for the next certificate in time, and tries another session
        where nothing is heard: a link that was made while the mediator closed its session may live and carry nothing."""
        assert self._file is not None and self._identity is not None
        request_at = time.monotonic() + FIRST_REQUEST_S
        if not RENEWS:
            request_at = math.inf
            self._tell("the package `cryptography` is missing, so none is asked for: copy a new file over this one before it ends")
        while True:
            time.sleep(LOOK_S)
            try:
                if (other := Identity.read(self._file)) != self._filed:
                    self._go_over(other)
                    self._filed = other
                elif not self._network.is_linked():
                    raise NoLink(f"found no link with {self._endpoint}: the mediator is away, or does not take this certificate")
                elif time.monotonic() >= self._heard_at + UNHEARD_S:
                    self._heard_at = time.monotonic()
                    self._go_over(self._identity, "nothing was heard over a link that lives; another session is in use")
                elif time.monotonic() >= request_at:
                    request_at = time.monotonic() + RETRY_S
                    request_at = time.monotonic() + self._renew(self._file)
            except NoLink as error:
                self._tell(str(error))

    def _renew(self, file: Path) -> float:
        """Asks for the next certificate, stores it and goes over to it. Returns after how many seconds to ask again."""
        assert self._identity is not None
        request = Request(self._identity)
        data = self._network.ask(f"{self._key}/certificate", wire.CertificateRequest(request_pem=request.pem).SerializeToString(), PATIENCE_S)
        answer: Any = None if data is None else wire.decode(wire.CertificateAnswer, data)
        if answer is None or answer.refusal:
            why = "it does not answer" if answer is None else answer.refusal
            raise NoLink(f"the mediator has made no new one: {why}; it is asked again in {RETRY_S:.0f} s")
        new, stored = request.answered(answer.certificate_pem), True
        try:
            new.store(file)
        except OSError as error:
            stored = False
            self._tell(f"the new one is good until this process ends, since it cannot be stored: {error}; make {file} and its folder writable")
        self._go_over(new)
        self._filed = new if stored else self._filed
        return float(max(1, answer.renew_after_s))

    def _go_over(self, identity: Identity, why: str = "another one is in use") -> None:
        """Opens another session, and closes the old one when the other has its link."""
        successor, end = self._open(identity), time.monotonic() + PATIENCE_S
        while not successor.is_linked():
            if time.monotonic() > end:
                successor.close()
                raise NoLink(f"found no link with the new one within {PATIENCE_S:.0f} s; the old link stays as long as its own is good")
            time.sleep(0.02)
        before, self._network, self._identity = self._network, successor, identity
        before.close()
        self._told = ""
        self._tell(why)

    def _tell(self, what: str) -> None:
        """Tells people, once as long as it stays so."""
        if what != self._told:
            print(f"certificate: {what}", file=sys.stderr, flush=True)
        self._told = what
