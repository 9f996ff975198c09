//! Values that are one of some words, each with a sentence: the name and the doc comment of a variant.

use std::str::FromStr;

use strum::{EnumMessage, IntoEnumIterator};

/// A type whose values are words, but for variants that strum leaves out.
pub trait Words: IntoEnumIterator + EnumMessage + FromStr + Into<&'static str> {}

impl<T: IntoEnumIterator + EnumMessage + FromStr + Into<&'static str>> Words for T {}

/// A word that a key may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Word {
    /// The word.
    pub name: &'static str,
    /// Another name that is read as this word; none of most words.
    pub alias: Option<&'static str>,
    /// What it means, without a full stop.
    pub sentence: &'static str,
}

impl Word {
    /// Whether a text is the word or its other name, in whatever case of letters.
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
