"""servo on the pendulum bench for Isaac Lab 3, written by sealegs

lost         sensors: they are the simulator's own
held         command position_rad: stiffness and damping of the actuator's configuration; back-EMF as viscous_friction
held         servo's command_delay_s: DelayedPDActuatorCfg, in whole steps
lost         servo's duty_dead_zone: the format has no element for it
lost         load-dependent-friction: the format has no element for it
lost         start of the run a.csv: lever at 0.25, speed -0.5
held         armature, friction: in the actuators' configurations; damping as viscous_friction
approximate  delay at lever: 10 steps of 0.001 s; 0 s are left over

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
        asset_path=str(Path(__file__).with_name("servo.urdf")),
        fix_base=True,
        joint_drive=sim_utils.UrdfConverterCfg.JointDriveCfg(
            target_type="none", gains=sim_utils.UrdfConverterCfg.JointDriveCfg.PDGainsCfg(stiffness=0.0, damping=0.0)
        ),
    ),
    actuators={
        "lever": DelayedPDActuatorCfg(
            joint_names_expr=["lever"],
            stiffness=10,
            damping=0.0,
            armature=0.01,
            friction=0,
            dynamic_friction=0,
            viscous_friction=0.145,
            min_delay=10,
            max_delay=10,
            actuator_effort_limit=2,
        ),
    },
)
