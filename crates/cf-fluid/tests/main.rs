//! Checks of cf-fluid against flows with known solutions.

mod common;
mod coupled;
mod extremes;
mod physics;
mod projection;
mod taylor_green;
mod verify;
