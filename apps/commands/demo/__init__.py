"""``dynident demo``: the paper's experiment on a simulated RX90."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from .. import ANSWERED
from ..options import Options, PageOptions, option
from ..values import positive, share, whole
from .experiment import demonstrate


@dataclass(frozen=True)
class _Demo(Options):
    """The experiment, and where its results go."""

    out: str = option(writes="folder", default="demo", metavar="DIR", help="folder of the results (default: demo)")
    seed: int = option(type=whole, default=0, help="of the trajectories and the noise (default: 0)")
    trajectories: int = option(type=positive, default=18, metavar="N", help="default: 18, as in the paper")
    noise: str = option(
        choices=("paper", "slow", "none"),
        default="paper",
        help="as the paper's robot (default), with a memory of 0.8 s, or none",
    )
    gain_error: float = option(
        type=share, default=0.0, metavar="SHARE", help="of the drive gains, such as 0.02 (default: 0)"
    )


class _Pages(PageOptions):
    """The report and its figures; JSON stands in the folder of the results."""

    WITHOUT: ClassVar[frozenset[str]] = frozenset({"json"})


def run(demo: _Demo, pages: _Pages) -> int:
    """Run it; the report goes into the folder of the results unless another place is named."""
    demonstrate(Path(demo.out), demo.seed, demo.trajectories, demo.noise, demo.gain_error, pages)
    return ANSWERED
