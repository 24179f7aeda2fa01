"""The checks of a mediator."""

from ..checks import Suite

SUITE = Suite("mediator")

# Each module adds its checks; they are run in this order.
from . import registration, identity, restart, areas, claims, blocking, bodies, rough, mediators, control  # noqa: E402,F401
