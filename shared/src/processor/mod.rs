//! The kernels for the CPU: pixels of a row, a block at a time.
//!
//! A block goes through the steps of a kernel one after the other: all its directions, all their integrals, all
//! colours. Each step is a loop that calls the same function of this crate for every pixel, and that the compiler
//! spreads over as many lanes as the processor has: eight with AVX2, four with SSE2 or NEON. A pixel has the same bits
//! as alone and on every processor of a kind: nothing is contracted to a fused operation, and nothing is summed across
//! pixels.
//!
//! A loop is spread only if all that it calls is in it and none of it can panic. So its functions are
//! `#[inline(always)]`; a step that fetches from where each pixel says is a loop of its own, one pixel after the other;
//! and of a variant that many scenes have, each step is compiled for itself. In a module for a browser, which has one
//! width of lanes, the longest steps remain functions: it is .1 MB smaller compressed.

pub mod colour;
pub mod integral;
pub mod kernels;
pub mod lanes;
pub mod lookup;
pub mod pixels;
pub mod run;
