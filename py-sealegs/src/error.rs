//! The library's errors as Python exceptions.

use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::{PyErr, create_exception};

create_exception!(_core, SealegsError, PyException, "Whatever sealegs could not do.");
create_exception!(
    _core,
    InputError,
    SealegsError,
    "The input is at fault: a file, a name, a value. The message names file or run, row and column."
);
create_exception!(
    _core,
    SimulationError,
    SealegsError,
    "A model could not be simulated, or a file not be written."
);

/// An error of the library as an exception.
pub fn raised(error: sealegs::Error) -> PyErr {
    match error {
        sealegs::Error::Stopped => PyKeyboardInterrupt::new_err("stopped"),
        error if error.is_bad_input() => InputError::new_err(error.to_string()),
        error => SimulationError::new_err(error.to_string()),
    }
}

/// Bad input that this module found itself.
pub fn bad_input(message: impl std::fmt::Display) -> PyErr {
    InputError::new_err(message.to_string())
}
