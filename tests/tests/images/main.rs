//! What images show, in any scene.

mod aerial;
mod below;
mod environment;
mod hdr;
mod pictures;
mod random_scenes;
mod reproducible;
mod stress;
