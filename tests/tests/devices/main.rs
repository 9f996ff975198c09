//! Devices against the processor, and in a program of someone else.

mod air;
mod frames;
mod gpu;
mod light;
mod plan_on_device;
mod resident;
mod shaders;
