"""An arm from a URDF: what was understood, what can be identified, and what its masses would weigh."""

from pathlib import Path

import numpy as np
from dynident import base_parameters, load_robot
from dynident.model import forward_kinematics, gravity, standard_columns

robot = load_robot(Path("examples") / "robots" / "six_axis.urdf")
print(f"{robot.title}: {robot.n} joints; payloads are given in {robot.payload_frame}")
for j, joint in enumerate(robot.joints, start=1):
    low, high = np.degrees(joint.limits.position)
    print(
        f"  joint {j}: alpha {np.degrees(joint.alpha):6.1f} deg, d {joint.d:.3f} m, "
        f"theta {np.degrees(joint.theta):6.1f} deg, r {joint.r:.3f} m, from {low:.0f} to {high:.0f} deg"
    )
for note in robot.snapped:
    print("  note:", note)

base = base_parameters(robot)
print(f"{len(base.columns)} base parameters; no motion shows {', '.join(base.unidentifiable[:6])}, ...")

# The URDF's masses are a prior: what would hold the arm at its zero pose, had it no friction.
chi = np.array([robot.parameters.get(name, 0.0) for name in standard_columns(robot)])
print("torque by weight at zero [N·m]:", np.array(gravity(robot)(np.zeros(robot.n), chi)).ravel().round(2))
R, p = (np.array(value) for value in forward_kinematics(robot)(np.zeros(robot.n)))
print("frame 6 in frame 0 at zero [m]:", p.ravel().round(3), "z along", R[:, 2].round(3))
