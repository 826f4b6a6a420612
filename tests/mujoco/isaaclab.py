"""Reads an exported Isaac Lab module without Isaac Lab: stand-ins take the fields that its classes have, and no others.

    python isaaclab.py FILE.py

Prints the actuators' groups as JSON: class and fields.
"""

import json
import runpy
import sys
import types

JOINTS = {"joint_names_expr", "stiffness", "damping", "armature", "friction", "dynamic_friction", "viscous_friction",
          "actuator_effort_limit", "actuator_velocity_limit", "joint_effort_limit", "joint_velocity_limit"}


def taking(name, fields):
    def __init__(self, **given):
        unknown = set(given) - set(fields)
        if unknown:
            raise TypeError(f"{name} has no {unknown}")
        self.__dict__.update(given)

    return type(name, (), {"__init__": __init__})


def module(name, **names):
    made = types.ModuleType(name)
    made.__dict__.update(names)
    sys.modules[name] = made
    return made


drive = taking("JointDriveCfg", {"target_type", "gains", "drive_type"})
drive.PDGainsCfg = taking("PDGainsCfg", {"stiffness", "damping"})
converter = taking("UrdfConverterCfg", set())
converter.JointDriveCfg = drive
sim = module("isaaclab.sim", UrdfConverterCfg=converter, UrdfFileCfg=taking("UrdfFileCfg", {"asset_path", "fix_base", "joint_drive"}))
actuators = module("isaaclab.actuators", ImplicitActuatorCfg=taking("ImplicitActuatorCfg", JOINTS),
                   DelayedPDActuatorCfg=taking("DelayedPDActuatorCfg", JOINTS | {"min_delay", "max_delay"}),
                   DCMotorCfg=taking("DCMotorCfg", JOINTS | {"saturation_effort"}))
module("isaaclab", sim=sim)
module("isaaclab.assets", ArticulationCfg=taking("ArticulationCfg", {"spawn", "actuators", "init_state"}))
robot = runpy.run_path(sys.argv[1])["ROBOT_CFG"]
print(json.dumps({name: {"class": type(group).__name__, **group.__dict__} for name, group in robot.actuators.items()}))
