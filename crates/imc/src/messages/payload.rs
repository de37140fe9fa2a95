//! What every message struct can do.

use crate::catalogue::MessageDesc;
use crate::messages::Message;
use crate::wire::{Fault, Reader, Writer};

/// A message of the catalogue as a Rust struct. Implemented by the generated structs only.
pub trait Payload: Sized + Into<Message> + 'static {
    /// The message's id.
    const ID: u16;
    /// What the catalogue says of it.
    const DESC: &'static MessageDesc;

    #[doc(hidden)]
    fn read(reader: &mut Reader<'_>) -> Result<Self, Fault>;

    #[doc(hidden)]
    fn write(&self, writer: &mut Writer<'_>);

    /// This type's value inside `message`, when it is one.
    fn of(message: &Message) -> Option<&Self>;
}

impl Message {
    /// The id on the wire.
    pub fn id(&self) -> u16 {
        self.desc().id
    }

    /// The abbreviation, such as `EstimatedState`.
    pub fn abbrev(&self) -> &'static str {
        self.desc().abbrev
    }
}

/// An enumeration of the wire: its listed values by name, any other number kept.
macro_rules! wire_enum {
    (
        $(#[$meta:meta])*
        pub enum $name:ident: $number:ident {
            $( $(#[$value_meta:meta])* $variant:ident = $value:literal, )*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $name {
            $( $(#[$value_meta])* $variant, )*
            /// A number that the catalogue does not list.
            Unlisted($number),
        }

        impl $name {
            /// The number on the wire.
            #[inline]
            pub const fn value(self) -> $number {
                match self {
                    $( Self::$variant => $value, )*
                    Self::Unlisted(value) => value,
                }
            }
        }

        impl From<$number> for $name {
            #[inline]
            fn from(value: $number) -> Self {
                match value {
                    $( $value => Self::$variant, )*
                    _ => Self::Unlisted(value),
                }
            }
        }

        impl Default for $name {
            /// The value whose number is 0.
            fn default() -> Self {
                Self::from(0)
            }
        }
    };
}
