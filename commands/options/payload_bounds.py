"""Payloads that a motion must bear: one body, or every body within bounds."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ... import model, trajectories
from ...common.errors import InputError
from ..progress import note
from ..values import gains_list

_BOX = "box:"


def region(text: str) -> tuple[tuple[float, ...], bool]:
    """Radius or three half axes [m], and whether they are half edges of a box."""
    box = text.startswith(_BOX)
    half = gains_list(text.removeprefix(_BOX))
    if len(half) not in (1, 3) or not all(0.0 < x < np.inf for x in half):
        raise argparse.ArgumentTypeError(f"{text!r}: give R, A,B,C or box:A,B,C, each above 0 m")
    return half, box


def payload_bounds(
    robot: model.Robot, text: str, within: tuple[tuple[float, ...], bool] | None
) -> model.InertialParameters | trajectories.PayloadSet:
    """The payload of ``--heaviest-payload``, or with ``--within`` the set, in the last link's frame.

    Raises:
        InputError: for what is no payload, or a file with ``--within``.
    """
    flange = robot.flange
    if Path(text).suffix.lower() == ".toml":
        if within is not None:
            raise InputError(f"--within bounds payloads that are not known, {text} is one: give KG[@X,Y,Z]")
        return model.read_payload(text).moved(flange.R, flange.p)
    mass, _, place = text.partition("@")
    try:
        kilograms = float(mass)
        centre = [float(x) for x in place.split(",")] if place else [0.0, 0.0, 0.0]
    except ValueError:
        kilograms, centre = np.nan, [0.0]
    if not (0.0 < kilograms < 1e6) or len(centre) != 3 or not np.isfinite(centre).all():
        raise InputError(f"--heaviest-payload {text!r}: give kg, kg@x,y,z (m), or a TOML file")
    if within is not None:
        half, box = within
        sides = half if len(half) == 3 else half * 3
        return trajectories.PayloadSet.within(kilograms, sides, centre, box).seen_from(flange)
    if not place:
        note(
            f"--heaviest-payload {text} is taken as a point at the origin of the payload's frame: give kg@x,y,z "
            "or a TOML file to put it where it hangs, or --within for every payload about it"
        )
    return model.InertialParameters.from_com(kilograms, centre, np.zeros((3, 3))).moved(flange.R, flange.p)
