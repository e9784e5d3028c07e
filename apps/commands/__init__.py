"""The commands, those alike in one file: each takes its options and hands values from room to room.

Only the file of the command that is called is imported, so that ``dynident --help`` answers at once.
"""

ANSWERED, DO_NOT_USE, BAD_INPUT, INTERNAL_ERROR, INTERRUPTED, BROKEN_PIPE = 0, 1, 2, 3, 130, 141
"""Exit statuses of every command."""
COMMANDS = {
    "weigh": ("payload:_Weigh", "Identify a payload from a short motion near a pose, or at rest."),
    "verify": ("check:_Verify", "Compare the following error before and after a payload was entered."),
    "payload": ("payload:_Payload", "Identify a payload from recordings with and without it."),
    "identify": ("identify:_Identify", "Identify the robot itself from recordings without payload."),
    "rollout": ("identify:_Rollout", "Test how well the identified robot predicts a recorded motion."),
    "gains": ("identify:_Gains", "Identify drive gains from currents and a payload of known mass."),
    "record": ("export:_Record", "Record from a robot controller over the network."),
    "apply": ("export:_Apply", "Set an identified payload in a robot controller over the network."),
    "compare": ("check:_Compare", "Compare recordings of one robot and name the odd one out."),
    "fleet": ("", "Compare many recordings of many robots."),
    "fleet reduce": ("check:_Reduce", "Reduce recordings to their equations and add them to a store."),
    "fleet report": ("check:_FleetReport", "Report changes of friction, payload and drive scales."),
    "check": (
        "check:_Check",
        "Check recordings: how they are read, and what looks wrong.\n\nAlso shows how well they determine each "
        "base parameter. 'dynident robot check' tests the order, signs and zeros of the joints, and whether "
        "forward kinematics reproduces a logged tool pose.",
    ),
    "export": ("export:_Export", "Write an identified payload for a controller or a simulator."),
    "robot": ("", "List, show, create, check and export robots."),
    "robot list": ("robot:run_list", "List the included robots."),
    "robot show": ("robot:_Show", "Show a robot's parameters, limits and frames, and draw it."),
    "robot new": (
        "robot:_New",
        "Create a robot's file from a data sheet.\n\nTake any pose in which the data sheet draws the arm. x, y, z "
        "are those of the base: z up along the mounting, x forward. For every joint, base to tip, give the "
        "direction of its axis (right-hand rule: thumb along the axis, fingers in the positive direction of the "
        "sheet) and any point on it; then the flange. If you know the modified DH table, use --template and fill "
        "in the file; it shows every possible key.",
    ),
    "robot check": (
        "robot:_RobotCheck",
        "Check order, signs and zeros of the joints by tool poses or torques.\n\nIf a log contains the pose of "
        "the tool (columns x, y, z and qx, qy, qz, qw, or [pose] of the log map), forward kinematics must "
        "reproduce it up to a constant base and tool, which are fitted. If it contains torques or currents, "
        "recorded without payload, other orders, signs and zeros of the joints are ranked by the torque that "
        "the robot's model leaves unexplained. The best one is suggested, never applied. Exit status 1 if the "
        "pose is not reproduced within 5 mm and 1 degree, or if another reading fits clearly better.",
    ),
    "robot export": ("robot:_RobotExport", "Write the whole identified robot as MJCF, USD, URDF or SDFormat."),
    "codegen": ("robot:_Codegen", "Write the robot's dynamics as self-contained C or NumPy code."),
    "design": ("design:_Design", "Design the most informative motion within the robot's limits."),
    "near": ("design:_Near", "Design a short motion near a pose, or poses at rest, for weigh."),
    "score": ("design:_Score", "Judge a motion: its accuracy, and the limits it keeps."),
    "simulate": ("simulate:_Simulate", "Simulate recordings of a robot with known parameters."),
    "demo": ("simulate:_Demo", "Run the paper's experiment on a simulated RX90."),
}
"""Each command, where it is, and what it does, in the order of ``dynident --help``."""
