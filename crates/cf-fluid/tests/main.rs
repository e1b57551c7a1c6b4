//! Checks of cf-fluid against model/fluid section 5.

mod common;
mod projection;
mod taylor_green;
