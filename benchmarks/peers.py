"""Other people's software, set up for the robots of this package."""

import numpy as np
import pinocchio as pin
from dynident.model import Robot


def pinocchio_model(robot: Robot) -> pin.Model:
    """The chain of revolute joints in modified DH, with random bodies."""
    model, parent = pin.Model(), 0
    for number, joint in enumerate(robot.joints, start=1):
        before = pin.SE3(pin.utils.rotate("x", joint.alpha), np.array([joint.d, 0.0, 0.0]))
        after = pin.SE3(np.eye(3), np.array([0.0, 0.0, joint.r]))
        parent = model.addJoint(parent, pin.JointModelRZ(), before * after, f"joint{number}")
        model.appendBodyToJoint(parent, pin.Inertia.Random(), pin.SE3.Identity())
    return model
