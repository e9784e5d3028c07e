"""Simulators read a whole robot back: bodies, drives and limits by name, in SI units and the links' frames."""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from dynident.common.arrays import Array


class Body(NamedTuple):
    """Mass [kg], centre of mass [m], inertia there in the link's axes [kg m^2]."""

    mass: float
    com: Array
    inertia: Array


class Read(NamedTuple):
    """What a simulator holds of a robot; ``drives``: numbers of each joint by their names."""

    bodies: dict[str, Body]
    drives: dict[str, dict[str, float]]


def by_mujoco(text: str) -> Read:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(text)
    bodies = {}
    for k in range(1, model.nbody):
        nine = np.zeros(9)
        mujoco.mju_quat2Mat(nine, model.body_iquat[k])
        R = nine.reshape(3, 3)
        inertia = R @ np.diag(model.body_inertia[k]) @ R.T
        bodies[model.body(k).name] = Body(float(model.body_mass[k]), model.body_ipos[k].copy(), inertia)
    drives = {}
    for k in range(model.njnt):
        joint, dof = model.joint(k), model.jnt_dofadr[k]
        drives[joint.name] = {
            "armature": float(model.dof_armature[dof]),
            "damping": float(np.ravel(model.dof_damping[dof])[0]),
            "friction": float(model.dof_frictionloss[dof]),
        } | ({"low": float(joint.range[0]), "high": float(joint.range[1])} if model.jnt_limited[k] else {})
    for k in range(model.nu):
        limited = bool(model.actuator_ctrllimited[k])
        name = model.joint(int(model.actuator_trnid[k, 0])).name
        drives[name] |= {"torque": float(model.actuator_ctrlrange[k, 1])} if limited else {}
        drives[name]["offset"] = -float(model.actuator_biasprm[k, 0])
    return Read(bodies, drives)


def by_drake(text: str, kind: str) -> Read:
    pytest.importorskip("pydrake")
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.001)
    (instance,) = Parser(plant).AddModelsFromString(text, kind)
    context = plant.finalized_context() if hasattr(plant, "finalized_context") else _finalized(plant)
    bodies, drives = {}, {}
    for index in plant.GetBodyIndices(instance):
        body = plant.get_body(index)
        spatial = body.CalcSpatialInertiaInBodyFrame(context)
        inertia = spatial.Shift(spatial.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        bodies[body.name()] = Body(
            spatial.get_mass(), np.asarray(spatial.get_com(), dtype=float), np.asarray(inertia, dtype=float)
        )
    for number in plant.GetJointActuatorIndices(instance):
        actuator = plant.get_joint_actuator(number)
        joint = actuator.joint()
        drives[joint.name()] = {
            "armature": actuator.calc_reflected_inertia(context),
            "torque": actuator.effort_limit(),
            "damping": joint.default_damping_vector()[0],
            "low": joint.position_lower_limits()[0],
            "high": joint.position_upper_limits()[0],
            "speed": joint.velocity_upper_limits()[0],
            "acceleration": joint.acceleration_upper_limits()[0],
        }
    return Read(bodies, {name: {k: v for k, v in d.items() if math.isfinite(v)} for name, d in drives.items()})


def _finalized(plant: Any) -> Any:
    plant.Finalize()
    return plant.CreateDefaultContext()


def by_pinocchio(text: str) -> Read:
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(text)
    bodies, drives = {}, {}
    for k in range(1, model.njoints):
        spatial = model.inertias[k]
        name = model.names[k]
        bodies[name] = Body(spatial.mass, spatial.lever.copy(), spatial.inertia.copy())
        place, v = model.joints[k].idx_q, model.joints[k].idx_v
        drives[name] = {
            "speed": model.velocityLimit[v],
            "torque": model.effortLimit[v],
            "damping": model.damping[v],
            "friction": model.friction[v] if hasattr(model, "friction") else model.upperDryFrictionLimit[v],
        }
        if model.joints[k].nq == 1:
            drives[name] |= {"low": model.lowerPositionLimit[place], "high": model.upperPositionLimit[place]}
    return Read(bodies, drives)


def by_usd(text: str, folder: Path) -> Read:
    pytest.importorskip("pxr")
    from pxr import Usd, UsdPhysics

    path = folder / "robot.usda"
    path.write_text(text, encoding="utf-8")
    stage = Usd.Stage.Open(str(path))
    bodies, drives = {}, {}
    for prim in stage.Traverse():
        custom = prim.GetCustomDataByKey("dynident")
        if prim.HasAPI(UsdPhysics.MassAPI):
            mass = UsdPhysics.MassAPI(prim)
            q = mass.GetPrincipalAxesAttr().Get()
            R = _matrix(q.GetReal(), *q.GetImaginary())
            inertia = R @ np.diag(mass.GetDiagonalInertiaAttr().Get()) @ R.T
            com = np.array(mass.GetCenterOfMassAttr().Get())
            bodies[custom["name"]] = Body(mass.GetMassAttr().Get(), com, inertia)
        elif prim.IsA(UsdPhysics.RevoluteJoint) or prim.IsA(UsdPhysics.PrismaticJoint):
            axis, unit = ("angular", math.pi / 180.0) if prim.IsA(UsdPhysics.RevoluteJoint) else ("linear", 1.0)
            own = f"physxJointAxis:{axis}"
            scaled = {
                "low": ("physics:lowerLimit", unit),
                "high": ("physics:upperLimit", unit),
                "speed": (f"{own}:maxJointVelocity", unit),
                "torque": (f"drive:{axis}:physics:maxForce", 1.0),
                "armature": (f"{own}:armature", 1.0),
                "friction": (f"{own}:dynamicFrictionEffort", 1.0),
                "damping": (f"{own}:viscousFrictionCoefficient", 1.0 / unit),
            }
            attributes = {
                quantity: (prim.GetAttribute(name), factor) for quantity, (name, factor) in scaled.items()
            }
            drives[custom["name"]] = {
                quantity: attribute.Get() * factor
                for quantity, (attribute, factor) in attributes.items()
                if attribute and attribute.HasAuthoredValue()
            }
    return Read(bodies, drives)


def _matrix(w: float, x: float, y: float, z: float) -> Array:
    v = np.array([x, y, z])
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R: Array = (w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v) + 2.0 * w * cross
    return R
