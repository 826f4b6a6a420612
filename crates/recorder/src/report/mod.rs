//! One HTML file made of sections, tables and figures that needs no network.
