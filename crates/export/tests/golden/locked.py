"""small on the locked bench for Isaac Lab 3, written by sealegs

lost         load cells: no such sensor between drive and joint
held         coulomb-friction: friction of the joint
lost         current-saturation: an effort limit would clip the spring's force, too: clip the command
held         transport-delay: DelayedPDActuatorCfg, in whole steps
lost         hardening-spring: the format has no element for it
held         armature, friction: in the actuators' configurations; damping as viscous_friction
approximate  delay at deflection: 3 steps of 0.001 s; 0 s are left over

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
        asset_path=str(Path(__file__).with_name("locked.urdf")),
        fix_base=True,
        joint_drive=sim_utils.UrdfConverterCfg.JointDriveCfg(
            target_type="none", gains=sim_utils.UrdfConverterCfg.JointDriveCfg.PDGainsCfg(stiffness=0.0, damping=0.0)
        ),
    ),
    actuators={
        "deflection": DelayedPDActuatorCfg(
            joint_names_expr=["deflection"],
            stiffness=5e5,
            damping=0.0,
            armature=100,
            friction=30,
            dynamic_friction=30,
            viscous_friction=2000,
            min_delay=3,
            max_delay=3,
        ),
    },
)
