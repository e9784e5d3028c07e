"""The commands, one a file: ``run`` takes its options and hands values from room to room.

Only the file of the command that is called is imported, so that ``dynident --help`` answers at once.
"""

ANSWERED, DO_NOT_USE, BAD_INPUT, INTERNAL_ERROR, INTERRUPTED, BROKEN_PIPE = 0, 1, 2, 3, 130, 141
"""Exit statuses of every command."""
COMMANDS = {
    "weigh": ("payload:run_weigh", "Weigh a payload by a short motion near a pose."),
    "verify": ("check:run_verify", "Compare following errors before and after a payload was entered."),
    "payload": ("payload:run", "Identify a payload from recordings with and without it."),
    "identify": ("identify:run", "Identify the robot's own parameters, without payload."),
    "rollout": ("identify:run_rollout", "Compare the identified robot's motion with a recording's."),
    "gains": ("gains:run", "Identify drive gains from currents and a payload of known mass."),
    "record": ("controller:run_record", "Record from the robot itself, over the network."),
    "apply": ("controller:run_apply", "Write an identified payload into the controller, over the network."),
    "compare": ("fleet:run_compare", "Compare recordings of one robot: the odd one, and in what."),
    "fleet": ("", "Compare many recordings of many robots, reduced in parallel."),
    "fleet reduce": ("fleet:run_reduce", "Reduce each recording to its equations in a store."),
    "fleet report": ("fleet:run_report", "Changes of friction, payload and scales."),
    "check": (
        "check:run",
        "Look at logs: their contents, and what looks wrong.\n\nAnd how surely they show each base parameter. "
        "Whether order, senses and zeros of the joints are the robot's, and whether forward kinematics "
        "reproduces a logged tool pose, is for 'dynident robot check'.",
    ),
    "export": ("export:run", "Write an identified payload for a controller or a simulator."),
    "robot": ("", "Show a robot, make a new one, check its kinematics by a recording."),
    "robot list": ("robot:run_list", "List the shipped robots."),
    "robot show": ("robot:run_show", "Show table, limits and frames of a robot, and draw it."),
    "robot new": (
        "robot:run_new",
        "Make a robot's file from a data sheet.\n\nTake any pose in which the data sheet draws the arm. x, y, z "
        "are those of the base: z up along the mounting, x to the front. For every joint, base to tip, give the "
        "direction of its axis (by the right-hand rule: thumb along it, the fingers turn the way the sheet "
        "counts positive) and any point on the axis; then the flange. Where the modified DH table is known, "
        "--template gives its file to fill in; it shows every key that a robot's file may have.",
    ),
    "robot check": (
        "robot:run_check",
        "Check order, senses and zeros of the joints by tool poses or torques.\n\nWhere a log carries the pose "
        "of the tool (columns x, y, z and qx, qy, qz, qw, or [pose] of the log map), forward kinematics must "
        "reproduce it: the residual is told with the constant base and tool that fit best. Where it carries "
        "torques or currents, recorded without payload, other orders, senses and zeros of the joints are ranked "
        "by what the robot's model leaves unexplained. The best one is suggested, never applied. Exit status 1 "
        "if the pose is not reproduced within 5 mm and 1 degree, or if another reading does clearly better.",
    ),
    "robot export": ("robot:run_export", "Write the whole robot as MJCF, USD, URDF or SDFormat."),
    "codegen": ("robot:run_codegen", "Write a function of the robot as self-contained C."),
    "design": ("design:run", "Find the most informative motion within the robot's limits."),
    "near": ("near:run", "Find a short motion about a pose, for weigh, and what it will show."),
    "score": ("design:run_score", "Judge a motion: what it teaches, and the limits it keeps."),
    "simulate": ("simulate:run", "Simulate recordings of a robot with known parameters."),
    "demo": ("demo:run", "The paper's experiment on a simulated RX90."),
}
"""Each command, where it is, and what it does, in the order of ``dynident --help``."""
