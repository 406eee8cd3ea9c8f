//! The shape of a type of the stream, as serde's derived reading of it tells: the names
//! of its enums' variants and of its structs' fields, all the way down.

use std::collections::BTreeMap;

use serde::de::value::Error;
use serde::de::{DeserializeSeed, EnumAccess, SeqAccess, VariantAccess, Visitor};
use serde::{Deserialize, Deserializer, forward_to_deserialize_any};

/// Readings after which every variant of every enum must have been seen.
const READINGS: usize = 2_000;

/// What was found.
#[derive(Default)]
pub(crate) struct Shape {
    enums: BTreeMap<&'static str, Enum>,
    structs: BTreeMap<&'static str, &'static [&'static str]>,
}

/// An enum or a struct by its name, with its variants or fields.
pub(crate) type Named = (&'static str, &'static [&'static str]);

/// An enum's variants, and how often it was read: each time as the next one.
struct Enum {
    variants: &'static [&'static str],
    readings: usize,
}

impl Shape {
    /// Follows a type, reading nothing but zeros.
    pub(crate) fn of<T: for<'de> Deserialize<'de>>() -> Self {
        let mut shape = Self::default();
        for _ in 0..READINGS {
            T::deserialize(&mut shape).unwrap();
        }
        for (name, found) in &shape.enums {
            assert!(found.readings >= found.variants.len(), "{name}");
        }
        shape
    }

    /// The enums by name, with their variants.
    pub(crate) fn enums(&self) -> impl Iterator<Item = Named> {
        let all = self.enums.iter();
        all.map(|(name, found)| (*name, found.variants))
    }

    /// The structs by name, with their fields.
    pub(crate) fn structs(&self) -> impl Iterator<Item = Named> {
        self.structs.iter().map(|(name, fields)| (*name, *fields))
    }
}

impl<'de> Deserializer<'de> for &mut Shape {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_u8(0)
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_bool(false)
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_f32(0.0)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_str("")
    }

    fn deserialize_bytes<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_bytes(&[])
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    /// An empty one: all sequences of the stream are of plain numbers.
    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_tuple(0, visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        left: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_seq(Elements { shape: self, left })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.structs.insert(name, fields);
        self.deserialize_tuple(fields.len(), visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let found = self.enums.entry(name).or_insert(Enum {
            variants,
            readings: 0,
        });
        let index = (found.readings % variants.len()) as u32;
        found.readings += 1;
        visitor.visit_enum(Variant { shape: self, index })
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 u32 u64 f64 char string byte_buf unit unit_struct
        tuple_struct map identifier ignored_any
    }
}

/// So many values of whatever is asked for.
struct Elements<'s> {
    shape: &'s mut Shape,
    left: usize,
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Error> {
        let Some(left) = self.left.checked_sub(1) else {
            return Ok(None);
        };
        self.left = left;
        seed.deserialize(&mut *self.shape).map(Some)
    }
}

/// One variant of an enum.
struct Variant<'s> {
    shape: &'s mut Shape,
    index: u32,
}

impl<'de> EnumAccess<'de> for Variant<'_> {
    type Error = Error;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Error> {
        let index = serde::de::value::U32Deserializer::new(self.index);
        Ok((seed.deserialize(index)?, self))
    }
}

impl<'de> VariantAccess<'de> for Variant<'_> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Error> {
        seed.deserialize(self.shape)
    }

    fn tuple_variant<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, Error> {
        self.shape.deserialize_tuple(len, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.shape.deserialize_tuple(fields.len(), visitor)
    }
}
