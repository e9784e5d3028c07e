"""A payload from the last seconds of a stream: blocks of equations come in front, the oldest go.

What is solved is the problem of ``weigh`` with the robot's parameters known, of the blocks that are in the window.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model import Processing, Robot, base_parameters
from ...model.inertia import payload_spread
from ...model.motion import Measurement
from ...model.names import parameter_kind
from ..equations.equations import PAYLOAD
from ..equations.observation import Observation
from ..equations.reduction import unreduced
from ..fit.drive_gains import Gains
from ..fit.estimate import Estimate, error_model
from ..fit.robust import student95
from .constant_torques import HeldFriction, held_friction, less_robot
from .friction import FRICTION_CHANGE, friction_sigmas
from .methods import METHODS, by_memory
from .problem import PayloadProblem
from .short_motion import Run, at_rest, seen_moving, telling_rows
from .weighing import observer_of, weighing_problem

_FEWEST = 3
"""Blocks: fewer say nothing of their own noise."""


@dataclass(frozen=True, eq=False)
class Block:
    """Equations of a stretch of time in which the robot moved.

    Attributes:
        start: its beginning [s].
        stop: its end [s].
        moving: numbers of the joints whose rows are used.
        equations: [W, what is free, ``PAYLOAD``], held whole.
        squares: sum of the squared torque of each joint's rows, shape (n,).
        samples: number of those.
    """

    start: float
    stop: float
    moving: tuple[int, ...]
    equations: Observation
    squares: Array
    samples: Array


class Weighed(NamedTuple):
    """What the window says of the payload.

    ``mass`` [kg] and its 95 % interval, nan where it is not visible; ``com`` [m] and ``com_sigma``, nan and inf
    where not visible; ``hidden``: what is in the way, empty where the mass is visible; ``seconds`` of motion;
    ``by_gains``: half of the interval that errors of the drive gains alone leave, however long the motion [kg].
    """

    mass: float
    low: float
    high: float
    com: Array
    com_sigma: Array
    seconds: float
    hidden: str = ""
    by_gains: float = 0.0

    @property
    def half_width(self) -> float:
        """Half of the mass's interval [kg]."""
        return 0.5 * (self.high - self.low)


class _Made(NamedTuple):
    """What all blocks hold together: the equations, those less the robot's torque, and how friction is held."""

    observation: Observation
    less: Observation
    held: HeldFriction | None = None


