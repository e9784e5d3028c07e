"""The whole robot that an identification stored: links that can exist, each number labelled."""

from collections.abc import Mapping

from ....common.errors import InputError
from ....estimation.fit.estimate import Estimate
from ....estimation.possible.cone import SolverError
from ....estimation.possible.labelled import WholeRobot
from ....estimation.possible.labelling import whole_robot
from ....estimation.possible.ranges import parameter_ranges
from ....model import BaseParameters, Robot, base_parameters
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
    words = f"{len(base.columns)} base parameters identified ({path})"
    return identified_whole_robot(
        robot, base, stored.estimate, nearest.standard, nearest.chi2_rise, nearest.source, words
    )


def identified_whole_robot(
    robot: Robot,
    base: BaseParameters,
    estimate: Estimate,
    standard: Mapping[str, float],
    chi2_rise: float,
    prior: str,
    source: str,
) -> WholeRobot:
    """A robot that can exist with what the data say of each number.

    Args:
        estimate: of all of them.
        standard: parameters of the robot nearest to the prior.
        chi2_rise: what these cost.
        prior: what decides where data do not, in words.
        source: where the numbers come from, in words.
    """
    source = f"{source}, moved to those of a robot that can exist (chi2 rises by {chi2_rise:.3g})"
    try:
        ranges = parameter_ranges(robot, base, estimate)
    except SolverError:  # only a bound of the mass, which identify was given, made a nearest robot
        ranges, source = (
            None,
            f"{source}; what the data allow of the prior's numbers is not known: no robot is near them",
        )
    return whole_robot(robot, standard, source, base, estimate, prior, ranges)
