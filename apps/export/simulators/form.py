"""What formats of whole robots share: head, marks of numbers, what is left out, and where links stand."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

from .... import __version__
from ....common.errors import InputError, printable
from ....estimation.possible.whole_robot import Labelled, LinkNumbers, WholeRobot, whole_robot
from ....estimation.results.robot import RobotResult
from ....model import Pose, Robot, base_parameters
from ....model.frames import step
from ...numbers import exact

_UNITS = {"armature": "kg m^2 or kg", "damping": "N·m·s/rad or N·s/m", "friction": "N·m or N", "offset": "N·m or N"}
_STANDARD_GRAVITY = [0.0, 0.0, -9.81]
LEGEND = (
    "Each number has a mark. 'data': they alone determine it; sigma and the 95 % interval (low, high) are theirs. "
    "'prior': data give only the share of it that is told (0 to 1), within the base parameters that are named, or "
    "nothing (none). 'rule': it stands at the bound of what can exist, zero, which the data alone would pass."
)


@dataclass(frozen=True)
class SimulatorFormat:
    """A format that a whole robot can be written in.

    Attributes:
        name: on the command line.
        title: whose format it is.
        ending: of its files.
        holds: what of drives, limits and the world it has a place for: of ``armature``, ``damping``, ``friction``,
            ``offset``, ``coupled``, ``spring``, ``speed``, ``torque``, ``gravity``.
        write: the robot as text, below the lines of the head.
        remarks: what must be known of the format.
    """

    name: str
    title: str
    ending: str
    holds: frozenset[str]
    write: Callable[[WholeRobot, list[str]], str]
    remarks: tuple[str, ...] = ()

    def text(self, whole: WholeRobot) -> str:
        """The whole file."""
        return self.write(whole, self.head(whole))

    def head(self, whole: WholeRobot) -> list[str]:
        """What must be said beside the numbers."""
        title = whole.robot.title or whole.robot.name
        lines = [
            f"{title} as {self.title} by dynident {__version__}. Numbers: {whole.source}.",
            f"Prior: {whole.prior}.",
            LEGEND,
            *self.notes(whole),
        ]
        if whole.groupings:
            lines.append(f"Base parameters: {'; '.join(whole.groupings)}.")
        return lines

    def notes(self, whole: WholeRobot) -> list[str]:
        """What a reader must know of this robot: masses, bounds, and what is left out."""
        return [*_masses(whole), *_bounds(whole), *_rotors(whole), *self._lost(whole), *self.remarks]

    def _lost(self, whole: WholeRobot) -> Iterator[str]:
        """What of the robot has no place in the format, a line each."""
        robot = whole.robot
        yield from self._lost_drives(whole)
        yield from self._lost_coupling(whole)
        if robot.spring is not None and ("spring" not in self.holds or robot.spring.table):
            law = "a table" if robot.spring.table else "the law of a spring between two pivots"
            yield f"No place for the spring on {whole.joint_names[robot.spring.joint - 1]} ({law}): add its torque."
        if "gravity" not in self.holds and gravity_in_base(robot) != _STANDARD_GRAVITY:
            yield f"No place for gravity: set it to {exact(gravity_in_base(robot))} m/s^2 in the base's frame."
        yield from self._lost_limits(whole)

    def _lost_drives(self, whole: WholeRobot) -> Iterator[str]:
        drives = whole.drives if "coupled" in self.holds else whole.apart
        for quantity, unit in _UNITS.items():
            values = [
                f"{name} {drive[quantity].value:.6g}"
                for name, drive in zip(whole.joint_names, drives, strict=True)
                if quantity in drive and drive[quantity].value
            ]
            if quantity not in self.holds and values:
                yield f"No place for {quantity} [{unit}]: {', '.join(values)}."

    def _lost_limits(self, whole: WholeRobot) -> Iterator[str]:
        robot = whole.robot
        limited = {
            "speed": [joint.limits.speed for joint in robot.joints],
            "acceleration": [joint.limits.acceleration for joint in robot.joints],
        }
        for quantity, bounds in limited.items():
            if quantity not in self.holds and any(map(math.isfinite, bounds)):
                yield f"No place for limits of {quantity}: {', '.join(f'{bound:.6g}' for bound in bounds)}."

    def _lost_coupling(self, whole: WholeRobot) -> Iterator[str]:
        coupling = whole.robot.coupling
        if coupling is None:
            return
        names = " and ".join(whole.joint_names[joint - 1] for joint in coupling.joints)
        if "coupled" not in self.holds:
            values = ", ".join(f"{quantity} {label.value:.6g}" for quantity, label in whole.coupled.items())
            yield (
                f"No place for the drive that turns with the sum of {names} ({values}): each joint has its own "
                "share, what acts from one on the other is left out, and so is this friction."
            )
        elif coupling.coulomb == "paper" and "friction" in whole.coupled:
            yield (
                f"No place for the dry friction of the drive that turns with {names} "
                f"({whole.coupled['friction'].value:.6g}) as the paper prints it: it is left out."
            )


def _masses(whole: WholeRobot) -> Iterator[str]:
    arm = whole.robot.mass
    maker = f"; the whole arm weighs {arm:g} kg by its maker, base included" if arm is not None else ""
    yield f"Moving links weigh {whole.mass:.4g} kg together{maker}."
    yield from (f"{text}: no link of a real arm does." for text in whole.heavier_than_the_arm())
    least = min(whole.links, key=lambda link: float(link.moments[0]))
    yield (
        f"Least principal moment of inertia: {least.moments[0]:.3g} kg m^2 ({least.link}); nearest to the edge of "
        f"the possible: {(edge := min(whole.links, key=lambda link: link.margin)).link}, A + B - C is "
        f"{100.0 * edge.margin:.2g} % of the sum."
    )


def _bounds(whole: WholeRobot) -> Iterator[str]:
    if at_bound := whole.at_bound():
        yield (
            f"At their bound, zero: {', '.join(at_bound)}. Torques hardly show it, but a simulated motion runs "
            "away where a joint moves without the rotor or friction that it has in truth: record that joint faster "
            "or longer, or enter what its maker says."
        )
    if negative := whole.negative():
        yield f"Negative in the source, which no drive is, and written as zero: {', '.join(negative)}."


def _rotors(whole: WholeRobot) -> Iterator[str]:
    drives = whole.robot.drives
    if not drives.rotor_inertia:
        why = "torque sensors behind the gears do not show them" if drives.side == "link" else "the model has none"
        yield f"Rotor inertias (armature) are left out: {why}. Enter the maker's, or motions will be too lively."
    without = [name for name, d in zip(whole.joint_names, whole.drives, strict=True) if "damping" not in d]
    if without:
        yield f"Friction is left out, for nothing is known of it: {', '.join(without)}."


def drive_value(drive: Mapping[str, Labelled], quantity: str) -> float:
    """A drive's number as it is written: never negative, zero where there is none."""
    return max(drive[quantity].value, 0.0) if quantity in drive else 0.0


