"""Fleets that never were, with the truth beside: arms of a type, their days, wear, payloads, and lost logs.

Everything is drawn: each arm's parameters about its type's, each day's temperature and friction, which arms change
and when. Each arm draws from a seed of its own, so that more arms or days leave the first ones as they are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date, timedelta
from typing import Literal

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.schema import Document
from ...model import InertialParameters, Robot
from ...model.names import parameter_kind

USUAL = 20.0
"""Temperature at which friction is as the arm's parameters tell [deg C]."""
COULOMB, VISCOUS = ("FS", "FSM"), ("FV", "FVM")
_WARMTH = 3.0  # K, standard deviation of a day's temperature
_EARLIEST = 0.5  # share of the days before any change
_BOX = 0.05  # m, half the length of the cube that an untold payload is
_LEFT = 9  # lines of a log that was cut
Log = Literal["good", "missing", "cut", "clock"]


@dataclass(frozen=True)
class Scenario:
    """What a simulated fleet goes through.

    Attributes:
        arms: of each type.
        days: one recording each.
        first: day of the first.
        coulomb, viscous: standard deviation of the frictions' share from day to day.
        memory: of that scatter, phi.
        per_kelvin: by which share friction falls with each kelvin.
        apart: standard deviation of the twins' parameters, as a share.
        worn: arms of each type whose Coulomb friction of one axis changes.
        wear: by which share.
        laden: arms of each type that carry a payload from some day on, which the controller is not told.
        load: its mass [kg].
        replaced: arms of each type that are replaced by another of the same name.
        missing, damaged: shares of the logs that are not there, or not as they were written.
        seed: of all that is drawn.
    """

    arms: int = 3
    days: int = 14
    first: date = date(2026, 1, 1)
    coulomb: float = 0.03
    viscous: float = 0.04
    memory: float = 0.5
    per_kelvin: float = 0.01
    apart: float = 0.05
    worn: int = 1
    wear: float = 0.3
    laden: int = 1
    load: float = 1.0
    replaced: int = 0
    missing: float = 0.0
    damaged: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse more changes than arms, and scatter that cannot be."""
        if self.worn + self.laden + self.replaced > self.arms:
            changed = f"{self.worn} worn, {self.laden} laden and {self.replaced} replaced"
            raise InputError(f"{changed} of {self.arms} arms: an arm changes once at most; give more arms")
        if not 0.0 <= self.memory < 1.0:
            raise InputError(f"a memory of {self.memory:g}: give a number from 0 to below 1")
        if self.missing + self.damaged > 1.0:
            raise InputError("more than all logs would be missing or damaged")


class Event(Document, frozen=True):
    """What happens to an arm: ``what`` ("wear", "payload" or "replaced"), since which ``day``, and by how much.

    ``quantity``: the friction that wears ("FS2"), else empty; ``size``: a share for wear, kg for a payload.
    """

    what: str
    day: str
    quantity: str
    size: float


@dataclass(frozen=True)
class TrueNight:
    """A day of an arm, as it was.

    Attributes:
        day: ISO date.
        temperature: [deg C].
        carried: mass that the controller was not told [kg].
        log: whether its recording is good, missing, cut short, or of a clock that runs back.
        parameters: the arm's standard parameters that day, friction as it was.
    """

    day: str
    temperature: float
    carried: float
    log: Log
    parameters: Mapping[str, float]

    @property
    def payload(self) -> InertialParameters | None:
        """What was carried untold: a cube that stands on the flange; None without."""
        if not self.carried:
            return None
        inertia = self.carried * (2.0 * _BOX) ** 2 / 6.0 * np.eye(3)
        return InertialParameters.from_com(self.carried, np.array([0.0, 0.0, _BOX]), inertia)


@dataclass(frozen=True)
class TrueArm:
    """An arm of a simulated fleet: its name, what happens to it (None: nothing), its parameters, and its days."""

    name: str
    event: Event | None
    parameters: Mapping[str, float]
    nights: tuple[TrueNight, ...]


def simulated_arms(robot: Robot, scenario: Scenario) -> tuple[TrueArm, ...]:
    """All arms of a type, day by day.

    Args:
        robot: the type, with standard parameters.
    """
    changes = ["wear"] * scenario.worn + ["payload"] * scenario.laden + ["replaced"] * scenario.replaced
    order = _draw(robot, scenario, 0).permutation(scenario.arms)
    events = {int(arm): change for arm, change in zip(order, changes, strict=False)}
    return tuple(_arm(robot, scenario, k, events.get(k, "")) for k in range(scenario.arms))


def _draw(robot: Robot, scenario: Scenario, which: int) -> np.random.Generator:
    return np.random.default_rng([scenario.seed, which, *robot.name.encode()])


def _arm(robot: Robot, scenario: Scenario, k: int, kind: str) -> TrueArm:
    draw = _draw(robot, scenario, k + 1)
    days = [(scenario.first + timedelta(days=d)).isoformat() for d in range(scenario.days)]
    own, successor = (_twin(robot, scenario.apart, draw) for _ in range(2))
    rubbing = [name for name in own if parameter_kind(name) in (*COULOMB, *VISCOUS)]
    since = int(draw.integers(int(_EARLIEST * scenario.days), scenario.days))
    event = _event(robot, scenario, kind, days[since], draw)
    warm = np.round(USUAL + _WARMTH * draw.standard_normal(scenario.days), 1)
    scatter = _scatter(scenario, rubbing, draw)
    logs = _logs(scenario, draw)
    nights = []
    for d, day in enumerate(days):
        changed = d >= since
        shares = 1.0 + scatter[d] - scenario.per_kelvin * (warm[d] - USUAL)
        bodies = successor if kind == "replaced" and changed else own
        parameters = _rubbing_otherwise(bodies, rubbing, shares, event if changed else None)
        carried = scenario.load if kind == "payload" and changed else 0.0
        nights.append(TrueNight(day, float(warm[d]), carried, logs[d], parameters))
    return TrueArm(f"arm{k + 1:03d}", event, own, tuple(nights))


def _rubbing_otherwise(
    own: Mapping[str, float], rubbing: Sequence[str], shares: Array, event: Event | None
) -> dict[str, float]:
    """An arm's parameters on a day: each friction times its share, and what an event wears."""
    parameters = dict(own)
    for name, share in zip(rubbing, shares, strict=True):
        parameters[name] *= max(share, 0.0)
    if event is not None and event.quantity:
        parameters[event.quantity] *= 1.0 + event.size
    return parameters


