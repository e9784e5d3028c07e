"""Base parameters: combinations of standard parameters that torques determine, and their regressors (13)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import casadi as ca
import numpy as np

from ...common import Array, Brief, frozen_array
from ..regressors import regressor
from ..robot import Robot

_ROUNDING = 1e-10  # factor in a grouping below which it is rounding


@dataclass(frozen=True, eq=False, repr=False)
class BaseParameters(Brief):
    """The minimal parameters chi of (13).

    Attributes:
        standard: names of the standard parameters, N_s.
        chosen: positions in ``standard`` of those that stand for a base parameter, N_b, rising.
        grouping: G, N_b x N_s: base parameters = G @ standard parameters, and W_s = W_base @ G.
        decided_by: what found them.
        expressions: each base parameter written with the robot's own lengths, "D3^2*(M3+M4) + ZZ1", N_b texts;
            empty where nothing symbolic is known.
    """

    standard: tuple[str, ...]
    chosen: tuple[int, ...]
    grouping: Array
    decided_by: Literal["closed form", "QR"] = "QR"
    expressions: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        shape = (len(self.chosen), len(self.standard))
        exact = np.where(np.abs(self.grouping) < _ROUNDING, 0.0, self.grouping)
        object.__setattr__(self, "grouping", frozen_array(exact, shape, "grouping"))
        if self.expressions and len(self.expressions) != len(self.chosen):
            raise ValueError(f"{len(self.expressions)} expressions for {len(self.chosen)} base parameters")

    @property
    def columns(self) -> tuple[str, ...]:
        """Standard parameters whose columns make up W_base, N_b names ("XX2")."""
        return tuple(self.standard[k] for k in self.chosen)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters, with R where others are grouped in ("XX2R")."""
        grouped = (np.abs(self.grouping) > 0).sum(axis=1) > 1
        return tuple(f"{name}R" if more else name for name, more in zip(self.columns, grouped, strict=True))

    @property
    def unidentifiable(self) -> tuple[str, ...]:
        """Standard parameters without any effect on the torques."""
        effect = np.abs(self.grouping).sum(axis=0)
        return tuple(name for name, size in zip(self.standard, effect, strict=True) if size == 0.0)

    @property
    def eliminated(self) -> tuple[str, ...]:
        """Standard parameters that stand for no base parameter: grouped into others or without effect."""
        return tuple(name for name in self.standard if name not in self.columns)

    def groupings(self, symbolic: bool = False) -> tuple[str, ...]:
        """Write each base parameter as a sum: "XX2R = XX2 - YY2 - 0.2025 M3".

        Args:
            symbolic: with the robot's own lengths instead: "XX2R = -D3^2*(M3+M4) + XX2 - YY2".

        Raises:
            ValueError: if symbolic text is asked for and there is none.
        """
        if symbolic:
            if not self.expressions:
                raise ValueError(
                    f"base parameters decided by {self.decided_by} have no symbolic text: "
                    "use closed_form_base_parameters"
                )
            return tuple(f"{name} = {text}" for name, text in zip(self.names, self.expressions, strict=True))
        return tuple(f"{name} = {text}" for name, text in zip(self.names, self.sums(), strict=True))

    def sums(self, digits: int = 6) -> tuple[str, ...]:
        """Write what each base parameter is: "XX2 - YY2 - 0.2025 M3"."""
        rows = zip(self.chosen, self.grouping, strict=True)
        return tuple(
            sum_text(self.standard[k], self.standard, np.where(np.arange(len(row)) == k, 0.0, row), digits)
            for k, row in rows
        )

    def value(self, parameters: Mapping[str, float]) -> Array:
        """Evaluate the base parameters of a robot with the given standard parameters, shape (N_b,).

        Raises:
            KeyError: if a standard parameter is missing.
        """
        return np.asarray(self.grouping @ np.array([parameters[name] for name in self.standard]))

    def effect_of(self, columns: tuple[str, ...]) -> Array:
        """Derivatives of the base parameters by some standard parameters, N_b x ``len(columns)``.

        With the last link's ten it is the map from a payload to base parameters behind (25)-(28).
        """
        return self.grouping[:, [self.standard.index(name) for name in columns]]


def sum_text(first: str, names: Sequence[str], factors: Array, digits: int = 6) -> str:
    """Write a sum of parameters, the first one with a factor of 1: "XX2 - YY2 - 0.2025 M3"."""
    text = first
    for name, factor in zip(names, factors.tolist(), strict=True):
        if factor:
            size = "" if abs(abs(factor) - 1.0) < 1e-9 else f"{abs(factor):.{digits}g} "
            text += f" {'-' if factor < 0.0 else '+'} {size}{name}"
    return text


def base_regressor(robot: Robot, base: BaseParameters) -> ca.Function:
    """``base_regressor(q, qd, qdd) -> Phi``, n x N_b, columns as ``base.columns`` (13)."""
    return regressor(robot, base.columns, "base_regressor")
