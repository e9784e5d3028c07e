"""Estimates: names, values, covariance, how well the torques are explained, and what errors of drive gains do.

The torque of motor j is 1 + e_j times its nominal one, always. No residual shows such an error, for all recordings
of an arm share it: it is an uncertainty to be given. Motor j acts on joint j; of coupled drives k on j and k (9).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Literal, NamedTuple

import numpy as np
from msgspec import Meta, field
from msgspec.structs import force_setattr
from numpy.typing import ArrayLike

from ...common import Array, Brief, Document, InputError, freeze_fields
from ...common.linear import is_covariance
from ...model import Recording, Robot
from ..equations.equations import Equations
from .covariance import RobustCovariance, student95


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Brief):
    """Fit of a model to torques."""

    error_norms: Array  # per joint, norm of Y_j - W_j chi [N·m or N]
    torque_norms: Array  # per joint, norm of Y_j
    rows: tuple[int, ...]  # per joint, number of equations; zeros or none of values without equations

    def __post_init__(self) -> None:
        freeze_fields(self, error_norms=(len(self.rows),), torque_norms=(len(self.rows),))

    @property
    def rms(self) -> Array:
        """Root mean square of each joint's error [N·m or N], shape (n,)."""
        return np.asarray(self.error_norms / np.sqrt(np.maximum(self.rows, 1)))

    @property
    def relative(self) -> float:
        """Norm of the error over norm of the torque, all joints; nan without any torque."""
        torque = float(np.linalg.norm(self.torque_norms))
        return float(np.linalg.norm(self.error_norms)) / torque if torque > 0.0 else float("nan")

    @property
    def relative_per_joint(self) -> Array:
        """Norm of the error over norm of the torque by joint, shape (n,); nan for a joint without equations."""
        torque = np.where(self.torque_norms > 0.0, self.torque_norms, np.nan)
        return np.asarray(self.error_norms / torque)


def fit(problem: Equations, values: Array) -> Fit:
    """Compare parameters with a problem's torques; for cross validation, with another recording's."""
    return Fit(problem.error_norms(values), problem.torque_norms, problem.rows)


