//! The extension module `sealegs._core`: what the Python files beside it wrap into the package `sealegs`.
//!
//! Numbers cross as NumPy arrays of `float64`, results as JSON, which the package turns into objects with attributes.

mod campaign;
mod error;
mod models;
mod results;
mod simulate;
mod work;

/// What `sealegs` is made of; use the package, not this module.
#[pyo3::pymodule]
mod _core {
    #[pymodule_export]
    use super::campaign::Campaign;
    #[pymodule_export]
    use super::error::{InputError, SealegsError, SimulationError};
    #[pymodule_export]
    use super::models::{actuator_model, preset_names, scenario_model};
    #[pymodule_export]
    use super::results::{Addition, Comparison, Diagnosis, add, better, compare, diagnose, model_file, plan};
    #[pymodule_export]
    use super::simulate::{simulate_bench, simulate_leg};

    /// Runs the program `sealegs` with these arguments, the program's name first; returns its exit status.
    #[pyo3::pyfunction]
    fn main(py: pyo3::Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
        py.detach(|| sealegs_cli::run_with(arguments))
    }

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
