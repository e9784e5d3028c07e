"""The commands, one a file: ``run`` takes its options and hands values from room to room.

Only the file of the command that is called is imported, so that ``dynident --help`` answers at once.
"""

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


def answered(level: str) -> int:
    """Exit status of an answer with a verdict of this level."""
    return DO_NOT_USE if level == "do_not_use" else ANSWERED
