//! Tests of cf-linear, one binary.

mod allocations;
mod bound;
mod chebyshev;
mod common;
mod floor;
mod guesses;
mod iterations;
mod obstacles;
mod operator;
mod preconditioner;
mod single;
mod solutions;
mod threads;
