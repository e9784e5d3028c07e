"""Via points as a VAL3 application of Staubli: joint variables, motion descriptors and a movej program.

A .pjx project, a .dtx database with ``jointRx`` [deg] and ``mdesc`` arrays, and the programs start and stop. accel,
vel and decel are percentages of the nominal values, blend is off or joint, with leave and reach [mm]. The
controller plans its own profile between the points: only its log shows what was run. Sources: VAL3 Reference
Manual (D28062804A), 9.5 mdesc type and 9.6 movement instructions; Beckhoff TF5130, T_Mdesc; the layout of the files
as in the public VAL3 applications of ros-industrial/staubli_val3_driver.
"""

from xml.sax.saxutils import escape

import numpy as np

from ....common.arrays import Array
from ....common.errors import InputError
from ....model import Robot
from ....trajectories import ViaPoints
from .val3_moves import Descriptor, descriptors_of
from .written import WrittenMotion, require_six_turning

_XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
_SPACE = "http://www.staubli.com/robotics/VAL3"
_FIRST = '<?xml version="1.0" encoding="utf-8"?>'
_APPROACH = 10  # % of the speed, to the first point
_WARNING = (
    "The controller plans its own way between these points: torques and obstacles were checked for the designed",
    "motion, not for that. Run it slowly first, and score its log by dynident score.",
)


def val3_files(written: WrittenMotion, name: str) -> dict[str, str]:
    """File name -> text.

    Args:
        written: the motion; through via points.
        name: of the application.

    Raises:
        InputError: for a Fourier motion, a robot that is not of six turning joints, or a name that VAL3 refuses.
    """
    plan = written.plan
    check_val3(written.robot, isinstance(plan, ViaPoints), name)
    assert isinstance(plan, ViaPoints)
    descriptors = [Descriptor(_APPROACH, _APPROACH), *descriptors_of(written, plan)]
    head = (*written.head, *_WARNING)
    return {
        f"{name}.pjx": _project(name),
        f"{name}.dtx": _data(np.degrees(plan.points), descriptors, head),
        "start.pgx": _program("start", "public", _start(head, len(plan.points))),
        "stop.pgx": _program("stop", "private", ["begin", "  resetMotion()", "end"]),
    }


def check_val3(robot: Robot, via_points: bool, name: str) -> None:
    """Refuse what has no place in a VAL3 application, before any work is done.

    Raises:
        InputError: for a Fourier motion, a robot that is not of six turning joints, or a name that VAL3 refuses.
    """
    require_six_turning(robot, "VAL3 jointRx")
    if not via_points:
        raise InputError("VAL3 needs via points, a Fourier motion has none: design with --via-points")
    if not (name.isascii() and name.replace("_", "a").isalnum() and name[:1].isalpha() and len(name) <= 15):
        raise InputError(
            f"{name!r} is no VAL3 application's name: a letter, then letters, digits and _, 15 at most"
        )


def _project(name: str) -> str:
    return "\n".join(
        [
            _FIRST,
            f'<Project xmlns="{_SPACE}/Project/3">',
            '  <Parameters version="s7.3.1" stackSize="5000" millimeterUnit="true" />',
            "  <Programs>",
            '    <Program file="start.pgx" />',
            '    <Program file="stop.pgx" />',
            "  </Programs>",
            "  <Database>",
            f'    <Data file="{name}.dtx" />',
            "  </Database>",
            "  <Libraries />",
            "</Project>\n",
        ]
    )


def _data(degrees: Array, descriptors: list[Descriptor], head: tuple[str, ...]) -> str:
    joints = [" ".join(f'j{j + 1}="{angle:.6f}"' for j, angle in enumerate(row)) for row in degrees]
    motions = []
    for accel, vel, leave in descriptors:
        blend = f'blend="joint" leave="{leave:g}" reach="{leave:g}"' if leave else 'blend="off"'
        motions.append(f'accel="{accel}" vel="{vel}" decel="{accel}" tmax="99999" rmax="99999" {blend}')
    remarks = "\n".join(f"  {line}" for line in head).replace("--", "- -")
    return "\n".join(
        [
            _FIRST,
            f"<!--\n{escape(remarks)}\n-->",
            f'<Database {_XSI} xmlns="{_SPACE}/Data/2">',
            "  <Datas>",
            *_array("jPoint", "jointRx", joints),
            *_array("mMotion", "mdesc", motions),
            *_array("nIndex", "num", ['value="0"']),
            *_array("tFlange", "tool", ['fatherId="flange[0]"']),
            "  </Datas>",
            "</Database>\n",
        ]
    )


def _array(name: str, kind: str, values: list[str]) -> list[str]:
    return [
        f'    <Data name="{name}" access="private" xsi:type="array" type="{kind}" size="{len(values)}">',
        *(f'      <Value key="{k}" {value} />' for k, value in enumerate(values)),
        "    </Data>",
    ]


def _start(head: tuple[str, ...], count: int) -> list[str]:
    return [
        "begin",
        *(f"  // {line}".replace("]]>", "]] >") for line in head),
        f"  // Slowly to the first point ({_APPROACH} % speed), then all {count} points.",
        "  movej(jPoint[0], tFlange, mMotion[0])",
        "  waitEndMove()",
        f"  for nIndex = 1 to {count - 1}",
        "    movej(jPoint[nIndex], tFlange, mMotion[nIndex])",
        "  endFor",
        "  waitEndMove()",
        "end",
    ]


def _program(name: str, access: str, code: list[str]) -> str:
    return "\n".join(
        [
            _FIRST,
            f'<Programs {_XSI} xmlns="{_SPACE}/Program/2">',
            f'  <Program name="{name}" access="{access}">',
            "    <Code><![CDATA[" + "\n".join(code),
            "]]></Code>",
            "  </Program>",
            "</Programs>\n",
        ]
    )
