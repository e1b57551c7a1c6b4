//! Tests of cf-linear, one binary.

mod bound;
mod chebyshev;
mod common;
mod floor;
mod iterations;
mod obstacles;
mod operator;
mod preconditioner;
mod single;
mod solutions;
mod threads;