class MovingWindow:
    """The last blocks of a stream, and the payload by them.

    Attributes:
        length: of motion that is kept [s].
        gains: uncertainty of the drive gains; None where they are taken as exact.
        blocks: in the window.
        sigmas: standard deviations of what friction may differ by, by name [N·m or N, or per speed].
    """

    def __init__(
        self,
        robot: Robot,
        known: Estimate,
        processing: Processing | None = None,
        length: float = 20.0,
        friction_change: float = FRICTION_CHANGE,
        gains: Gains | None = None,
    ) -> None:
        """Begin an empty one.

        Args:
            known: its parameters by an earlier identification.
            processing: settings; the robot's own by default.
            length: of motion that is kept [s].
            friction_change: by which share friction may differ from the robot's own (1 sigma); 0 for not at all.
        """
        self.robot, self.known, self.length = robot, known, length
        self.processing = processing or robot.processing
        self.blocks: deque[Block] = deque()
        self._made: _Made | None = None
        self._base = base_parameters(robot)
        self._observer = observer_of(robot, self._base, friction_change > 0.0)
        self.gains = gains
        sigmas = friction_sigmas(known, friction_change)
        self.sigmas = {name: sigma for name, sigma in sigmas.items() if parameter_kind(name) in ("FS", "FV", "OFF")}

    def block(self, data: Measurement) -> Block | None:
        """The equations of a stretch of time; None where no joint moves in it."""
        motion = data.motion
        moving = seen_moving([motion], self.processing.still_speed)
        if not moving:
            return None
        still = at_rest(data, moving)
        keep = telling_rows(still.motion, moving, self.processing, ends=True)
        if not keep.any():
            return None
        equations = self._observer.observe_rows(still, keep, self.processing.thinning(motion.rate))
        squares = np.where(keep, still.torque**2, 0.0).sum(axis=0)
        start = float(motion.t[0])
        stop = start + len(motion.t) / motion.rate
        return Block(start, stop, moving, equations, squares, keep.sum(axis=0))

    def add(self, block: Block) -> None:
        """Put the newest block in front, and drop the oldest where there is more than the window's length."""
        self._made = None
        self.blocks.append(block)
        while self.seconds > self.length * (1.0 + 1e-9) and len(self.blocks) > 1:
            self.blocks.popleft()

    def since(self, time: float) -> None:
        """Drop the blocks that began before a time [s]."""
        self._made = None
        self.blocks = deque(block for block in self.blocks if block.start >= time)

    @property
    def seconds(self) -> float:
        """Motion in the window [s]."""
        return sum(block.stop - block.start for block in self.blocks)

    @property
    def observation(self) -> Observation:
        """All equations of the window."""
        return self._equations.observation

    @property
    def less(self) -> Observation:
        """All equations of the window less the robot's torque."""
        return self._equations.less

    @property
    def held(self) -> HeldFriction:
        """How friction is held, and the size and memory of the errors, by all blocks."""
        equations = self._equations
        if equations.held is None:
            equations = equations._replace(
                held=held_friction([equations.less], self.sigmas, [unreduced(equations.less)])
            )
            self._made = equations
        assert equations.held is not None
        return equations.held

    @property
    def _equations(self) -> "_Made":
        """What several questions to the same blocks have in common, made once."""
        if self._made is None:
            first, *others = (block.equations for block in self.blocks)
            whole = first.followed_by(others)
            self._made = _Made(whole, less_robot(whole, self.known.values))
        return self._made

    def problem(self) -> PayloadProblem:
        """The payload problem of the window: that of ``weigh`` by the robot's parameters.

        Raises:
            InputError: if it cannot be posed.
        """
        squares = np.sum([block.squares for block in self.blocks], axis=0)
        samples = np.sum([block.samples for block in self.blocks], axis=0)
        rms = np.sqrt(squares / np.maximum(samples, 1))
        moving = tuple(sorted(set().union(*(block.moving for block in self.blocks))))
        run = Run("live", unreduced(self.observation))
        return weighing_problem(self.robot, self._base, [run], moving, self.held, rms, None, self.known)

    def weighed(self) -> Weighed:
        """The payload by the blocks in the window, with the interval that the memory of errors allows."""
        nothing = Weighed(np.nan, np.nan, np.nan, np.full(3, np.nan), np.full(3, np.inf), self.seconds)
        if len(self.blocks) < _FEWEST:
            return nothing._replace(hidden="not visible yet: keep moving" if self.blocks else "no joint moves")
        try:
            problem = self.problem()
            short = problem.short
            assert short is not None
            if not short.visibility.mass_visible:
                return nothing._replace(hidden=_hidden(short.visibility.joints, self.robot.n))
            posed = METHODS[1](problem)
            estimate = posed.solved()
        except InputError:  # too few rows, or of too few kinds: more motion mends both
            return nothing._replace(hidden="not visible yet: keep moving")
        estimate = replace(estimate, robust=by_memory(problem, posed, estimate))
        resolved = short.resolved(estimate, None)
        model = error_model(resolved, self.gains)
        places = [PAYLOAD.index(name) for name in model.names]
        ten = np.full(10, np.nan)
        ten[places] = model.values
        spread = payload_spread(ten, model.covariance, places)
        half = student95(model.degrees_of_freedom) * spread.mass
        mass = float(ten[9])
        com = ten[6:9] / mass
        return Weighed(
            mass, mass - half, mass + half, com, spread.com, self.seconds, by_gains=self._by_gains(resolved)
        )

    def _by_gains(self, payload: Estimate) -> float:
        """Half of the mass's interval by errors of the drive gains alone [kg]."""
        S = payload.gain_sensitivity
        if self.gains is None or S is None:
            return 0.0
        own = S[payload.names.index("M_L")]
        return float(student95(np.inf) * np.sqrt(own @ self.gains.covariance(len(own)) @ own))


def _hidden(joints: Sequence[int], n: int) -> str:
    """What to do where the moving joints do not show the mass."""
    arm = [joint for joint in (3, 2) if joint <= n and joint not in joints]
    return f"not visible yet: move joint {arm[0]}" if arm else "not visible yet: go farther, turn the wrist"
