"""Frozen values as plain words and arrays, and back: what a passport's file holds, and no code among it.

A value becomes a tree of lists, texts and numbers for JSON; arrays go to one vector, of which zeros are left out,
for triangular factors are zeros for the most part.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...estimation.diagnosis.evidence import Sampled
from ...estimation.diagnosis.finding import Finding
from ...estimation.diagnosis.loaded_rows import Scale
from ...estimation.diagnosis.nuisances import Bursts, Nuisance, Tilt
from ...estimation.diagnosis.pull import Pull
from ...estimation.diagnosis.rivals import Rival
from ...estimation.equations.equations import Equations
from ...estimation.equations.leave_one_out import WithoutEach
from ...estimation.equations.shared_torque import SharedTorque
from ...estimation.fit.drive_gains import Gains
from ...estimation.fit.essential import SigmaBound, SigmaRatio
from ...estimation.fit.estimate import Estimate, Fit
from ...estimation.fit.robust import RobustCovariance
from ...estimation.fit.roles import Held
from ...estimation.payload.constant_torques import HeldFriction
from ...estimation.payload.loaded_scale import LoadedScale
from ...estimation.payload.problem import PayloadProblem
from ...estimation.payload.ripple import Wave
from ...estimation.payload.short_motion import Run, ShortMotion
from ...estimation.payload.stand_in import StandIn
from ...estimation.possible.constraints import (
    CentreOfMassInBox,
    InEllipsoid,
    InHull,
    KnownMass,
    MassBounds,
    PossibleBody,
)
from ...model import BaseParameters, Coupling, Drives, Joint, Limits, Pose, Processing, Robot, Spring
from ...model.robot import Links
from ...model.visibility import PayloadVisibility
from .hints import checks
from .passport import Log, PayloadPassport, Recipe, RobotPassport

KINDS: dict[str, type] = {
    kind.__name__: kind
    for kind in (
        *(
            BaseParameters,
            Coupling,
            Drives,
            Joint,
            Limits,
            Links,
            PayloadVisibility,
            Pose,
            Processing,
            Robot,
            Spring,
        ),
        *(Equations, Estimate, Fit, Gains, Held, RobustCovariance, SharedTorque, SigmaBound, SigmaRatio),
        *(HeldFriction, LoadedScale, PayloadProblem, Run, ShortMotion, StandIn, Wave),
        *(CentreOfMassInBox, InEllipsoid, InHull, KnownMass, MassBounds, PossibleBody),
        *(Bursts, Finding, Nuisance, Pull, Rival, Sampled, Scale, Tilt),
        *(Log, Recipe, RobotPassport, PayloadPassport),
    )
}
"""The values that a file may hold, by their names."""
_KIND, _MAP, _ARRAY, _TURNED, _BLOCKS = "kind", "map", "array", "turned", "blocks"
_LARGEST = 1e100
"""Squares of smaller numbers and their sums are finite."""


class Encoder:
    """Takes values apart; collects their arrays."""

    def __init__(self) -> None:
        """No arrays yet."""
        self._arrays: list[Array] = []
        self._places: dict[int, list[int]] = {}
        self._size = 0

    def tree(self, value: Any) -> Any:
        """A value as lists, texts and numbers."""
        if value is None or isinstance(value, bool | str):
            return value
        if isinstance(value, int | float | np.number):
            return _number(value)
        if type(value).__name__ in KINDS:
            return self._fields(value)
        match value:
            case np.ndarray():
                return self._array(value)
            case WithoutEach():
                return {_BLOCKS: [self.tree(block) for block in value.blocks]}
            case Mapping():
                return {_MAP: [[self.tree(key), self.tree(entry)] for key, entry in value.items()]}
            case Sequence():
                return [self.tree(entry) for entry in value]
        raise TypeError(f"{type(value).__name__} has no place in a passport")

    def numbers(self) -> tuple[Array, NDArray[np.uint8]]:
        """The numbers of all arrays that are not zero, and a bit for each number that says whether it is."""
        flat = np.concatenate(
            [np.zeros(0), *(array.ravel("F" if _turned(array) else "C") for array in self._arrays)]
        )
        there = flat != 0.0
        return flat[there], np.packbits(there)

    def _array(self, value: NDArray[Any]) -> Any:
        if value.dtype != np.float64:
            raise TypeError(f"an array of {value.dtype} has no place in a passport")
        if id(value) not in self._places:  # what several values share is written once
            self._places[id(value)] = [self._size, *value.shape]
            self._size += value.size
            self._arrays.append(value)
        return {_TURNED if _turned(value) else _ARRAY: self._places[id(value)]}

    def _fields(self, value: Any) -> Any:
        tree = {name: self.tree(getattr(value, name)) for name in field_names(type(value))}
        blocks = tree.get("leave_one_out")
        if isinstance(value, Equations) and isinstance(blocks, dict):
            for block in blocks[_BLOCKS]:  # named once: there are many of them
                block[_KIND][1]["columns"] = []
        return {_KIND: [type(value).__name__, tree]}


class Decoder:
    """Puts values together again."""

    def __init__(self, numbers: Array, there: NDArray[np.uint8]) -> None:
        """The arrays as ``Encoder.numbers`` gives them."""
        self._flat = np.zeros(8 * there.size)
        self._flat[np.unpackbits(there).astype(bool)] = numbers
        if not np.all(np.abs(self._flat) < _LARGEST):
            raise InputError("holds a number that no equation has")
        self._flat.setflags(write=False)

    def value(self, tree: Any) -> Any:
        """The value of a tree.

        Raises:
            InputError: if it holds what is no value of this version.
        """
        if isinstance(tree, list):
            return tuple(self.value(entry) for entry in tree)
        if not isinstance(tree, dict):
            return tree
        ((word, content),) = tree.items()
        match word:
            case "number":
                return float(content)
            case "array" | "turned":
                start, *shape = content
                order: Literal["C", "F"] = "C" if word == "array" else "F"
                return self._flat[start : start + math.prod(shape)].reshape(shape, order=order)
            case "map":
                return {self.value(key): self.value(entry) for key, entry in content}
            case "blocks":
                return self._blocks(content)
            case "kind":
                return self._made(*content)
        raise InputError(f"holds {word!r}, which this version does not know")

    def _blocks(self, trees: Any) -> WithoutEach[Any]:
        blocks = [self.value(tree) for tree in trees]
        if not all(isinstance(block, Equations) for block in blocks):
            raise InputError("holds blocks that are no equations")
        return WithoutEach(blocks)

    def _made(self, name: str, fields: Mapping[str, Any]) -> Any:
        if name not in KINDS:
            raise InputError(f"holds a {name!r}, which this version does not know")
        values = {key: self.value(tree) for key, tree in fields.items()}
        fits = checks(KINDS[name])
        for key, value in values.items():
            if not fits[key](value):
                raise InputError(f"holds a {name} whose {key} is none")
        instance = KINDS[name](**values)
        if isinstance(instance, Equations) and isinstance(instance.leave_one_out, WithoutEach):
            blocks = [
                dataclasses.replace(block, columns=instance.columns) for block in instance.leave_one_out.blocks
            ]
            instance = dataclasses.replace(instance, leave_one_out=WithoutEach(blocks))
        return instance


def _number(value: Any) -> Any:
    if isinstance(value, int | np.integer):
        return int(value)
    return float(value) if math.isfinite(value) else {"number": repr(float(value))}


def _turned(array: NDArray[Any]) -> bool:
    """Whether columns lie together in memory; kept so, that sums round as they did."""
    return array.flags.f_contiguous and not array.flags.c_contiguous


def field_names(kind: type) -> tuple[str, ...]:
    """Names of a value's fields in their order."""
    if dataclasses.is_dataclass(kind):
        return tuple(field.name for field in dataclasses.fields(kind))
    return tuple(getattr(kind, "_fields", getattr(kind, "__struct_fields__", ())))
