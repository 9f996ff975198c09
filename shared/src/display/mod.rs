//! From linear light to what a display shows.

pub mod aces;
pub mod agx;
pub mod grade;
pub mod night;
pub mod pq;
pub mod rgb;
pub mod tone;
