//! A URDF leg in the physics engine, driven by series elastic actuators.
