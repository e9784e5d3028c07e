"""Options of ``dynident design``: the motion, what is to be learnt, limits and the search."""

from __future__ import annotations

import argparse
from typing import Any

from .values import fraction, gains_list, names_list, number, positive, positive_number, whole

_CRITERIA = ("d", "a", "cond", "cond-scaled")


def shape_arguments(parser: argparse.ArgumentParser) -> None:
    """The motion."""
    group = parser.add_argument_group("motion")
    either = group.add_mutually_exclusive_group()
    either.add_argument("--via-points", type=positive, metavar="N", help="number of points (default: 14)")
    either.add_argument("--fourier", type=positive, metavar="H", help="a Fourier series of H harmonics instead")
    group.add_argument(
        "--segments",
        choices=("quintic", "trapezoid", "blend"),
        help="default: quintic; trapezoid: as movej runs it, at rest in each point; blend: at constant speed from "
        "point to point, with parabolic blends about the points, which are passed",
    )
    group.add_argument(
        "--ramp", type=number, metavar="SHARE", help="of each move's time, in either ramp of a trapezoid (0.25)"
    )
    group.add_argument(
        "--segment-durations",
        type=gains_list,
        metavar="S|S1,S2,..",
        help="fixed times from point to point, one for all or one each (default: free)",
    )
    group.add_argument("--rest", action="store_true", help="rest in each via point instead of passing it")
    group.add_argument(
        "--duration", type=positive_number, metavar="S", help="period of --fourier (default: 10), or of --near (30)"
    )
    group.add_argument("--max-duration", type=positive_number, metavar="S", help="longest time through via points")
    group.add_argument("--start", type=gains_list, metavar="Q1,Q2,..", help="where it starts [deg or m]")


def goal_arguments(parser: argparse.ArgumentParser) -> None:
    """What is to be learnt."""
    group = parser.add_argument_group("what to learn")
    group.add_argument(
        "--criterion",
        choices=_CRITERIA,
        default="d",
        help="d: information (default); a: relative sigma; cond: condition number; cond-scaled: columns scaled",
    )
    group.add_argument(
        "--columns", type=names_list, metavar="NAME,..", help="parameters to be estimated (default: base)"
    )
    group.add_argument(
        "--parameters", type=names_list, metavar="NAME,..", help="those that count, for d and a (default: all)"
    )
    group.add_argument("--payload-only", action="store_true", help="the payload's ten, the robot being known")
    group.add_argument(
        "--data-from",
        action="append",
        metavar="F",
        help="what was learnt before: --npz of identify or payload, or --json of identify (d and a); repeatable",
    )
    group.add_argument("--data-length", type=positive_number, metavar="S", help="of the recording to come")
    group.add_argument(
        "--torque-noise",
        type=noise_level,
        metavar="S1,S2,..",
        help="sigma per joint [N·m or N], or 10%% of the limits",
    )
    group.add_argument(
        "--independent-rate",
        type=positive_number,
        default=100.0,
        metavar="HZ",
        help="independent samples a second (default: 100)",
    )


def limit_arguments(parser: argparse.ArgumentParser) -> None:
    """What the motion keeps."""
    group = parser.add_argument_group("limits", "positions and speeds stand in the robot's file")
    group.add_argument(
        "--speed-override", type=number, default=1.0, metavar="SHARE", help="of the speed (default: 1)"
    )
    group.add_argument(
        "--acceleration",
        type=acceleration_limit,
        metavar="A1,A2,..",
        help="[deg/s² or m/s²], or 3x: three times the speed limit per second",
    )
    group.add_argument(
        "--torque-limits",
        type=torque_list,
        metavar="T1,T2,..",
        help="[N·m or N], or none: not even those of the robot's file",
    )
    group.add_argument("--robot-parameters", metavar="JSON", help="of identify: for torques and relative sigma")
    group.add_argument(
        "--heaviest-payload", metavar="KG[@X,Y,Z]|TOML", help="torque limits hold without it and with it"
    )
    group.add_argument("--scene", metavar="TOML", help="floor, walls, and bodies that keep clear of each other")


def search_arguments(parser: argparse.ArgumentParser) -> None:
    """How to search, and what to judge instead."""
    group = parser.add_argument_group("search")
    group.add_argument("--seed", type=whole, default=0, help="of the random starts (default: 0)")
    group.add_argument(
        "--starts", type=positive, metavar="K", help="random starts (default: 6 by d and a, else 3; 1 with --near)"
    )
    group.add_argument(
        "--solver",
        choices=("auto", "augmented", "ipopt"),
        help="augmented: an augmented Lagrangian and L-BFGS; ipopt: the interior point method, slower; "
        "default: auto, the one that measured best",
    )
    group.add_argument("--bound", action="store_true", help="estimate the floor over all motions, and the gap")
    group.add_argument(
        "--evaluate", metavar="LOG", help="judge the motion of a log or of a CSV instead of designing one"
    )
    group.add_argument("--log-map", metavar="TOML", help="of --evaluate: columns, units and signs of the log")
    group.add_argument("--cutoff", type=positive_number, metavar="HZ", help="of --evaluate: low-pass on positions")


def acceleration_limit(text: str) -> Any:
    """ "3x": times the speed limit per second (a float); or a number per joint (a tuple)."""
    if text.lower().endswith("x"):
        try:
            factor = float(text[:-1])
        except ValueError:
            factor = -1.0
        if not 0.0 < factor < 1e6:
            raise argparse.ArgumentTypeError(f"{text!r} is not a factor such as 3x")
        return factor
    return gains_list(text)


def torque_list(text: str) -> tuple[float, ...] | str:
    """ "none"; or a number per joint."""
    return text if text == "none" else gains_list(text)


def noise_level(text: str) -> Any:
    """ "10%": of the torque limits (a float); or a number per joint (a tuple)."""
    return fraction(text) if text.strip().endswith("%") else gains_list(text)
