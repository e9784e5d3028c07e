"""Chains of joints as public descriptions publish them, typed from the files that are named here.

A joint is the origin (x, y, z [m]; roll, pitch, yaw [rad] about fixed axes) of its frame in the one before, and the
axis it turns about. Limits are in the file's unit. Commits are those of the copies that were read.
"""

from dataclasses import dataclass, replace
from math import degrees, pi
from typing import Literal

Three = tuple[float, float, float]
Numbers = tuple[float, ...]
LEVEL, X, Y, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
BACK, RIGHT, DOWN = (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)
Q = 1.570796326794897
"""A quarter turn as Franka's files write it."""


@dataclass(frozen=True)
class Chain:
    """A published chain: where each joint stands in the one before, its axis, the flange, ranges and speeds.

    No ``angles``: all are zero. ``limits`` is their source, where it is another file.
    """

    source: str
    places: tuple[Three, ...]
    axes: tuple[Three, ...]
    flange: tuple[Three, Three]
    low: Numbers
    high: Numbers
    speeds: Numbers
    unit: Literal["deg", "rad"] = "deg"
    angles: tuple[Three, ...] = ()
    limits: str = ""

    def in_degrees(self, values: Numbers) -> Numbers:
        """Angles of the file in degrees."""
        return values if self.unit == "deg" else tuple(degrees(value) for value in values)


def _ur(name: str, commits: tuple[str, str], lengths: Numbers, speeds: Numbers) -> Chain:
    """A UR arm: z of the shoulder, x of forearm and wrist 1, z of wrist 1, -y of wrist 2, y of wrist 3."""
    kinematics, limits = commits
    shoulder, upper, fore, wrist1, wrist2, wrist3 = lengths
    return Chain(
        source=f"ros-industrial/universal_robot, ur_description/config/{name}/default_kinematics.yaml "
        f"({kinematics})",
        places=((0, 0, shoulder), (0, 0, 0), (upper, 0, 0), (fore, 0, wrist1), (0, -wrist2, 0), (0, wrist3, 0)),
        angles=(LEVEL, (1.570796327, 0, 0), LEVEL, LEVEL, (1.570796327, 0, 0), (1.570796326589793, pi, pi)),
        axes=(Z,) * 6,
        flange=(LEVEL, LEVEL),
        limits=f"UniversalRobots/Universal_Robots_ROS2_Description, config/{name}/joint_limits.yaml ({limits})",
        low=(-360, -360, -180, -360, -360, -360),
        high=(360, 360, 180, 360, 360, 360),
        speeds=speeds,
    )


