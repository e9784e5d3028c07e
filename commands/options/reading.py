"""From argparse's namespace to typed values."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from ... import model
from ...common.arrays import Array
from ...common.errors import InputError


@dataclass(frozen=True)
class Options:
    """Some options of a command; fields are called as the options are."""

    @classmethod
    def of(cls, arguments: argparse.Namespace) -> Self:
        """Take them from the parsed command line."""
        return cls(**{field.name: getattr(arguments, field.name) for field in fields(cls)})

    def has(self, option: str) -> bool:
        """Whether an option was given; "joint_names" stands for --joint-names."""
        value = getattr(self, option)
        return value is not None and value is not False

    def refuse(self, option: str, because: str) -> None:
        """Refuse an option that would have no effect.

        Raises:
            InputError: if it was given.
        """
        if self.has(option):
            raise InputError(f"--{option.replace('_', '-')} {because}")


def in_si(values: tuple[float, ...], robot: model.Robot) -> Array:
    """Degrees of turning joints in radians; metres of sliding ones as they are."""
    if len(values) != robot.n:
        raise InputError(f"{len(values)} numbers for the {robot.n} joints of robot {robot.name!r}: give one each")
    return np.array([np.radians(x) if joint.revolute else x for x, joint in zip(values, robot.joints, strict=True)])
