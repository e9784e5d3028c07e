"""Reads exported payloads with Drake and OpenUSD, which are too large for the tests, and prints what differs.

    pip install drake usd-core; python benchmarks/export_formats.py [--bodies 200]

The deviation is the largest of: mass, relative; centre of mass [m]; inertia about it over its trace. Bodies at the
edge of the possible (two or three point masses) show the 1e-6 of the trace that the export adds to them.
"""

import argparse
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from dynident.apps.export.controllers import FORMATS
from dynident.apps.export.load import ControllerLoad
from dynident.common.arrays import Array
from dynident.model import InertialParameters

Read = Callable[[str], tuple[float, Array, Array]]


def spatial(inertia: Any) -> tuple[float, Array, Array]:
    """Mass, centre of mass and inertia about it of Drake's spatial inertia."""
    assert inertia.IsPhysicallyValid()
    com = inertia.get_com()
    return inertia.get_mass(), com, inertia.Shift(com).CalcRotationalInertia().CopyToFullMatrix3()


def by_drake(extension: str) -> Read:
    def read(text: str) -> tuple[float, Array, Array]:
        from pydrake.multibody.parsing import Parser
        from pydrake.multibody.plant import MultibodyPlant

        plant = MultibodyPlant(0.0)
        Parser(plant).AddModelsFromString(text, extension)
        return spatial(plant.GetBodyByName("payload").default_spatial_inertia())

    return read


def by_usd(text: str) -> tuple[float, Array, Array]:
    from pxr import Usd, UsdGeom, UsdPhysics
    from scipy.spatial.transform import Rotation

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "payload.usda"
        path.write_text(text, encoding="utf-8")
        stage = Usd.Stage.Open(str(path))
        api = UsdPhysics.MassAPI(stage.GetDefaultPrim())
        unit = UsdGeom.GetStageMetersPerUnit(stage)
        turn = api.GetPrincipalAxesAttr().Get()
        R = Rotation.from_quat([*turn.imaginary, turn.real]).as_matrix()
        moments = np.array(api.GetDiagonalInertiaAttr().Get()) * unit**2
        com = np.array(api.GetCenterOfMassAttr().Get()) * unit
        return float(api.GetMassAttr().Get()), com, R @ np.diag(moments) @ R.T


READERS: dict[str, tuple[str, Read]] = {
    "urdf": ("pydrake", by_drake("urdf")),
    "sdf": ("pydrake", by_drake("sdf")),
    "mjcf": ("pydrake", by_drake("xml")),
    "usd": ("pxr", by_usd),
}


def random_body(draw: np.random.Generator, points: int) -> InertialParameters:
    masses, places = draw.uniform(0.1, 5.0, points), draw.uniform(-0.4, 0.4, (points, 3))
    com = masses @ places / masses.sum()
    inertia = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, places - com, strict=True))
    return InertialParameters.from_com(masses.sum(), com, np.asarray(inertia))


def deviation(read: Read, name: str, body: InertialParameters) -> float:
    load = ControllerLoad(body, "tool0", "benchmark", "use", meters_per_unit=0.01 if name == "usd" else 1.0)
    mass, com, inertia = read(FORMATS[name].text(load))
    apart = np.abs(inertia - body.inertia_com).max() / np.trace(body.inertia_com)
    return max(abs(mass / body.mass - 1.0), float(np.abs(com - body.com).max()), float(apart))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--bodies", type=int, default=200)
    bodies = parser.parse_args().bodies
    for name, (library, read) in READERS.items():
        if find_spec(library) is None:
            print(f"{name:6} {library} is not installed")
            continue
        draw = np.random.default_rng(0)
        full = max(deviation(read, name, random_body(draw, 6)) for _ in range(bodies))
        edge = max(deviation(read, name, random_body(draw, 2 + k % 2)) for k in range(bodies))
        print(f"{name:6} by {library:8} largest deviation {full:.1e}, at the edge of the possible {edge:.1e}")


if __name__ == "__main__":
    main()
