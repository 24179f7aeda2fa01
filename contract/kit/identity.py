"""Who a program is where links have certificates: a file of three PEM blocks, zenoh's settings for it, and its next certificate.

The next certificate takes the package `cryptography`. Without it somebody copies another file over this one in time.
"""

from __future__ import annotations

import base64
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterable

try:
    from cryptography import x509
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
except ImportError:
    x509 = None  # type: ignore[assignment]

# Whether a next certificate can be asked for.
RENEWS = x509 is not None
BLOCK = re.compile(r"-----BEGIN ([A-Z0-9 ]+)-----\n.*?-----END \1-----\n?", re.DOTALL)
EXPECTED = ["PRIVATE KEY", "CERTIFICATE", "CERTIFICATE"]
MESSAGES = ["put", "delete", "declare_subscriber", "query", "reply", "declare_queryable", "liveliness_token", "liveliness_query",
            "declare_liveliness_subscriber"]


class NoLink(Exception):
    """A sentence: what was found wrong with a file, an endpoint or an answer, and what was expected."""


@dataclass(frozen=True)
class Identity:
    """A key, its certificate, and the certificate of the authority that made it; all PEM."""

    key: str
    certificate: str
    authority: str

    @classmethod
    def parse(cls, text: str, where: str) -> Identity:
        """Splits a file's text."""
        blocks = [(found.group(1), found.group(0)) for found in BLOCK.finditer(text.replace("\r\n", "\n"))]
        names = [name for name, _ in blocks]
        if names != EXPECTED:
            raise NoLink(f"{where}: found the PEM blocks {names}, expected {EXPECTED}: a key (PKCS #8), its certificate and the "
                              "authority's; `mediator keys robot` makes such a file")
        return cls(*(block for _, block in blocks))

    @classmethod
    def read(cls, path: Path) -> Identity:
        """Reads a file."""
        try:
            return cls.parse(path.read_text(encoding="ascii"), str(path))
        except (OSError, UnicodeDecodeError) as error:
            raise NoLink(f"{path}: found nothing to read ({error}), expected a file of `mediator keys robot`") from error

    def store(self, path: Path) -> None:
        """All or nothing, and nobody else may read it."""
        new = path.with_name(path.name + ".new")
        new.unlink(missing_ok=True)
        with open(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as file:
            file.write(self.key + self.certificate + self.authority)
            file.flush()
            os.fsync(file.fileno())
        new.replace(path)

    def settings(self) -> dict[str, Any]:
        """zenoh's settings: certificates on both ends of each link, and dealings with the mediator alone."""
        secrets = {"root_ca_certificate": self.authority, "connect_private_key": self.key, "connect_certificate": self.certificate}
        mediator = {"id": "mediator", "cert_common_names": ["mediator"]}
        all_of_it = {"id": "all", "permission": "allow", "flows": ["ingress", "egress"], "messages": MESSAGES, "key_exprs": ["**"]}
        return {
            # What a host is called proves nothing: the name in its certificate does.
            "transport/link/tls/verify_name_on_connect": False,
            "transport/link/tls/enable_mtls": True,
            "transport/link/tls/close_link_on_expiration": True,
            **{f"transport/link/tls/{name}_base64": base64.b64encode(pem.encode()).decode() for name, pem in secrets.items()},
            "access_control": {"enabled": True, "default_permission": "deny", "rules": [all_of_it], "subjects": [mediator],
                               "policies": [{"rules": ["all"], "subjects": ["mediator"]}]},
        }


def check(endpoints: Iterable[str], identity: Identity | None) -> None:
    """That links have certificates just where there are some."""
    for endpoint in endpoints:
        if identity is not None and not endpoint.startswith("tls/"):
            raise NoLink(f"found the endpoint {endpoint}, which uses no certificates, expected tls/HOST:PORT; leave --identity out where "
                              "the mediator has none")
        if identity is None and endpoint.startswith("tls/"):
            raise NoLink(f"found the endpoint {endpoint} and no certificate, expected --identity with the file that `mediator keys "
                              "robot` has made for this robot")


class Request:
    """A request for the next certificate. Its key never leaves this process."""

    def __init__(self, own: Identity) -> None:
        self._own, self._key = own, ec.generate_private_key(ec.SECP256R1())
        request = x509.CertificateSigningRequestBuilder().subject_name(x509.Name([])).sign(self._key, hashes.SHA256())
        self.pem = request.public_bytes(serialization.Encoding.PEM).decode()

    def answered(self, pem: str) -> Identity:
        """The identity with the certificate that was asked for, which must be this robot's, of the new key, by the same authority."""
        try:
            new, old, authority = (x509.load_pem_x509_certificate(text.encode())
                                   for text in (pem, self._own.certificate, self._own.authority))
            new.verify_directly_issued_by(authority)
        except (ValueError, TypeError, InvalidSignature) as error:
            raise NoLink(f"the mediator's new certificate is not by the authority of this file: {error or 'wrong signature'}") from error
        if new.public_key() != self._key.public_key() or new.subject != old.subject:
            raise NoLink(f"the mediator's new certificate: found one of {new.subject.rfc4514_string()} with another key or name, expected "
                              f"one of {old.subject.rfc4514_string()} for the key of the request")
        key = self._key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
        return Identity(key.decode(), pem, self._own.authority)
