//! One series elastic actuator: motor, transmission, spring and beams, integration, benches and effects.
