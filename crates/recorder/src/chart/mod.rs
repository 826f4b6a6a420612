//! Small pictures in SVG.
