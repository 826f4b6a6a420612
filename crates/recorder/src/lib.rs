//! Recordings for Rerun and self-contained HTML reports with pictures.
