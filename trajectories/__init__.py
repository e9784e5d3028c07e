"""Motions that excite the parameters, and recordings simulated on them. Imports only the model room."""

from .simulation import RX90_NOISE, Simulator, parameter_vector
from .via_points import ViaPoints, random_via_points, shortest_durations

__all__ = [
    "RX90_NOISE",
    "Simulator",
    "ViaPoints",
    "parameter_vector",
    "random_via_points",
    "shortest_durations",
]
