"""``dynident design --near``: a short motion about a pose, for ``dynident weigh``."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console

from .. import estimation, model, report, trajectories
from ..common.arrays import Array
from ..common.errors import InputError
from ..common.files import write_text
from .arguments import ANSWERED, chosen_robot
from .design_outputs import check_formats, write_formats
from .design_problem import asked_bounds, asked_noise, in_si
from .near_outputs import write_near_outputs
from .values import gains_list, positive_number
from .weigh import joint_list

_WITHOUT = (
    "via_points", "fourier", "rest", "max_duration", "start", "columns", "parameters", "payload_only", "data_from",
    "data_length", "bound", "evaluate", "log_map", "cutoff", "heaviest_payload", "segments", "ramp",
    "segment_durations", "solver",
)  # fmt: skip
"""Options of other designs."""
_ONLY = ("joints", "range", "mass", "mass_sigma", "second_pose", "expected_mass", "rehearsal")
"""Options of this one."""
_NOISE = 0.007
"""Of the torque limit: standard deviation of a torque sample where none is given; real arms have 0.5 to 0.9 %."""
_NOISE_RATE = 10.0  # Hz
_DURATION = 30.0  # s


def near_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of a motion near a pose."""
    group = parser.add_argument_group("near a pose", "a short motion for 'dynident weigh'; takes --duration")
    group.add_argument(
        "--near", type=gains_list, metavar="Q1,Q2,..", help="where the robot stands [deg or m]; =-90,.. with minus"
    )
    group.add_argument("--joints", type=joint_list, metavar="J1,J2,..", help="joints that move, such as 2,3,5,6")
    group.add_argument(
        "--range", type=gains_list, metavar="R|R1,R2,..", help="to either side [deg or m] (default: 30)"
    )
    group.add_argument("--mass", type=positive_number, metavar="KG", help="the payload was weighed")
    group.add_argument("--mass-sigma", type=positive_number, metavar="KG", help="standard deviation of the scale")
    group.add_argument(
        "--expected-mass", type=positive_number, metavar="KG", help="about its mass, not weighed (default: 3)"
    )
    group.add_argument(
        "--second-pose",
        metavar="auto|Q1,Q2,..",
        help="do it again at another wrist pose, outside the range: one that helps, or this one",
    )
    group.add_argument(
        "--rehearsal", metavar="F.csv", help="the same way once at a tenth of the speed (default: beside --csv)"
    )


def check_near(arguments: argparse.Namespace) -> None:
    """Refuse options that would have no effect.

    Raises:
        InputError: one line.
    """
    if arguments.near is None:
        for option in _ONLY:
            if getattr(arguments, option) is not None:
                raise InputError(f"--{option.replace('_', '-')} has no effect without --near")
        return
    for option in _WITHOUT:
        if getattr(arguments, option):
            raise InputError(f"--{option.replace('_', '-')} has no effect with --near")
    if arguments.val3:
        raise InputError(
            "--val3 is for via points, and a motion near a pose is a Fourier series, which VAL3's moves cannot "
            "follow: take --csv, --ros2 or --urscript, or design with --via-points"
        )
    if arguments.criterion != "d":
        raise InputError("--criterion has no effect with --near: it takes the payload's own standard deviations")
    if arguments.joints is None:
        raise InputError("--near needs --joints: which of them move, such as --joints 2,3,5,6")
    if (arguments.mass is None) != (arguments.mass_sigma is None):
        raise InputError("--mass and --mass-sigma belong together: a scale errs too, by how much must be said")
    if arguments.mass is not None and arguments.expected_mass is not None:
        raise InputError("--expected-mass is for a payload that was not weighed: leave it out with --mass")


def run_near(arguments: argparse.Namespace) -> int:
    """Run it: visibility first, then the design."""
    request, hint = _request(arguments)
    check_formats(arguments, request.robot)
    visibility = request.visibility
    table = report.near.visibility_table(visibility)
    report.tables.console(table).print(table)
    trajectories.design.check_mass_visible(visibility, request.mass_sigma is not None, "near this pose")
    found = _designed(arguments, request)
    prediction = report.near.prediction_table(found.spread, request.expected)
    terminal = report.tables.console(prediction)
    terminal.print(prediction)
    notes = report.near.near_notes(found)
    if hint is not None:
        notes.append(report.near.second_pose_note(request, hint.tolist()))
    for line in notes:
        terminal.print(line, markup=False, highlight=False)
    _write(arguments, found)
    if arguments.plots or arguments.report:
        write_near_outputs(arguments, found, (table, prediction), notes)
    return ANSWERED


