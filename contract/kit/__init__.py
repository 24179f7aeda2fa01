"""Conformance kit of the fleet protocol: plays robots for a mediator, and a mediator for robots."""