def _twin(robot: Robot, apart: float, draw: np.random.Generator) -> dict[str, float]:
    """Parameters of an arm of the type: each body scaled as a whole, so that it stays one, friction one by one."""
    bodies = 1.0 + apart * draw.standard_normal(robot.n)
    parameters = {}
    for name, value in robot.parameters.items():
        kind = parameter_kind(name)
        alone = float(1.0 + apart * draw.standard_normal())
        rubs = kind in (*COULOMB, *VISCOUS)
        parameters[name] = float(value) * max(alone if rubs else float(bodies[int(name[len(kind) :]) - 1]), 0.1)
    return parameters


def _event(robot: Robot, scenario: Scenario, kind: str, day: str, draw: np.random.Generator) -> Event | None:
    if kind == "wear":
        dry = [name for name, value in robot.parameters.items() if parameter_kind(name) == "FS" and value > 0.0]
        if not dry:
            raise InputError(f"robot {robot.name!r} has no Coulomb friction that could change: give --worn 0")
        return Event(kind, day, str(draw.choice(dry)), scenario.wear)
    return Event(kind, day, "", scenario.load if kind == "payload" else 0.0) if kind else None


def _scatter(scenario: Scenario, names: list[str], draw: np.random.Generator) -> Array:
    """Share by which each friction differs each day, shape (days, len(names)): a process that remembers."""
    sigma = np.array([scenario.coulomb if parameter_kind(name) in COULOMB else scenario.viscous for name in names])
    x = draw.standard_normal((scenario.days, len(names)))
    for d in range(1, scenario.days):
        x[d] = scenario.memory * x[d - 1] + np.sqrt(1.0 - scenario.memory**2) * x[d]
    return np.asarray(sigma * x)


def _logs(scenario: Scenario, draw: np.random.Generator) -> list[Log]:
    chances = draw.random((scenario.days, 2))
    kinds: list[Log] = []
    for chance, half in chances:
        damaged = chance < scenario.missing + scenario.damaged
        bad: Log = "cut" if half < 0.5 else "clock"
        kinds.append("missing" if chance < scenario.missing else bad if damaged else "good")
    return kinds


def damaged(text: str, log: Log) -> str:
    """A log's text as it is found: cut after its first rows, or with a clock that runs back halfway."""
    lines = text.splitlines(keepends=True)
    half = len(lines) // 2
    if log == "cut":
        return "".join(lines[:_LEFT]) + lines[_LEFT].rpartition(",")[0]
    if log == "clock":
        back = lines[half - 5].partition(",")[0]
        lines[half] = back + "," + lines[half].partition(",")[2]
    return "".join(lines)
