"""The checks of a robot."""

from ..checks import Suite

SUITE = Suite("robot")

# Each module adds its checks; they are run in this order.
from . import reports, registration, mediators, areas, lease, revoked, control, rough, restart  # noqa: E402,F401
