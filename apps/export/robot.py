"""Common parts of whole robots' formats: the head, marks of numbers, drives, and frames of links."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple
from xml.etree.ElementTree import Comment, Element

from ... import __version__, estimation
from ...common import Array, InputError
from ...model import PAPER, Joint, Pose, Robot, base_parameters
from ...model.drives import parameter_kind
from ...model.frames import step
from ..numbers import exact
from .format import Format, element, plain

_UNITS = {"armature": "kg m^2 or kg", "damping": "N·m·s/rad or N·s/m", "friction": "N·m or N", "offset": "N·m or N"}
_STANDARD_GRAVITY = [0.0, 0.0, -9.81]
_DYNAMICS = {"damping": "damping", "friction": "friction"}  # as URDF and SDFormat call them
_LEGEND = (
    "Each number has a mark. 'data': they alone determine it; sigma and the 95 % interval (low, high) are theirs. "
    "'prior': data give only the share of it that is told (0 to 1), within the base parameters that are named, or "
    "nothing (none). 'rule': it stands at the bound of what can exist, zero, which the data alone would pass."
)


def robot_head(form: Format[estimation.WholeRobot], whole: estimation.WholeRobot) -> list[str]:
    """Head of a file: source of the numbers, prior, meaning of the marks, and notes."""
    title = whole.robot.title or whole.robot.name
    return [
        f"{title} as {form.title} by dynident {__version__}. Numbers: {whole.source}.",
        f"Prior: {whole.prior}.",
        _LEGEND,
        *robot_notes(form, whole),
        *([f"Base parameters: {'; '.join(whole.groupings)}."] if whole.groupings else []),
        f"Format: {form.source}.",
    ]


def robot_notes(form: Format[estimation.WholeRobot], whole: estimation.WholeRobot) -> Iterator[str]:
    """Masses, drives that are not to be believed or not known, and all that the format has no place for."""
    arm, drives = whole.robot.mass, whole.robot.drives
    maker = f"; the maker's mass of the arm, with its base, is {arm:g} kg" if arm is not None else ""
    yield f"The moving links weigh {whole.mass:.4g} kg in total{maker}."
    yield from (f"{text}: no link of a real arm does." for text in whole.heavier_than_the_arm())
    least = min(whole.links, key=lambda link: float(link.moments[0]))
    edge = min(whole.links, key=lambda link: link.margin)
    edge_of = f"{edge.link}, A + B - C is {100.0 * edge.margin:.2g} % of the sum"
    smallest = f"Smallest principal moment of inertia: {least.moments[0]:.3g} kg m^2 ({least.link})"
    yield f"{smallest}. Closest to physical impossibility: {edge_of}."
    if at_bound := whole.signed(lambda label: label.bound):
        why = "Torques hardly show this, but a simulated joint without its rotor or friction runs away"
        advice = "record that joint faster or longer, or enter the maker's values"
        yield f"At their bound of zero: {', '.join(at_bound)}. {why}: {advice}."
    if negative := whole.signed(lambda label: label.value < 0.0):
        yield f"Negative in the source, which is impossible, so written as zero: {', '.join(negative)}."
    if not drives.rotor_inertia:
        why = "torque sensors behind the gears do not show them" if drives.side == "link" else "the model has none"
        yield f"Rotor inertias (armature) are left out: {why}. Enter the maker's, or joints accelerate too easily."
    if without := [name for name, d in zip(whole.joint_names, whole.drives, strict=True) if "damping" not in d]:
        yield f"Friction is left out because it is unknown: {', '.join(without)}."
    yield from _lost(form.holds, whole)
    yield from form.remarks


def _lost(holds: frozenset[str], whole: estimation.WholeRobot) -> Iterator[str]:
    robot, coupling, spring = whole.robot, whole.robot.coupling, whole.robot.spring
    drives = whole.drives if "coupled" in holds else whole.apart
    for quantity in (quantity for quantity in _UNITS if quantity not in holds):
        of_joints = zip(whole.joint_names, (drive.get(quantity) for drive in drives), strict=True)
        if values := [f"{name} {label.value:.6g}" for name, label in of_joints if label and label.value]:
            yield f"This format has no {quantity} [{_UNITS[quantity]}]: {', '.join(values)}."
    kinds = [term.kind for term in robot.drives.friction if term not in PAPER]
    own = {name: value.value for link in whole.links for name, value in link.parameters.items()}
    laws = [f"{name} {value:.4g}" for name, value in own.items() if parameter_kind(name) in kinds]
    if laws:
        yield (
            f"This format has only Coulomb and viscous friction, not {', '.join(laws)}: friction and damping are "
            "the closest fit, for the bare arm's mean gravity torque and up to each joint's largest speed."
        )
    names = " and ".join(whole.joint_names[joint - 1] for joint in coupling.joints) if coupling else ""
    if coupling is not None and "coupled" not in holds:
        numbers = ", ".join(f"{quantity} {label.value:.6g}" for quantity, label in whole.coupled.items())
        instead = "each joint has its own part; the coupling between them and its friction are left out"
        yield f"This format has no drive that turns with the sum of {names} ({numbers}): {instead}."
    elif coupling is not None and coupling.coulomb == "paper" and "friction" in whole.coupled:
        drive = f"the drive that turns with {names} ({whole.coupled['friction'].value:.6g})"
        yield f"This format cannot express the dry friction of {drive} as the paper prints it: it is left out."
    if spring is not None and ("spring" not in holds or spring.table):
        law = "a table" if spring.table else "the law of a spring between two pivots"
        yield f"This format has no spring on {whole.joint_names[spring.joint - 1]} ({law}): add its torque."
    if "gravity" not in holds and (gravity := gravity_of(robot)) != _STANDARD_GRAVITY:
        yield f"This format has no gravity: set it to {exact(gravity)} m/s^2 in the base frame."
    for quantity in ("speed", "acceleration"):
        bounds = [getattr(joint.limits, quantity) for joint in robot.joints]
        if quantity not in holds and any(map(math.isfinite, bounds)):
            yield f"This format has no {quantity} limits: {', '.join(f'{bound:.6g}' for bound in bounds)}."


def drive_value(drive: Mapping[str, estimation.Labelled], quantity: str) -> float:
    """A drive's number as it is written: never negative, zero where there is none."""
    return max(drive[quantity].value, 0.0) if quantity in drive else 0.0


