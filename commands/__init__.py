"""The commands, one a file: ``add_parser`` declares the arguments, ``run`` hands values from room to room.

Only the file of the command that is called is imported, so that ``dynident --help`` answers at once.
"""

COMMANDS = {
    "weigh": "what hangs on the flange, from a short motion near a pose",
    "verify": "how much the following error fell after a payload was entered",
    "payload": "identify a payload from recordings with and without it",
    "identify": "identify the robot's own parameters, without payload",
    "gains": "identify drive gains from currents and a payload of known mass",
    "check": "look at logs: what was understood, what looks wrong",
    "export": "write an identified payload for a controller or a simulator",
    "robot": "show a robot, make a new one, check its kinematics by a recording",
    "codegen": "write a function of the robot as self-contained C",
    "design": "the most informative motion within the robot's limits",
    "simulate": "recordings of a robot with known parameters under its controller",
    "demo": "the paper's experiment on a simulated RX90",
}
"""Each command and what it does, in the order of ``dynident --help``."""
