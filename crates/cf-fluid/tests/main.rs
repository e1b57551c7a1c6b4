//! Checks of cf-fluid against model/fluid section 5.

mod common;
mod coupled;
mod extremes;
mod physics;
mod projection;
mod taylor_green;
