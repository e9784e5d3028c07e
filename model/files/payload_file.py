"""Reads a payload from TOML."""

import math
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any, cast

import numpy as np
from msgspec import Meta, defstruct, structs

from ...common.errors import InputError
from ...common.schema import Table, at, convert, naming, read_toml
from ..inertia import INERTIAL, InertialParameters
from ..pose import check_metres

_Bounded = Annotated[float, Meta(ge=-1e6, le=1e6)]
Three = tuple[_Bounded, _Bounded, _Bounded]
Six = tuple[_Bounded, _Bounded, _Bounded, _Bounded, _Bounded, _Bounded]

TenTable = cast(
    type[Table],
    defstruct("TenTable", [(kind, _Bounded, 0.0) for kind in INERTIAL], bases=(Table,), frozen=True),
)
"""Table of Khalil's ten about the frame's origin."""
_WIDEST = 3.0  # m: radius of gyration that no payload has
_NARROWEST = 1e-3  # m of a mass of 1 kg; a ball of gold has 0.02


class BodyTable(Table, frozen=True):
    """Table of a body: centre of mass, and the entries Ixx, Ixy, Ixz, Iyy, Iyz, Izz of its inertia about it."""

    mass: _Bounded = 0.0
    com: Three | None = None
    inertia_com: Six | None = None

    def __post_init__(self) -> None:
        check_metres(self.com or (0.0,), "com")
        xx, _, _, yy, _, zz = self.inertia_com or (0.0,) * 6
        radius = math.sqrt(max(xx + yy + zz, 0.0) / 2.0 / self.mass) if self.mass > 0.0 else 0.0
        fault = f"with this inertia_com a mass of {self.mass:g} kg "
        if radius >= _WIDEST:
            fault += f"would spread over {radius:.3g} m"
            raise ValueError(f"{fault}: give inertia_com in kg m^2 (1 kg mm^2 is 1e-6, 1 g mm^2 is 1e-9)")
        if 0.0 < radius < self.mass ** (1.0 / 3.0) * _NARROWEST:
            fault += f"would fit within {1e3 * radius:.2g} mm, denser than any metal"
            raise ValueError(f"{fault}: give mass in kg (1 g is 0.001) and inertia_com in kg m^2")

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
        if own and not set(INERTIAL) & set(own):
            body = convert(own, BodyTable).body()
        else:
            body = InertialParameters(np.array(structs.astuple(convert(own, TenTable))))
            if body.mass > 0.0:
                check_metres(body.com, "first moments over the mass")
    if not body.physically_consistent:
        raise InputError(
            f"{path}: no body has such parameters (smallest eigenvalue of the pseudo-inertia "
            f"{body.min_pseudo_inertia_eigenvalue:.3g}): check the signs, and about which point the inertia is"
        )
    return body
