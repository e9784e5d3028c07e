"""The whole robot that an identification stored: links that can exist, each number labelled."""

from ....common.errors import InputError
from ....estimation.possible.whole_robot import WholeRobot, whole_robot
from ....model import Robot, base_parameters
from ...results.stored import StoredRobot


def stored_whole_robot(robot: Robot, stored: StoredRobot, path: str) -> WholeRobot:
    """A robot with the parameters nearest to a prior, as ``dynident identify`` stored them.

    Args:
        stored: what was identified, of one recording or of several together.
        path: of the file, for messages.

    Raises:
        InputError: if the file is another robot's, or holds no links nearest to a prior.
    """
    robot = stored.applied_to(robot)
    base = base_parameters(robot)
    nearest = stored.nearest_prior
    if nearest is None:
        raise InputError(
            f"{path}: no links in it that can exist: run 'dynident identify --prior-mass KG' again (KG: the moving "
            "links' mass, as far as it is known)"
        )
    if stored.estimate.names != base.columns or set(nearest.standard) != set(base.standard):
        raise InputError(f"{path}: other parameters than this robot's: identify the robot again")
    source = (
        f"{len(base.columns)} base parameters identified ({path}), moved to those of a robot that can exist "
        f"(chi2 rises by {nearest.chi2_rise:.3g})"
    )
    return whole_robot(robot, nearest.standard, source, base, stored.estimate, nearest.source)
