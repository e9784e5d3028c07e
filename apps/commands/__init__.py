"""The commands, one a file: ``run`` takes its options and hands values from room to room.

Only the file of the command that is called is imported, so that ``dynident --help`` answers at once.
"""

import shlex
from collections.abc import Sequence

ANSWERED, DO_NOT_USE, BAD_INPUT, INTERNAL_ERROR, INTERRUPTED, BROKEN_PIPE = 0, 1, 2, 3, 130, 141
"""Exit statuses of every command."""
COMMANDS = {
    "weigh": "what hangs on the flange, from a short motion near a pose",
    "verify": "how much the following error fell after a payload was entered",
    "payload": "identify a payload from recordings with and without it",
    "identify": "identify the robot's own parameters, without payload",
    "rollout": "how far the identified robot's motion strays from a recording's",
    "gains": "identify drive gains from currents and a payload of known mass",
    "record": "record from the robot itself, over the network",
    "apply": "write an identified payload into the controller, over the network",
    "compare": "recordings of one robot side by side: which is the odd one, and in what",
    "fleet": "many recordings of many robots: reduced in parallel, and what changed",
    "check": "look at logs: what was understood, what looks wrong",
    "export": "write an identified payload for a controller or a simulator",
    "robot": "show a robot, make a new one, check its kinematics by a recording",
    "codegen": "write a function of the robot as self-contained C",
    "design": "the most informative motion within the robot's limits",
    "near": "a short motion about a pose, for weigh: what it will show, and the motion",
    "score": "what a motion teaches, and whether it keeps the limits",
    "simulate": "recordings of a robot with known parameters under its controller",
    "demo": "the paper's experiment on a simulated RX90",
}
"""Each command and what it does, in the order of ``dynident --help``."""

_MOVED = {"--near": ("near", ("--pose",)), "--evaluate": ("score", ())}
"""Options of ``design`` that are commands of their own: the command, and what stands before the option's value."""
_RENAMED = {command: {"--csv": "--samples"} for command in ("design", "near")}
"""Commands, and their options that have another name now."""


def answered(level: str) -> int:
    """Exit status of an answer with a verdict of this level."""
    return DO_NOT_USE if level == "do_not_use" else ANSWERED


def moved(words: Sequence[str]) -> str | None:
    """What to write today instead of a command line of the version before; None for all others."""
    for k, word in enumerate(words[1:], 1):
        option, equals, value = word.partition("=")
        if words[0] == "design" and option in _MOVED:
            command, before = _MOVED[option]
            rest = words[k + 1 :] if value else words[k + 2 :]
            pose = value or "".join(words[k + 1 : k + 2])
            named = [f"{before[0]}={pose}"] if before else [pose]
            today = shlex.join(["dynident", command, *named, *words[1:k], *rest])
            return f"this is a command of its own now: {today}"
        if name := _RENAMED.get(words[0], {}).get(option):
            line = shlex.join(["dynident", *words[:k], f"{name}{equals}{value}", *words[k + 1 :]])
            return f"{option} is called {name} now: {line}"
    return None