_KR6 = Chain(
    source="ros-industrial/kuka_experimental, kuka_kr6_support/urdf/kr6r900sixx_macro.xacro (2510a09)",
    places=((0, 0, 0.4), (0.025, 0, 0), (0.455, 0, 0), (0, 0, 0.035), (0.42, 0, 0), (0.08, 0, 0)),
    axes=(DOWN, Y, Y, BACK, Y, BACK),
    flange=(LEVEL, (0, pi / 2, 0)),
    low=(-170, -190, -120, -185, -120, -350),
    high=(170, 45, 156, 185, 120, 350),
    speeds=(360, 300, 360, 381, 388, 615),
)
_GP7 = Chain(
    source="ros-industrial/motoman, motoman_gp7_support/urdf/gp7_macro.xacro (16ddd43)",
    places=((0, 0, 0.33), (0.04, 0, 0), (0, 0, 0.445), (0.44, 0, 0.04), LEVEL, LEVEL),
    axes=(Z, Y, RIGHT, BACK, RIGHT, BACK),
    flange=((0.08, 0, 0), (pi, -pi / 2, 0)),
    low=(-2.9670, -1.1344, -1.2217, -3.3161, -2.3561, -6.2944),
    high=(2.9670, 2.5307, 3.3161, 3.3161, 2.3561, 6.2944),
    speeds=(6.5448, 5.4977, 7.1558, 9.5993, 9.5993, 17.4845),
    unit="rad",
)
_TX2_60 = Chain(
    source="ros-industrial/staubli_experimental, staubli_tx2_60_support/urdf/tx2_60_macro.xacro (023ef52)",
    places=((0, 0, 0.375), LEVEL, (0, 0.02, 0.29), LEVEL, (0, 0, 0.31), (0, 0, 0.07)),
    axes=(Z, Y, Y, Z, Y, Z),
    flange=(LEVEL, LEVEL),
    low=(-180, -127.5, -152.5, -270, -121, -270),
    high=(180, 127.5, 152.5, 270, 132.5, 270),
    speeds=(435, 385, 500, 995, 1065, 1445),
)
_PANDA = Chain(
    source="frankaemika/franka_description, robots/fer/kinematics.yaml (1ddff9b)",
    places=(
        (0, 0, 0.333), LEVEL, (0, -0.316, 0), (0.0825, 0, 0), (-0.0825, 0.384, 0), LEVEL, (0.088, 0, 0),
    ),
    angles=(LEVEL, (-Q, 0, 0), (Q, 0, 0), (Q, 0, 0), (-Q, 0, 0), (Q, 0, 0), (Q, 0, 0)),
    axes=(Z,) * 7,
    flange=((0, 0, 0.107), LEVEL),
    limits="frankaemika/franka_ros, franka_description/robots/panda/joint_limits.yaml (b2a62ff)",
    low=(-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
    high=(2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
    speeds=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
    unit="rad",
)  # fmt: skip

CHAINS = {
    "kr6_r900": _KR6,
    "kr10_r1100": replace(
        _KR6,
        source="ros-industrial/kuka_experimental, kuka_kr10_support/urdf/kr10r1100sixx_macro.xacro (62c4af1)",
        places=((0, 0, 0.4), (0.025, 0, 0), (0.56, 0, 0), (0, 0, 0.035), (0.515, 0, 0), (0.08, 0, 0)),
        speeds=(300, 225, 225, 381, 311, 492),
    ),
    "irb120": Chain(
        source="ros-industrial/abb, abb_irb120_support/urdf/irb120_3_58_macro.xacro (59e17fb)",
        places=(LEVEL, (0, 0, 0.29), (0, 0, 0.27), (0, 0, 0.07), (0.302, 0, 0), (0.072, 0, 0)),
        axes=(Z, Y, Y, X, Y, X),
        flange=(LEVEL, (0, pi / 2, 0)),
        low=(-2.87979, -1.91986, -1.91986, -2.79253, -2.094395, -6.98132),
        high=(2.87979, 1.91986, 1.22173, 2.79253, 2.094395, 6.98132),
        speeds=(4.36332, 4.36332, 4.36332, 5.58505, 5.58505, 7.33038),
        unit="rad",
    ),
    "lrmate200id": Chain(
        source="ros-industrial/fanuc, fanuc_lrmate200id_support/urdf/lrmate200id_macro.xacro (6c60a1d)",
        places=((0, 0, 0.33), (0.05, 0, 0), (0, 0, 0.33), (0, 0, 0.035), (0.335, 0, 0), (0.08, 0, 0)),
        axes=(Z, Y, RIGHT, BACK, RIGHT, BACK),
        flange=(LEVEL, (pi, -pi / 2, 0)),
        low=(-170, -100, -70, -190, -125, -360),
        high=(170, 145, 205, 190, 125, 360),
        speeds=(450, 380, 520, 550, 545, 1000),
    ),
    "gp7": _GP7,
    "gp8": replace(
        _GP7,
        source="ros-industrial/motoman, motoman_gp8_support/urdf/gp8_macro.xacro (0ed2ce9)",
        places=((0, 0, 0.33), (0.04, 0, 0), (0, 0, 0.345), (0.34, 0, 0.04), LEVEL, LEVEL),
        speeds=(7.9412, 6.7195, 9.0757, 9.5993, 9.5993, 17.4533),
    ),
    "tx2_60": _TX2_60,
    "tx2_90": replace(
        _TX2_60,
        source="ros-industrial/staubli_experimental, staubli_tx2_90_support/urdf/tx2_90_macro.xacro (0b0f455)",
        places=((0, 0, 0.478), (0.05, 0, 0), (0, 0.05, 0.425), LEVEL, (0, 0, 0.425), (0, 0, 0.1)),
        low=(-180, -130, -145, -270, -115, -270),
        high=(180, 147.5, 145, 270, 140, 270),
        speeds=(400, 400, 430, 540, 475, 760),
    ),
    "iiwa14": Chain(
        source="IFL-CAMP/iiwa_stack, iiwa_description/urdf/iiwa14.xacro (052aa68)",
        places=(
            (0, 0, 0.1575), (0, 0, 0.2025), (0, 0.2045, 0), (0, 0, 0.2155), (0, 0.1845, 0), (0, 0, 0.2155),
            (0, 0.081, 0),
        ),
        angles=(
            LEVEL, (pi / 2, 0, pi), (pi / 2, 0, pi), (pi / 2, 0, 0), (-pi / 2, pi, 0), (pi / 2, 0, 0),
            (-pi / 2, pi, 0),
        ),
        axes=(Z,) * 7,
        flange=((0, 0, 0.045), (pi, pi, pi)),
        limits="lbr-stack/lbr_fri_ros2_stack, lbr_description/urdf/iiwa14/joint_limits.yaml (769ae8e)",
        low=(-170, -120, -170, -120, -170, -120, -175),
        high=(170, 120, 170, 120, 170, 120, 175),
        speeds=(85, 85, 100, 75, 130, 135, 135),
    ),
    "ur3e": _ur(
        "ur3e", ("6485dfa", "8ef39b3"), (0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
        (180, 180, 180, 360, 360, 360),
    ),
    "ur5e": _ur(
        "ur5e", ("6485dfa", "1c32d8f"), (0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996), (180,) * 6
    ),
    "ur16e": _ur(
        "ur16e", ("2f185ee", "8ecc89e"), (0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655),
        (120, 120, 180, 180, 180, 180),
    ),
    "ur20": _ur(
        "ur20", ("174e5bb", "77bdad0"), (0.2363, -0.862, -0.7287, 0.201, 0.1593, 0.1543),
        (120, 120, 150, 210, 210, 210),
    ),
    "panda": _PANDA,
    "fr3": replace(
        _PANDA,
        source="Swiss-Battery-Technology-Center/franka_description (a fork), robots/fr3/kinematics.yaml (3c55fbf)",
        limits="frankaemika/franka_description, robots/fr3/joint_limits.yaml (1ddff9b)",
        low=(-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159),
        high=(2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159),
        speeds=(2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26),
    ),
}  # fmt: skip
"""By the shipped robot's name."""