def _request(arguments: argparse.Namespace) -> tuple[trajectories.NearRequest, Array | None]:
    """What is asked for, and a second pose that would help where none was asked for."""
    robot = chosen_robot(arguments)
    known = None
    if arguments.robot_parameters:
        stored = estimation.files.read_stored_robot(arguments.robot_parameters)
        robot = stored.applied_to(robot)
        known = dict(zip(stored.estimate.names, stored.estimate.values.tolist(), strict=True))
    if max(arguments.joints) > robot.n:
        raise InputError(f"--joints {max(arguments.joints)}: robot {robot.name!r} has {robot.n} joints")
    bounds = asked_bounds(arguments, robot)
    noise, rate = _noise(arguments, robot, bounds)
    mass = arguments.mass or arguments.expected_mass or 3.0
    request = trajectories.NearRequest(
        robot,
        in_si(arguments.near, robot),
        arguments.joints,
        _ranges(arguments, robot),
        arguments.duration or _DURATION,
        noise,
        rate,
        model.InertialParameters.from_com(mass, [0.0, 0.0, 0.1], 0.003 * mass * np.eye(3)),
        arguments.mass_sigma,
        None,
        bounds,
        trajectories.read_scene(arguments.scene) if arguments.scene else None,
        known,
    )
    if arguments.second_pose is None:
        visible = request.visibility.mass_visible or request.mass_sigma is not None
        return request, trajectories.design.second_pose(request, arguments.seed) if visible else None
    if arguments.second_pose == "auto":
        found = trajectories.design.second_pose(request, arguments.seed)
        if found is None:
            print("dynident: note: no second pose would tell much more: there is one pose only", file=sys.stderr)
        return replace(request, second=found), None
    try:
        second = gains_list(arguments.second_pose)
    except argparse.ArgumentTypeError as error:
        raise InputError(f"--second-pose: {error}; or write auto") from None
    return replace(request, second=in_si(second, robot)), None


def _ranges(arguments: argparse.Namespace, robot: model.Robot) -> Array:
    """A range for each moving joint [rad or m]."""
    given, joints = arguments.range or (30.0,), arguments.joints
    if len(given) not in (1, len(joints)):
        raise InputError(f"--range has {len(given)} numbers for {len(joints)} joints: give one, or one for each")
    each = given * len(joints) if len(given) == 1 else given
    turning = [robot.joints[joint - 1].revolute for joint in joints]
    if len(given) == 1 and not all(turning):
        raise InputError("--range: give one number for each joint, in deg where it turns and in m where it slides")
    return np.array([np.radians(x) if turns else x for x, turns in zip(each, turning, strict=True)])


def _noise(
    arguments: argparse.Namespace, robot: model.Robot, bounds: trajectories.JointBounds
) -> tuple[Array, float]:
    """Standard deviation of torque samples per joint [N·m or N], and how many are independent in a second."""
    if arguments.torque_noise is not None:
        noise = asked_noise(arguments, bounds)
        if noise is None or noise.shape != (robot.n,) or not (noise > 0.0).all():
            raise InputError(f"--torque-noise: robot {robot.name!r} needs {robot.n} positive numbers")
        return noise, arguments.independent_rate
    if robot.name == "rx90":
        print("dynident: note: no --torque-noise: that of the paper's RX90 is assumed", file=sys.stderr)
        return np.array(trajectories.RX90_NOISE), 250.0
    limits = np.array([joint.limits.torque for joint in robot.joints])
    if not np.isfinite(limits).all():
        raise InputError(
            f"robot {robot.name!r} has no torque limits from which a noise could be guessed: give --torque-noise"
        )
    print(
        f"dynident: note: no --torque-noise: {100 * _NOISE:g} % of the torque limits at {_NOISE_RATE:g} Hz assumed",
        file=sys.stderr,
    )
    return _NOISE * limits, _NOISE_RATE


def _designed(arguments: argparse.Namespace, request: trajectories.NearRequest) -> trajectories.NearDesign:
    """The motion; refused if it does not keep every limit.

    Raises:
        InputError: names the limit.
    """
    with Console(stderr=True).status("building") as status:

        def show(step: trajectories.design.Step) -> None:
            status.update(f"{step.text}, {step.evaluations} evaluations")

        found = trajectories.design_near(request, seed=arguments.seed, starts=arguments.starts or 1, progress=show)
    if not found.design.feasible:
        missed = "; ".join(found.design.score.violations)
        raise InputError(f"no motion was found that keeps every limit, the nearest has: {missed}")
    if found.design.interrupted:
        print("dynident: note: interrupted: this is the best motion so far; it keeps every limit", file=sys.stderr)
    return found


def _write(arguments: argparse.Namespace, found: trajectories.NearDesign) -> None:
    """The motion, its rehearsal and the JSON."""
    robot, bounds = found.request.robot, found.request.limits
    write_formats(
        arguments, report.motions.WrittenMotion(robot, found.motion, bounds, report.near.near_head(found, 1.0))
    )
    rehearsal = arguments.rehearsal
    if rehearsal is None and arguments.csv:
        path = Path(arguments.csv)
        rehearsal = str(path.with_name(f"{path.stem}_rehearsal{path.suffix}"))
    if rehearsal:
        slow = report.motions.WrittenMotion(
            robot, found.motion.slowed(0.1), bounds, report.near.near_head(found, 0.1)
        )
        write_text(rehearsal, report.motions.csv_text(slow, arguments.sample_rate or 250.0))
    if arguments.json:
        report.documents.write_json(arguments.json, report.near.near_document(found))
