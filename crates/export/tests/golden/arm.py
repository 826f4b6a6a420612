"""arm with its drives for Isaac Lab 3, written by sealegs

lost         sensors: they are the simulator's own
held         command shoulder.torque_nm: effort of the joint shoulder
held         shoulder/coulomb-friction: friction of the joint
held         command elbow.torque_nm: effort of the joint elbow
lost         elbow/load-dependent-friction: the format has no element for it
lost         elbow/dahl-friction: the format has no element for it
lost         friction in the URDF: at elbow: the model's friction is that of its effects
held         armature, friction: in the actuators' configurations; damping as viscous_friction

Efforts are commanded: stiffness and damping of a drive are those of a spring or of a servo's own loop, where there is one.
"""

from pathlib import Path

import isaaclab.sim as sim_utils
from isaaclab.actuators import DCMotorCfg, DelayedPDActuatorCfg, ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

# The physics step for which delays are counted, s.
PHYSICS_DT_S = 0.001

ROBOT_CFG = ArticulationCfg(
    spawn=sim_utils.UrdfFileCfg(
        asset_path=str(Path(__file__).with_name("arm.urdf")),
        fix_base=True,
        joint_drive=sim_utils.UrdfConverterCfg.JointDriveCfg(
            target_type="none", gains=sim_utils.UrdfConverterCfg.JointDriveCfg.PDGainsCfg(stiffness=0.0, damping=0.0)
        ),
    ),
    actuators={
        "shoulder": ImplicitActuatorCfg(
            joint_names_expr=["shoulder"],
            stiffness=0,
            damping=0.0,
            armature=0.009999999999999998,
            friction=0.2,
            dynamic_friction=0.2,
            viscous_friction=0.09999999999999998,
        ),
        "elbow": ImplicitActuatorCfg(
            joint_names_expr=["elbow"],
            stiffness=0,
            damping=0.0,
            armature=0.009999999999999998,
            friction=0,
            dynamic_friction=0,
            viscous_friction=0.14999999999999997,
            joint_effort_limit=5,
        ),
    },
)
