//! The orders of scattering that a sky has.

use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

/// Which orders of scattering a sky has.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(try_from = "OrdersText", into = "OrdersText")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Orders {
    /// All orders.
    All,
    /// Up to this one.
    #[strum(disabled)]
    UpTo(u32),
}

impl Orders {
    /// The highest order that may be asked for alone.
    pub const MOST: u32 = 20;
}

/// Orders as they stand in a scene file.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "orders are a whole number or \"all\"")]
enum OrdersText {
    Number(u32),
    Text(String),
}

impl TryFrom<OrdersText> for Orders {
    type Error = String;

    fn try_from(text: OrdersText) -> std::result::Result<Self, String> {
        match text {
            OrdersText::Number(order) => Ok(Self::UpTo(order)),
            OrdersText::Text(text) => {
                text.parse().map_err(|_| format!("orders are a whole number or \"all\", not {text:?}"))
            }
        }
    }
}

impl From<Orders> for OrdersText {
    fn from(orders: Orders) -> Self {
        match orders {
            Orders::All => Self::Text("all".into()),
            Orders::UpTo(order) => Self::Number(order),
        }
    }
}
