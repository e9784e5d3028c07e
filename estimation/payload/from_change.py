"""Method 2: the change of the base parameters under load, (24)-(28) for any robot."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import decomposed
from ...model.drives import FRICTION, parameter_kind
from ...model.regressors import payload_columns
from ..equations.equations import PAYLOAD, Equations
from ..fit.drive_gains import motor_torques
from ..fit.estimate import Estimate, fit
from ..fit.least_squares import weighted
from ..fit.linear_problem import gain_sensitivity, left_out
from .problem import PayloadProblem
from .result import frame_change, in_payload_frame

_DRIVE = ("IA", *FRICTION)


class _Step(NamedTuple):
    """Generalised least squares of G x = change: ``x``, its ``covariance``, ``inverse``: x = inverse @ change."""

    x: Array
    covariance: Array
    inverse: Array


@dataclass(frozen=True, eq=False)
class ChangeOfParameters:
    """Two identifications of the robot, without and with payload.

    Base parameters change by Delta chi = G_L chi_L, where G_L (N_b x 10) holds the last link's columns of the
    grouping matrix; on the RX90 its rows are (25)-(28). Solved by least squares weighted by the covariance of
    Delta chi. Drive parameters take no part: friction may change under load.
    """

    problem: PayloadProblem
    before: Estimate

    def solved(self, weights: Array | None = None) -> Estimate:
        """The payload's ten parameters."""
        after = weighted(self._loaded, weights)
        step = self._step(after)
        return Estimate(
            names=PAYLOAD,
            values=step.x,
            covariance=step.covariance,
            degrees_of_freedom=min(self.before.degrees_of_freedom, after.degrees_of_freedom),
            fit=fit(
                in_payload_frame(self.problem.robot, self.problem.loaded),
                np.concatenate([self.before.values, step.x]),
            ),
            weights=after.weights,
            gain_sensitivity=self._gain_sensitivity(after, step),
        )

    def values(self, weights: Array) -> Array:
        """The ten for given weights of the loaded joints."""
        return self._step(weighted(self._loaded, weights)).x

    def without_blocks(self, weights: Array, pairs: Sequence[tuple[int, int]]) -> Array:
        """The ten without a block of the loaded and one of the unloaded recordings, -1 for none."""
        assert self.problem.unloaded is not None
        columns = self.problem.base.columns
        places = [columns.index(name) for name in self._inertial]
        after = left_out(self._loaded, columns, weights)
        before = left_out(self.problem.unloaded, columns, self.before.weights)
        (chi_a, C_a), (chi_b, C_b) = (
            (part.values[:, places, 0], part.variance[:, :, None] * part.covariance[:, places][:, :, places])
            for part in (before, after)
        )
        return np.array([_generalised(self._map, chi_b[b] - chi_a[a], C_a[a] + C_b[b]).x for b, a in pairs])

    def lasting(self, weights: Array) -> Array:
        """Blocks of time hold all recordings that it uses."""
        return np.zeros((len(PAYLOAD), len(PAYLOAD)))

    def remembered(self, weights: Array, inflation: Sequence[float]) -> Array:
        """Covariance where errors remember: the formula's, by the middle joint's memory."""
        covariance = self._step(weighted(self._loaded, weights)).covariance
        return np.asarray(float(np.median(inflation)) * covariance)

    @cached_property
    def _loaded(self) -> Equations:
        return self.problem.loaded.select(self.problem.base.columns)

    @cached_property
    def _inertial(self) -> tuple[str, ...]:
        return tuple(name for name in self.problem.base.columns if parameter_kind(name) not in _DRIVE)

    @cached_property
    def _map(self) -> Array:
        """G_L: how the inertial base parameters change with the payload's ten, in the payload's frame."""
        columns, robot = self.problem.base.columns, self.problem.robot
        change = payload_map(self.problem)[[columns.index(name) for name in self._inertial]]
        return change if robot.flange.is_identity else change @ frame_change(robot.flange)

    def _step(self, after: Estimate) -> _Step:
        chi_a, C_a = self.before.select(self._inertial)
        chi_b, C_b = after.select(self._inertial)
        return _generalised(self._map, chi_b - chi_a, C_a + C_b)

    def _gain_sensitivity(self, after: Estimate, step: _Step) -> Array:
        """Derivatives of the ten by the motors' errors, joints' weights fixed.

        Beside the parameters, the variances of both identifications change, and with them what each counts for:
        with x = (G'C^-1G)^-1 G'C^-1 d, dx = inverse (dd - dC C^-1 (d - G x)).
        """
        assert self.problem.unloaded is not None
        places = [self.problem.base.columns.index(name) for name in self._inertial]
        chi_a, C_a = self.before.select(self._inertial)
        chi_b, C_b = after.select(self._inertial)
        rest = chi_b - chi_a - self._map @ step.x
        change = np.zeros((len(rest), self.problem.robot.n))
        pull = np.linalg.solve(C_a + C_b, rest)
        for equations, estimate, C, sign in (
            (self.problem.unloaded, self.before, C_a, -1.0),
            (self._loaded, after, C_b, 1.0),
        ):
            change += sign * gain_sensitivity(equations, estimate.weights)[places]
            change -= np.outer(C @ pull, _growth(equations, estimate))
        return np.asarray(step.inverse @ change)


def from_change(problem: PayloadProblem) -> ChangeOfParameters:
    """Method 2 on a problem with ``unloaded``."""
    if problem.bare is None:
        raise InputError("method 2 needs a recording without payload")
    return ChangeOfParameters(problem, problem.bare)


def payload_map(problem: PayloadProblem) -> Array:
    """G_L: how the base parameters change with the payload's ten in frame n; N_b x 10."""
    return problem.base.effect_of(payload_columns(problem.robot))


def _growth(equations: Equations, estimate: Estimate) -> Array:
    """Relative derivatives of the residual's variance by the motors' errors, shape (n,)."""
    x = np.append(-estimate.values, 1.0)
    errors = [w * factor @ x for w, factor in zip(estimate.weights, equations.factors, strict=True)]
    size = max(sum(float(error @ error) for error in errors), np.finfo(float).tiny)
    grown = [
        sum(
            float(error @ (w * torque))
            for error, w, torque in zip(errors, estimate.weights, motor_torques(equations, j), strict=True)
        )
        for j in range(len(equations.factors))
    ]
    return 2.0 * np.array(grown) / size


def _generalised(G: Array, change: Array, C: Array) -> _Step:
    """Generalised least squares of G x = change with covariance C."""
    scale = np.sqrt(np.diag(C))
    L = np.linalg.cholesky(C / np.outer(scale, scale))
    parts = decomposed(np.asarray(np.linalg.solve(L, G / scale[:, None])))
    if parts.null.size:
        raise InputError("the base parameters of this robot do not show all ten parameters of a payload")
    inverse = np.linalg.solve(L.T, parts.inverse.T).T / scale
    return _Step(parts.solution(np.asarray(np.linalg.solve(L, change / scale))), parts.covariance, inverse)
