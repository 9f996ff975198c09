//! What images show, in any scene.

mod aerial;
mod below;
mod environment;
mod hdr;
mod matrices;
mod pictures;
mod random_scenes;
mod reproducible;
mod stress;
