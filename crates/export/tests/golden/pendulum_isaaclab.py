"""small on the pendulum bench for Isaac Lab 3, written by sealegs

lost         load cells: no such sensor between drive and joint
lost         spring: a tree of joints cannot close the loop between screw, spring and lever: rigid
approximate  stribeck-friction: friction and dynamic_friction, without the speed between them
held         voltage-saturation: DCMotorCfg, unless there is a delay
lost         backlash: the format has no element for it
lost         series-compliance: the format has no element for it
lost         sensor-lag@force_1_n: sensors are the simulator's own
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
        asset_path=str(Path(__file__).with_name("p.urdf")),
        fix_base=True,
        joint_drive=sim_utils.UrdfConverterCfg.JointDriveCfg(
            target_type="none", gains=sim_utils.UrdfConverterCfg.JointDriveCfg.PDGainsCfg(stiffness=0.0, damping=0.0)
        ),
    ),
    actuators={
        "lever": DCMotorCfg(
            joint_names_expr=["lever"],
            stiffness=0,
            damping=0.0,
            armature=1,
            friction=4,
            dynamic_friction=2,
            viscous_friction=20,
            saturation_effort=240,
            actuator_velocity_limit=1.2,
            actuator_effort_limit=240,
        ),
    },
)
