"""URScript: a servoj program with a sample each cycle of the controller.

servoj(q, a, v, t, lookahead_time, gain) blocks for t and leaves a and v unused; q in rad. The program refuses to
start far from the first pose, goes there slowly by movej, checks that it has arrived, and then streams; a cycle is
0.002 s on e-Series, 0.008 s on CB3. Source: URScript manual, servoj, movej, get_actual_joint_positions, stopj,
popup (universal-robots.com/manuals/EN/HTML/SW5_20/Content/prod-scriptmanual/G5/
servoj_qavt0-008lookahead_time.htm).
"""

from functools import partial

import numpy as np

from ....common.errors import InputError
from ....model import Robot
from ....trajectories import SampledTrajectory
from ..format import Format
from ..motion import DENSER, WrittenMotion, listed, require_six_turning

CONTROLLER_RATE = 500.0  # Hz: e-Series. A CB3 has 125
_LOOKAHEAD, _GAIN = 0.1, 300  # the manual's example
_RAMP_SPEED, _RAMP_ACCELERATION = 0.25, 0.5  # rad/s, rad/s^2: to the first pose
_FAR, _THERE = 1.0, 0.01  # rad: farther than _FAR from the first pose nothing moves


def _replay(motion: WrittenMotion) -> SampledTrajectory:
    """servoj follows positions alone; they are joined by the smoothest curve that rests at both ends."""
    # It stands in the first pose before, and in the last one afterwards.
    t = np.arange(-1, len(motion.cycles()) + 1) / motion.rate
    return SampledTrajectory(t, motion.plan.at(t)[0], source="--urscript")


@partial(
    Format,
    title="URScript of Universal Robots",
    source="URScript manual, servoj",
    replay=_replay,
    replayed=("URScript joins the samples", DENSER),
)
def _write(motion: WrittenMotion) -> str:
    check_urscript(motion.robot, motion.rate)
    q = motion.cycles()
    lines = [
        f"# {len(q)} samples at {motion.rate:g} Hz. Try it with the speed slider low and a hand on the emergency "
        "stop.",
        "def dynident_motion():",
        f"  first = {listed(q[0])}",
        *_check("present pose", _FAR, "too far from the first pose: jog nearer"),
        f"  movej(first, a={_RAMP_ACCELERATION}, v={_RAMP_SPEED})",
        *_check("pose after the approach", _THERE, "not the first pose: nothing was run"),
        *(f"  servoj({listed(row)}, 0, 0, {1.0 / motion.rate:g}, {_LOOKAHEAD}, {_GAIN})" for row in q),
        "  stopj(2.0)",
        "end",
        "dynident_motion()",
    ]
    return "\n".join(lines)


def check_urscript(robot: Robot, rate: float) -> None:
    """Refuse, before any work is done, robots and rates that no controller runs."""
    require_six_turning(robot, "URScript")
    if rate not in (500.0, 125.0):
        raise InputError(f"a URScript controller runs at 500 Hz (e-Series) or 125 Hz (CB3), not at {rate:g} Hz")


def _check(label: str, limit: float, message: str) -> list[str]:
    """Stop unless every joint is within ``limit`` [rad] of the first pose."""
    return [
        f"  # {label}",
        "  here = get_actual_joint_positions()",
        "  k = 0",
        "  while k < 6:",
        f"    if norm(here[k] - first[k]) > {limit:g}:",
        f'      popup("{message}", title="dynident", error=True, blocking=True)',
        "      halt",
        "    end",
        "    k = k + 1",
        "  end",
    ]