class Parameter(NamedTuple):
    """Parameter as tables show it: value, standard deviation and the ends of its 95 % interval, SI units.

    ``sigma``: the larger of the formula's (19) and the robust one, with the errors of the drive gains.
    """

    value: float
    sigma: float
    low: float
    high: float


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Brief):
    """Parameters with their covariance.

    Attributes:
        names: names of the parameters, c.
        values: estimated values, SI units, shape (c,).
        covariance: of the estimation error by (17)-(19), for white torque noise; c x c.
        degrees_of_freedom: independent equations minus parameters.
        fit: how well the torques of the data are explained.
        weights: per joint, the weights that were used [1/(N·m) or 1/N].
        robust: covariance that holds for autocorrelated noise as well, where it was asked for.
        gain_sensitivity: derivatives by the relative error of each motor's torque, c x n, where they were computed.
        gain_covariance: of those errors, n x n; None where drive gains are taken as exact. Not part of
            ``covariance`` and ``robust``: what else is made of the same drives has the same errors.

    >>> Estimate.from_values(["FV1"], [29.3], [0.01]).sigma
    array([0.1])
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    degrees_of_freedom: float
    fit: Fit
    weights: Array
    robust: RobustCovariance | None = None
    gain_sensitivity: Array | None = None
    gain_covariance: Array | None = None

    def __post_init__(self) -> None:
        c, n = len(self.names), len(self.fit.rows)
        if self.robust is not None and self.robust.covariance.shape != (c, c):
            raise ValueError(f"robust covariance must be {c} x {c}, got {self.robust.covariance.shape}")
        if self.gain_covariance is not None and self.gain_sensitivity is None:
            raise ValueError("gain_covariance needs gain_sensitivity")
        freeze_fields(self, values=(c,), covariance=(c, c), weights=(None,))
        freeze_fields(self, gain_sensitivity=(c, n), gain_covariance=(n, n))

    @staticmethod
    def from_values(
        names: Sequence[str], values: ArrayLike, covariance: ArrayLike, degrees_of_freedom: float = float("inf")
    ) -> Estimate:
        """Make an estimate of one's own: a robot's base parameters, or a payload's ten in the order of ``PAYLOAD``.

        Args:
            covariance: of the errors, c x c; or their variances, shape (c,).

        Raises:
            InputError: if they do not fit each other.
        """
        x, C, none = np.asarray(values, dtype=float), np.asarray(covariance, dtype=float), np.zeros(0)
        C = np.diag(C) if C.ndim == 1 else C
        if x.shape != (len(names),) or C.shape != (len(names),) * 2:
            raise InputError(f"{len(names)} names, values {x.shape} and covariance {C.shape} do not fit each other")
        by_gains = np.zeros((len(names), 0))  # their errors are in the covariance, as far as they are known
        return Estimate(tuple(names), x, C, degrees_of_freedom, Fit(none, none, ()), none, None, by_gains)

    @cached_property
    def sigma(self) -> Array:
        """Standard deviations (20), shape (c,)."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def relative_sigma_percent(self) -> Array:
        """Relative standard deviations (21) in percent, shape (c,); infinite where the value is zero."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(100.0 * self.sigma / np.abs(self.values))

    @cached_property
    def interval95(self) -> Array:
        """Nominal 95 % intervals by Student's t, c x 2."""
        return self._interval(self)

    def _interval(self, errors: Estimate | RobustCovariance, by_gains: Array | None = None) -> Array:
        half = student95(errors.degrees_of_freedom) * np.hypot(errors.sigma, 0.0 if by_gains is None else by_gains)
        return np.column_stack([self.values - half, self.values + half])

    @property
    def sigma_robust(self) -> Array | None:
        """Standard deviations that hold for autocorrelated noise, shape (c,), where they were asked for."""
        return self.robust.sigma if self.robust is not None else None

    @cached_property
    def larger_sigma(self) -> Array:
        """The larger of the formula's and the robust standard deviation of each parameter, shape (c,)."""
        return self.sigma if self.robust is None else np.maximum(self.sigma, self.robust.sigma)

    @cached_property
    def robust_interval95(self) -> Array | None:
        """95 % intervals that hold for autocorrelated noise, c x 2, where they were asked for."""
        return self._interval(self.robust) if self.robust is not None else None

    @property
    def covariance_by_gains(self) -> Array | None:
        """Covariance by errors of the drive gains alone, c x c; None where gains are taken as exact."""
        S, C = self.gain_sensitivity, self.gain_covariance
        return S @ C @ S.T if S is not None and C is not None else None

    @cached_property
    def sigma_by_gains(self) -> Array | None:
        """Standard deviations by errors of the drive gains alone, shape (c,)."""
        C = self.covariance_by_gains
        return np.sqrt(np.maximum(np.diag(C), 0.0)) if C is not None else None

    @cached_property
    def total_sigma(self) -> Array:
        """``larger_sigma`` and, where they are not taken as exact, errors of the drive gains, shape (c,)."""
        by_gains = self.sigma_by_gains
        return self.larger_sigma if by_gains is None else np.hypot(self.larger_sigma, by_gains)

    @cached_property
    def interval95_with_gains(self) -> Array | None:
        """95 % intervals of the robust (else the formula's) and the gains' covariance together, c x 2."""
        by_gains = self.sigma_by_gains
        return None if by_gains is None else self._interval(self.robust or self, by_gains)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters as tables show them, c."""
        ends = self._interval(self.robust or self, self.sigma_by_gains)
        return tuple(Parameter(*row) for row in np.column_stack([self.values, self.total_sigma, ends]).tolist())

    def __getitem__(self, name: str) -> float:
        """Value of one parameter."""
        return float(self.values[self.names.index(name)])

    @property
    def noise(self) -> Array:
        """Torque noise of each joint [N·m or N], shape (n,): its errors, or by its weight if it has no rows."""
        return np.where(self.fit.rms > 0.0, self.fit.rms, 1.0 / self.weights)

    def part(self, names: Sequence[str]) -> Estimate:
        """Take some of the parameters, in the order given."""
        return self.mapped(np.eye(len(self.names))[[self.names.index(name) for name in names]], names)

    def mapped(self, T: Array, names: Sequence[str] | None = None, shift: Array | None = None) -> Estimate:
        """Transform to other parameters T x + shift, with all their covariances.

        Args:
            T: k x c.
            names: of the k; by default they keep their own.
            shift: shape (k,); none by default.
        """
        robust, S = self.robust, self.gain_sensitivity
        return replace(
            self,
            names=self.names if names is None else tuple(names),
            values=T @ self.values + (0.0 if shift is None else shift),
            covariance=T @ self.covariance @ T.T,
            robust=None if robust is None else replace(robust, covariance=T @ robust.covariance @ T.T),
            gain_sensitivity=None if S is None else T @ S,
        )


def error_model(estimate: Estimate, gains: Gains | None = None) -> Estimate:
    """Give an estimate the covariance that its errors really have.

    C = S C_formula S + C_gains with S = diag(sigma_robust / sigma): from a few dozen blocks the jackknife knows
    standard deviations well, ten directions not; the correlations are the formula's. Without robust standard
    deviations S = 1. The robot's own estimate brings its errors of the drive gains itself.

    Raises:
        InputError: if the gains are another number of joints', or what the estimate owes to them is not known.
    """
    C, dof, robust = estimate.covariance, estimate.degrees_of_freedom, estimate.robust
    if robust is not None:
        ratio = robust.sigma / np.where(estimate.sigma > 0.0, estimate.sigma, 1.0)
        C, dof = C * np.outer(ratio, ratio), float(robust.degrees_of_freedom)
    if gains is not None:
        S = estimate.gain_sensitivity
        if S is None:
            advice = "identify the robot again"
            raise InputError(f"the robot's parameters do not tell how they depend on the drive gains: {advice}")
        C = C + S @ gains.covariance(S.shape[1]) @ S.T
    if (by_gains := estimate.covariance_by_gains) is not None:
        C = C + by_gains
    return replace(estimate, covariance=C, degrees_of_freedom=dof, robust=None, gain_covariance=None)


USUAL: Mapping[str, float] = {"motor": 0.02, "link": 0.01}
"""Standard deviation of gains of which nothing is said: of torques by motors, and by sensors behind the gear."""
Fingerprints = Mapping[Literal["unloaded", "loaded"], tuple[str, ...]]
"""Fingerprints of the recordings that drive gains were identified from."""


_Share = Annotated[float, Meta(ge=0.0, lt=1.0)]


class Gains(Document, frozen=True, omit_defaults=True):
    """Drive gains and how sure they are: standard deviations of the relative errors e_j of the motors' torques.

    Attributes:
        per_joint: of the own error of each joint's motor (0.02 for 2 %); one number stands for all joints.
        common: of an error that all joints share, as from one current sensor or supply.
        identified: covariance of gains that were identified, n x n, which comes on top; empty where they were not.
        recordings: fingerprints of those they were identified from, without ("unloaded") and with payload
            ("loaded"); empty where they were not read from a log.
        mass: of the payload with which those were [kg]; None where it is not known.
        notes: what else a reader must know of them, one line each.
        assumed: whether nothing is said of them, so that the usual errors are taken.
    """

    per_joint: Sequence[_Share] = field(default_factory=lambda: (0.0,))
    common: _Share = field(default_factory=lambda: 0.0)
    identified: Sequence[Sequence[float]] = ()
    recordings: Fingerprints = field(default_factory=dict)
    mass: float | None = None
    notes: tuple[str, ...] = ()
    assumed: bool = False

    def __post_init__(self) -> None:
        force_setattr(self, "identified", tuple(tuple(float(v) for v in row) for row in self.identified))
        force_setattr(self, "per_joint", tuple(float(sigma) for sigma in self.per_joint))
        if not any(self.recordings.values()):
            force_setattr(self, "recordings", {})
            force_setattr(self, "mass", None)
        sigmas = (*self.per_joint, self.common)
        if not self.per_joint or not all(0.0 <= sigma < 1.0 for sigma in sigmas):
            values = ", ".join(f"{sigma:g}" for sigma in sigmas)
            raise InputError(f"relative errors of drive gains {values}: give standard deviations from 0 to below 1")
        rows = self.identified
        if rows and not (all(len(row) == len(rows) for row in rows) and is_covariance(np.array(rows))):
            raise InputError("the identified gains' matrix is no covariance: identify them again")

    def covariance(self, n: int) -> Array:
        """Covariance of e_1 .. e_n, n x n.

        Raises:
            InputError: if there are neither one nor n numbers.
        """
        if len(self.per_joint) not in (1, n):
            raise InputError(f"{len(self.per_joint)} uncertainties of drive gains for {n} joints: give 1 or {n}")
        known = np.array(self.identified) if self.identified else np.zeros((n, n))
        if known.shape != (n, n):
            raise InputError(f"a covariance of {len(known)} drive gains for {n} joints: identify gains of this arm")
        return np.asarray(np.diag(np.broadcast_to(np.square(self.per_joint), n)) + self.common**2 + known)

    def says_as(self, other: Gains, n: int) -> bool:
        """True if both are one uncertainty of n gains, however it is written."""
        return np.allclose(self.covariance(n), other.covariance(n), rtol=1e-9, atol=0.0)

    def reused(self, loaded: Sequence[Recording], unloaded: Sequence[Recording]) -> tuple[str, ...]:
        """Note recordings that the gains were identified from and that are used again, one line each.

        Args:
            loaded: with the payload that is asked for.
            unloaded: without, or the robot's own.
        """
        with_load = self.recordings.get("loaded", ())
        again = [recording.source for recording in loaded if recording.fingerprint in with_load]
        if again:
            mass = f", {self.mass:g} kg as given then" if self.mass is not None else ""
            return (
                f"These gains come from this same pair ({', '.join(dict.fromkeys(again))}{mass}): the mass is "
                "what was typed in, it confirms nothing. The intervals take the gains' errors and the recordings' "
                "for unrelated, which they are not. Record another payload.",
            )
        every = (*self.recordings.get("unloaded", ()), *with_load)
        shared = [recording.source for recording in (*unloaded, *loaded) if recording.fingerprint in every]
        how = "identified from it too; the intervals take its noise for unrelated to the gains' errors."
        return (f"{', '.join(dict.fromkeys(shared))}: the gains were {how}",) * bool(shared)


def usual_gains(robot: Robot, recordings: Sequence[Recording]) -> Gains | None:
    """Errors of gains of which a user says nothing: what recordings say, else 2 % a motor and 1 % a torque sensor.

    None where all recordings say that their torques are exact.
    """
    usual = USUAL["motor" if any(recording.gains for recording in recordings) else robot.drives.side]
    stated = [recording.gain_sigma for recording in recordings]
    known = max((sigma for sigma in stated if sigma is not None), default=0.0)
    assumed = known < usual and (None in stated or not stated)
    sigma = usual if assumed else known
    return Gains((sigma,), assumed=assumed) if sigma else None


def fingerprints(unloaded: Sequence[Recording], loaded: Sequence[Recording]) -> Fingerprints:
    """Fingerprints of recordings without and with the known payload."""
    without, with_load = (tuple(r.fingerprint for r in group if r.fingerprint) for group in (unloaded, loaded))
    return {"unloaded": without, "loaded": with_load}