def fields(label: Labelled) -> dict[str, str]:
    """A mark as words by key; ``none`` where there is nothing to say."""
    low, high = label.interval or (None, None)
    return {
        "value": exact(label.value),
        "mark": label.mark,
        "share": f"{math.floor(1000.0 * label.origin.share) / 1000.0:.3f}",  # 1 is for what the data determine
        "sigma": _short(label.sigma),
        "low": _short(low),
        "high": _short(high),
        "within": ",".join(label.origin.base) or "none",
    }


def mark_lines(numbers: Mapping[str, Labelled]) -> Iterator[str]:
    """One line a number: name, value, mark, share of the data, sigma, low, high, base parameters."""
    for name, label in numbers.items():
        yield " ".join([name, *fields(label).values()])


def link_marks(link: LinkNumbers, drive: Mapping[str, Labelled]) -> dict[str, Labelled]:
    """Numbers of a link and of the drive before it, then its standard parameters."""
    return {**link.numbers, **drive, **link.parameters}


def _short(value: float | None) -> str:
    return "none" if value is None else f"{value:.6g}"


def attributes(values: Mapping[str, str]) -> str:
    """Attributes of an XML element."""
    return " ".join(f"{name}={quoteattr(value)}" for name, value in values.items())


def comment(lines: Iterable[str]) -> list[str]:
    """An XML comment a line, which ends no comment."""
    return [f"<!-- {plain(line)} -->" for line in lines]


def plain(text: str) -> str:
    """Text on one line that ends no comment."""
    return printable(" ".join(text.split())).replace("--", "- -").replace("--", "- -")


def own_frame(robot: Robot, number: int) -> Pose:
    """The link's frame in modified DH frame ``number``; the base's in frame 0."""
    if number == 0:
        return robot.base
    return robot.links.poses[number - 1] if robot.links is not None else Pose()


def in_parent(robot: Robot, j: int) -> Pose:
    """Link j + 1 in the link before."""
    return joint_in_parent(robot, j) @ own_frame(robot, j + 1)


def joint_in_parent(robot: Robot, j: int) -> Pose:
    """Modified DH frame j + 1, whose z is the joint's axis, in the link before."""
    along_x, along_z = step(robot.joints[j], 0.0)
    return own_frame(robot, j).inverse() @ along_x @ along_z


def joint_direction(robot: Robot, j: int) -> list[float]:
    """Direction of the joint's axis in link j + 1, which stands on it; shape (3,)."""
    return [float(value) for value in own_frame(robot, j + 1).R[2]]


def flange_pose(robot: Robot) -> Pose:
    """The payload's frame in the last link."""
    return own_frame(robot, robot.n).inverse() @ robot.flange


def gravity_in_base(robot: Robot) -> list[float]:
    """Acceleration of gravity in the base's frame [m/s^2], shape (3,)."""
    return [float(value) + 0.0 for value in robot.base.R.T @ list(robot.gravity)]


def flange_name(robot: Robot) -> str:
    """Name of the flange's frame."""
    return robot.links.tip if robot.links is not None else "flange"


def stored_whole_robot(robot: Robot, stored: RobotResult, path: str) -> WholeRobot:
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
