"""Options of what a motion is to teach, and of the noise through which it is learnt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .... import model, trajectories
from ....common.arrays import Array
from ....common.errors import InputError
from ... import results
from ..progress import note
from ..values import fraction, gains_list, names_list, positive_number
from .reading import Options, option

_CRITERIA = ("d", "a", "cond", "cond-scaled")
RATE = 100.0
"""Hz: independent samples where nothing else is said."""


def _noise_level(text: str) -> Any:
    """A share of the torque limits, "10%" (a float); or a number per joint (a tuple)."""
    return fraction(text) if text.strip().endswith("%") else gains_list(text)


@dataclass(frozen=True)
class NoiseOptions(Options):
    """Torque noise per joint [N·m or N], or its share of the limits, and independent samples a second [Hz]."""

    GROUP: ClassVar[str] = "noise"

    torque_noise: float | tuple[float, ...] | None = option(
        type=_noise_level, metavar="S|S1,S2,..", help="sigma per joint [N·m or N], or 10%% of the limits"
    )
    independent_rate: float | None = option(
        type=positive_number, metavar="HZ", help="independent samples a second (default: 100)"
    )

    def sigma(self, bounds: trajectories.JointBounds) -> Array | None:
        """Standard deviations per joint as asked for."""
        if isinstance(self.torque_noise, float):
            if not np.isfinite(bounds.torque).all():
                raise InputError(
                    "--torque-noise as a percentage needs a torque limit of every joint: --torque-limits"
                )
            return np.asarray(self.torque_noise * bounds.torque)
        noise = self.torque_noise
        return None if noise is None else np.array(noise * len(bounds.torque) if len(noise) == 1 else noise)


@dataclass(frozen=True)
class GoalOptions(NoiseOptions):
    """Which parameters, by which criterion, beside what is known already."""

    GROUP: ClassVar[str] = "what to learn"

    criterion: trajectories.Kind = option(
        choices=_CRITERIA,
        default="d",
        help="d: information (default); a: relative sigma; cond: condition number; cond-scaled: columns scaled",
    )
    columns: tuple[str, ...] | None = option(
        type=names_list, metavar="NAME,..", help="parameters to be estimated (default: base)"
    )
    parameters: tuple[str, ...] | None = option(
        type=names_list, metavar="NAME,..", help="those that count, for d and a (default: all)"
    )
    payload_only: bool = option(action="store_true", help="the payload's ten, the robot being known")
    data_from: tuple[str, ...] | None = option(
        reads="earlier data",
        action="append",
        metavar="F",
        help="what was learnt before: --npz of identify or payload, or --json of identify (d and a); repeatable",
    )
    data_length: float | None = option(type=positive_number, metavar="S", help="of the recording to come")

    def goal(
        self,
        robot: model.Robot,
        bounds: trajectories.JointBounds,
        reference: Mapping[str, float],
        motion_length: float | None,
    ) -> trajectories.Goal:
        """The goal.

        Args:
            reference: values that standard deviations are relative to.
            motion_length: how long the motion will take [s], where it is known.

        Raises:
            InputError: for earlier recordings that do not fit, or without the length of the next one.
        """
        if self.data_from and self.data_length is None and motion_length is None:
            raise InputError("--data-from needs --data-length: how long will be recorded next?")
        noise, earlier, length = self._noise(bounds), None, self.data_length
        if self.data_from:
            earlier, length = self._earlier(robot, noise), length or motion_length
        return trajectories.Goal(
            self.criterion,
            columns=self.columns,
            payload_only=self.payload_only,
            interest=self.parameters,
            reference=reference if self.criterion == "a" else None,
            noise=noise,
            rate=self.independent_rate or RATE,
            data_length=length,
            earlier=earlier,
        )

    def _noise(self, bounds: trajectories.JointBounds) -> Array | None:
        """Torque noise as asked for, else that of the earlier recordings."""
        noise = self.sigma(bounds)
        if noise is None and self.data_from:
            noise = results.recorded_noise(self.data_from[0])
        if noise is None:
            note("no --torque-noise: 1 N·m (or N) in every joint is assumed")
        return noise

    def _earlier(self, robot: model.Robot, noise: Array | None) -> trajectories.Earlier:
        paths, weighted = self.data_from or (), self.criterion in ("d", "a")
        if weighted and noise is None:
            raise InputError(f"{paths[0]}: carries no weights: give --torque-noise")
        parts = [results.read_information(path, noise if weighted else None) for path in paths]
        if self.payload_only:
            parts = [part.of_payload(model.regressors.payload_columns(robot)) for part in parts]
        columns = parts[0].columns
        for path, information in zip(paths, parts, strict=True):
            if set(information.columns) != set(columns):
                raise InputError(f"{path}: has other columns than {paths[0]}: give files of one model")
        rows = [part.factor[:, [part.columns.index(name) for name in columns]] for part in parts]
        return trajectories.Earlier(columns, np.vstack(rows))
