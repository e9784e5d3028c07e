"""Reads a payload from TOML."""

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any, cast

import numpy as np
from msgspec import Meta, defstruct, structs

from ...common.errors import InputError
from ...common.schema import Table, at, convert, naming, read_toml
from ..inertia import InertialParameters
from ..robot import INERTIAL

_Bounded = Annotated[float, Meta(ge=-1e6, le=1e6)]
Three = tuple[_Bounded, _Bounded, _Bounded]
Six = tuple[_Bounded, _Bounded, _Bounded, _Bounded, _Bounded, _Bounded]

TenTable = cast(
    type[Table],
    defstruct("TenTable", [(kind, _Bounded, 0.0) for kind in INERTIAL], bases=(Table,), frozen=True),
)
"""Table of Khalil's ten about the frame's origin."""


class BodyTable(Table, frozen=True):
    """Table of a body: centre of mass, and the entries Ixx, Ixy, Ixz, Iyy, Iyz, Izz of its inertia about it."""

    mass: _Bounded = 0.0
    com: Three | None = None
    inertia_com: Six | None = None

    def body(self) -> InertialParameters:
        """Make the body; what is missing is zero."""
        return InertialParameters.from_com(self.mass, self.com or (0.0,) * 3, self.inertia_com or (0.0,) * 6)


def read_payload(path: str | Path) -> InertialParameters:
    """Read a payload, in the robot's payload frame.

    The file, or its table [payload], holds either Khalil's ten about the frame's origin (``XX`` to ``M``; what is
    missing is zero), or ``mass`` [kg], ``com`` [m] (three numbers) and ``inertia_com`` [kg m^2] about the centre of
    mass (Ixx, Ixy, Ixz, Iyy, Iyz, Izz, entries of the matrix).

    Raises:
        InputError: if the file cannot be used, or no body has such parameters.
    """
    data = read_toml(path, dict[str, Any])
    with naming(path), at("payload") if "payload" in data else nullcontext():
        own = convert(data.get("payload", data), dict[str, Any])
        if set(BodyTable.__struct_fields__) & set(own):
            body = convert(own, BodyTable).body()
        else:
            body = InertialParameters(np.array(structs.astuple(convert(own, TenTable))))
    if not body.physically_consistent:
        raise InputError(
            f"{path}: no body has such parameters (smallest eigenvalue of the pseudo-inertia "
            f"{body.min_pseudo_inertia_eigenvalue:.3g}): check the signs, and about which point the inertia is"
        )
    return body
