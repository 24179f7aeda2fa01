//! What a symbol's value may be.

use std::fmt;

use iceoryx2::prelude::ZeroCopySend;

/// Plain data that can be a symbol's value.
///
/// [`bytemuck::Pod`] makes sure that it holds no pointers and that every bit pattern is valid, so
/// whatever another process makes of the memory, reading it is sound. Two builds of a program that
/// use the same name for different layouts of the same size would misread each other: change the
/// name with the layout.
pub trait Datatype: bytemuck::Pod + Send + Sync {
    /// The datatype's part of the semantic id: 1 to 40 ASCII letters, digits, `_` or `-`.
    const NAME: &'static str;

    /// The metamodel that the datatype conforms to: a URI of up to 80 characters. It says what name and layout mean; who gives
    /// datatypes a meaning of their own, with units and frames, names the document that says which. Who asks for a
    /// symbol by another metamodel than its owner's is refused.
    const METAMODEL: &'static str = METAMODEL;
}

/// The metamodel of symbols that this crate documents: one plain value of a fixed layout (`repr(C)`, no pointers, every bit pattern
/// valid) with a monotonic stamp in nanoseconds, of which there is one for each datatype and model.
pub const METAMODEL: &str = "urn:coordination:symbols:1";

/// What a symbol is, for whoever finds it: which model, of which datatype, by which metamodel.
///
/// Datatype and model together are unique in a table; the metamodel says how they are to be understood.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SemanticId {
    /// The URI of what the datatype conforms to.
    pub metamodel: String,
    /// The datatype's name.
    pub datatype: String,
    /// Which of the datatype's symbols.
    pub model: String,
}

impl SemanticId {
    /// The semantic id of the symbol (`T`, `model`).
    pub fn of<T: Datatype>(model: impl Into<String>) -> Self {
        Self {
            metamodel: T::METAMODEL.to_owned(),
            datatype: T::NAME.to_owned(),
            model: model.into(),
        }
    }
}

/// `urn:coordination:symbols:1#encoders/drive`
impl fmt::Display for SemanticId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{}#{}/{}",
            self.metamodel, self.datatype, self.model
        )
    }
}

/// Names the datatypes of symbols: `datatype!(Scan, "range_scan")`; with a metamodel of their own,
/// `datatype!(Scan, "range_scan", "urn:example:scans:1")`.
#[macro_export]
macro_rules! datatype {
    ($type:ty, $name:literal, $metamodel:expr) => {
        impl $crate::symbols::Datatype for $type {
            const NAME: &'static str = $name;
            const METAMODEL: &'static str = $metamodel;
        }
    };
    ($type:ty, $name:literal) => {
        impl $crate::symbols::Datatype for $type {
            const NAME: &'static str = $name;
        }
    };
}

/// A value with the monotonic time at which it was true.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Stamped<T> {
    /// Nanoseconds of the monotonic clock; 0 means never written.
    pub stamp_ns: u64,
    /// The value.
    pub value: T,
}

impl<T> Stamped<T> {
    /// Whether the value was ever written.
    pub const fn is_written(&self) -> bool {
        self.stamp_ns != 0
    }

    /// How old the value is, or `None` if it was never written. A stamp in the future has age 0.
    pub const fn age_ns(&self, now_ns: u64) -> Option<u64> {
        match self.stamp_ns {
            0 => None,
            stamp_ns => Some(now_ns.saturating_sub(stamp_ns)),
        }
    }
}

// SAFETY: the struct has a fixed layout, and `T` is `Pod`, so there are no pointers, no references
// and nothing to drop in it. The name stands for one layout, as `Datatype::NAME` asks for.
unsafe impl<T: Datatype> ZeroCopySend for Stamped<T> {
    unsafe fn type_name() -> &'static str {
        T::NAME
    }
}
