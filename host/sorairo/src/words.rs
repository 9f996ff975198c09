//! Values with names, each with a description: the name and the doc comment of a variant.

use std::str::FromStr;

use strum::{EnumMessage, IntoEnumIterator};

/// A type whose values have names, except variants that strum skips.
pub trait Words: IntoEnumIterator + EnumMessage + FromStr + Into<&'static str> {}

impl<T: IntoEnumIterator + EnumMessage + FromStr + Into<&'static str>> Words for T {}

/// A name that a key accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Word {
    /// The word.
    pub name: &'static str,
    /// An alias of the name, if any.
    pub alias: Option<&'static str>,
    /// Its description, without a full stop.
    pub sentence: &'static str,
}

impl Word {
    /// Whether a text is the name or its alias, ignoring case.
    pub fn is(&self, text: &str) -> bool {
        [Some(self.name), self.alias].into_iter().flatten().any(|name| name.eq_ignore_ascii_case(text))
    }
}

/// The word of a value, as files and flags write it.
pub fn word<T: Words>(value: T) -> &'static str {
    value.into()
}

/// Every word of a type, in its order.
pub fn words<T: Words>() -> Vec<Word> {
    let describe = |value: T| {
        let sentence = value.get_documentation().unwrap_or_default().trim_end_matches('.');
        let names = value.get_serializations();
        let name = word(value);
        Word { name, alias: names.iter().copied().find(|other| *other != name), sentence }
    };
    T::iter().map(describe).collect()
}
