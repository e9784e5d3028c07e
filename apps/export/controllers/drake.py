"""Drake: a ``SpatialInertia`` in Python.

SpatialInertia(mass, p_PScm_E, G_SP_E) takes the unit inertia about the frame's origin P, not about the centre of
mass: here inertia about the flange's origin over the mass. UnitInertia(Ixx, Iyy, Izz, Ixy, Ixz, Iyz), products
with the negated sign (Ixy = -integral of x y dm). Source: drake.mit.edu/doxygen_cxx, SpatialInertia, UnitInertia,
RotationalInertia.
"""

from ....model import InertialParameters
from ...numbers import exact, six
from .form import ControllerFormat
from .load import ControllerLoad


def _write(load: ControllerLoad) -> str:
    about_origin = InertialParameters.from_com(load.mass, load.com, load.inertia).inertia
    return f"""from pydrake.multibody.tree import SpatialInertia, UnitInertia

payload = SpatialInertia(
    mass={exact(load.mass)},
    p_PScm_E=[{exact(load.com, ", ")}],
    G_SP_E=UnitInertia({exact(six(about_origin / load.mass), ", ")}),
)"""


FORMAT = ControllerFormat(
    name="drake",
    title="Drake SpatialInertia (Python)",
    reference="unit inertia (per kg) about the flange's origin, not the centre of mass, axes of the flange",
    order="mass, com x, y, z, UnitInertia(Ixx, Iyy, Izz, Ixy, Ixz, Iyz), entries of the matrix",
    units="kg, m, m^2",
    point_mass="the unit inertia is that of a point mass at the centre of mass",
    source="drake.mit.edu, SpatialInertia",
    write=_write,
    comment=("# ", ""),
)