def fields(label: estimation.Labelled) -> dict[str, str]:
    """A mark as words by key; ``none`` where there is nothing to say."""
    low, high = label.interval or (None, None)
    sure = {"sigma": label.sigma, "low": low, "high": high}
    texts = {name: "none" if value is None else f"{value:.6g}" for name, value in sure.items()}
    share = f"{math.floor(1000.0 * label.origin.share) / 1000.0:.3f}"  # 1 is for what the data determine
    within = ",".join(label.origin.base) or "none"
    return {"value": exact(label.value), "mark": label.mark, "share": share, **texts, "within": within}


def drive_attributes(
    drive: Mapping[str, estimation.Labelled], names: Mapping[str, str] = _DYNAMICS
) -> dict[str, str]:
    """Numbers of a drive as attributes, as far as they are known; ``names``: of each quantity in a format."""
    return {name: exact(drive_value(drive, quantity)) for quantity, name in names.items() if quantity in drive}


class MovedLink(NamedTuple):
    """A link and the joint that moves it, as simulators hold them; poses at zero."""

    name: str  # of the joint
    joint: Joint
    parent: str  # name of the link before, at first the base
    link: estimation.LinkNumbers
    drive: Mapping[
        str, estimation.Labelled
    ]  # of the joint; where formats cannot couple joints, its share of both drives
    frame: Pose  # modified DH frame of the joint, whose z is its axis, in the link before
    own: Pose  # the link in that frame
    pose: Pose  # the link in the one before
    axis: str  # direction of the joint's axis in the link, which stands on it
    marks: Mapping[
        str, estimation.Labelled
    ]  # numbers of the link and of the drive before it, then its standard parameters

    def comment(self) -> Element[Any]:
        """One comment, a line a number: name, value, mark, share of the data, sigma, low, high, base."""
        lines = (" ".join([name, *fields(label).values()]) for name, label in self.marks.items())
        return Comment("".join(f"\n        {plain(line)}" for line in lines) + "\n      ")

    def marked(self, inertial: Callable[[float, Array, Array], Element]) -> list[Element[Any]]:
        """The body after the comment; then marks as elements of their own, which SDFormat keeps."""
        body, marks = self.link.body, self.marks.items()
        bodies = [inertial(body.mass, body.com, body.inertia_com)] if body.mass else []
        every = (element("dynident:number", {"name": name} | fields(label)) for name, label in marks)
        return [self.comment(), *bodies, *every]


def moved_links(whole: estimation.WholeRobot, apart: bool = True) -> list[MovedLink]:
    """Each link with its joint, base to tip; ``apart``: for formats that cannot couple joints."""
    robot, before, moved = whole.robot, whole.robot.base, list[MovedLink]()
    poses = robot.links.poses if robot.links is not None else (Pose(),) * robot.n
    drives = whole.apart if apart else whole.drives
    parts = zip(whole.joint_names, robot.joints, whole.link_names, whole.links, drives, poses, strict=False)
    for name, joint, parent, link, drive, own in parts:
        along_x, along_z = step(joint, 0.0)
        frame, marks = before.inverse() @ along_x @ along_z, {**link.numbers, **drive, **link.parameters}
        moved.append(MovedLink(name, joint, parent, link, drive, frame, own, frame @ own, exact(own.R[2]), marks))
        before = own
    return moved


def flange_of(robot: Robot) -> tuple[str, Pose]:
    """Name of the flange's frame, and the payload's frame in the last link."""
    if robot.links is None:
        return "flange", robot.flange
    return robot.links.tip, robot.links.poses[-1].inverse() @ robot.flange


def gravity_of(robot: Robot) -> list[float]:
    """Acceleration of gravity in the base's frame [m/s^2], shape (3,)."""
    return [float(value) + 0.0 for value in robot.base.R.T @ list(robot.gravity)]


def stored_whole_robot(robot: Robot, stored: estimation.RobotResult, path: str) -> estimation.WholeRobot:
    """A robot with the parameters nearest to a prior, as ``dynident identify`` stored them in the file ``path``.

    Raises:
        InputError: if the file is another robot's, or holds no links nearest to a prior.
    """
    robot = stored.applied_to(robot)
    base, nearest = base_parameters(robot), stored.constrained
    if nearest is None or nearest.gauge != "prior":
        advice = "run 'dynident identify --prior-mass KG' again (KG: mass of the moving links, as far as known)"
        raise InputError(f"{path}: has no physically consistent links: {advice}")
    standard = {parameter.name: parameter.value for parameter in nearest.parameters or ()}
    if stored.estimate.names != base.columns or set(standard) != set(base.standard):
        raise InputError(f"{path}: its parameters are not those of this robot: identify the robot again")
    made = f"made physically consistent (chi2 rises by {nearest.chi2_rise:.3g})"
    source = f"{len(base.columns)} identified base parameters ({path}), {made}"
    prior = nearest.prior.source if nearest.prior else ""
    return estimation.whole_robot(robot, standard, source, base, stored.estimate, prior)
