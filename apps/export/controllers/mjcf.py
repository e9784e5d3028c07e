"""MJCF (MuJoCo): a body ``payload`` inside the body ``flange``.

fullinertia is M(1,1), M(2,2), M(3,3), M(1,2), M(1,3), M(2,3) about pos in the axes of the body; it must be
positive definite and its principal moments fulfil A + B >= C. Source: MuJoCo documentation, XML reference,
body/inertial.
"""

from ....common.errors import InputError
from ...numbers import exact, six
from .form import ControllerFormat
from .load import ControllerLoad

_LEAST = 1e-15
"""MuJoCo's mjMINVAL: no moment of inertia may be smaller."""


def _write(load: ControllerLoad) -> str:
    inertia = 'diaginertia="0 0 0"' if load.point_mass else f'fullinertia="{exact(six(load.inertia))}"'
    return f"""<mujoco model="payload">
  <worldbody>
    <body name="flange">
      <body name="payload">
        <inertial pos="{exact(load.com)}" mass="{exact(load.mass)}" {inertia}/>
      </body>
    </body>
  </worldbody>
</mujoco>"""


def _check(load: ControllerLoad) -> None:
    least = float(load.principal[0].min())
    if not load.point_mass and least < _LEAST:
        raise InputError(f"the smallest moment of inertia is {least:.2g} kg m^2: MuJoCo refuses so small a body")


FORMAT = ControllerFormat(
    name="mjcf",
    title="MJCF (copy the body payload into the body of your flange)",
    reference="inertia matrix about the centre of mass, axes of the flange",
    order="pos x, y, z; fullinertia M11, M22, M33, M12, M13, M23",
    units="kg, m, kg m^2",
    point_mass="the inertia is zero, a point mass; a moving link needs inertia of its own",
    source="MuJoCo XML reference, body/inertial",
    write=_write,
    comment=("<!-- ", " -->"),
    check=_check,
)
