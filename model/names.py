"""Names of standard parameters: a kind and the number of a link or joint, "XX3", "FV2", "FSM6"."""

FRICTION = ("FS", "FV", "OFF", "FVM", "FSM")
"""Kinds of friction, constant torques among them."""


def parameter_kind(name: str) -> str:
    """The kind alone: "XX" of "XX3"."""
    return name.rstrip("0123456789")
