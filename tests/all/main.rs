//! Integration tests of the workspace, one binary: what no crate can promise alone.

mod commands;
mod goldens;
mod layering;
mod manifest;
mod tidy;
mod tradeoff;
