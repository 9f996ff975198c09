//! The way to a value in a scene, whatever its type.

use erased_serde::{Deserializer, Error, Serialize};
use serde::de::{DeserializeOwned, Visitor};
use serde::forward_to_deserialize_any;

use super::exposure::{Exposure, Shutter};
use super::orders::Orders;
use super::preset::Scene;
use crate::spectra::choice::{GroundAlbedo, OrTable};
use crate::spectra::table_file::TableFile;

/// The way to a value of a type.
pub struct Way<T: 'static> {
    /// To read it.
    pub get: fn(&Scene) -> &T,
    /// To change it.
    pub get_mut: fn(&mut Scene) -> &mut T,
}

/// The value of a key.
pub trait Field: Sync {
    /// The value in a scene.
    fn get<'a>(&self, scene: &'a Scene) -> &'a dyn Serialize;

    /// Reads the value in a scene anew.
    ///
    /// # Errors
    ///
    /// What is read is of another kind.
    fn set(&self, scene: &mut Scene, value: &mut dyn Deserializer<'_>) -> Result<(), Error>;
}

impl<T: serde::Serialize + DeserializeOwned> Field for Way<T> {
    fn get<'a>(&self, scene: &'a Scene) -> &'a dyn Serialize {
        (self.get)(scene)
    }

    fn set(&self, scene: &mut Scene, value: &mut dyn Deserializer<'_>) -> Result<(), Error> {
        *(self.get_mut)(scene) = erased_serde::deserialize(value)?;
        Ok(())
    }
}

/// A value that is there, also where it might not be: what serde's own values of a number or a text refuse to say of an
/// option.
pub struct Present<D>(pub D);

impl<'de, D: serde::Deserializer<'de>> serde::Deserializer<'de> for Present<D> {
    type Error = D::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_any(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        visitor.visit_some(self.0)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_enum(name, variants, visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct newtype_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

/// The value of a key that may be a user table.
pub trait TableField: Sync {
    /// The table in a scene, if it has one.
    fn table<'a>(&self, scene: &'a Scene) -> Option<&'a TableFile>;

    /// The table in a scene, to be changed.
    #[cfg_attr(
        not(feature = "scene-files"),
        allow(dead_code, reason = "scenes that come from files alone have names to change")
    )]
    fn table_mut<'a>(&self, scene: &'a mut Scene) -> Option<&'a mut TableFile>;
}

impl<T: OrTable> TableField for Way<T> {
    fn table<'a>(&self, scene: &'a Scene) -> Option<&'a TableFile> {
        (self.get)(scene).file()
    }

    fn table_mut<'a>(&self, scene: &'a mut Scene) -> Option<&'a mut TableFile> {
        (self.get_mut)(scene).file_mut()
    }
}

/// The value of a key that is a number.
pub trait NumberField: Sync {
    /// The number in a scene, if it has one.
    fn number(&self, scene: &Scene) -> Option<f64>;

    /// The number in a scene, to be changed; `None` if it is no plain number.
    fn number_mut<'a>(&self, scene: &'a mut Scene) -> Option<&'a mut f64>;
}

impl<T: Number> NumberField for Way<T> {
    fn number(&self, scene: &Scene) -> Option<f64> {
        (self.get)(scene).number()
    }

    fn number_mut<'a>(&self, scene: &'a mut Scene) -> Option<&'a mut f64> {
        (self.get_mut)(scene).number_mut()
    }
}

/// A type that holds a number.
pub trait Number {
    /// The number, if there is one.
    fn number(&self) -> Option<f64>;

    /// The number, to be changed.
    fn number_mut(&mut self) -> Option<&mut f64> {
        None
    }
}

impl Number for f64 {
    fn number(&self) -> Option<f64> {
        Some(*self)
    }

    fn number_mut(&mut self) -> Option<&mut f64> {
        Some(self)
    }
}

impl Number for Option<f64> {
    fn number(&self) -> Option<f64> {
        *self
    }

    fn number_mut(&mut self) -> Option<&mut f64> {
        Some(self.get_or_insert(0.0))
    }
}

impl Number for Option<u32> {
    fn number(&self) -> Option<f64> {
        self.map(f64::from)
    }
}

impl Number for Option<Shutter> {
    fn number(&self) -> Option<f64> {
        self.map(f64::from)
    }
}

impl Number for Orders {
    fn number(&self) -> Option<f64> {
        match self {
            Self::All => None,
            Self::UpTo(order) => Some(f64::from(*order)),
        }
    }
}

impl Number for GroundAlbedo {
    fn number(&self) -> Option<f64> {
        match self {
            Self::Grey(albedo) => Some(*albedo),
            _ => None,
        }
    }

    fn number_mut(&mut self) -> Option<&mut f64> {
        if self.number().is_none() {
            *self = Self::Grey(0.0);
        }
        match self {
            Self::Grey(albedo) => Some(albedo),
            _ => None,
        }
    }
}

impl Number for Exposure {
    fn number(&self) -> Option<f64> {
        match self {
            Self::Auto | Self::Adapt => None,
            Self::Stops(stops) => Some(*stops),
        }
    }
}
