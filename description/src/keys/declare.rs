//! The macros that declare keys.

/// Declares a table of a file.
///
/// Each field has a type, a rule (`as …`: unit and range, or what is expected), a default (`=> …`; without one the key
/// is required, unless the rule itself says what its absence means) and a doc comment, which the reference page shows.
/// With `: Default` behind its name every field must have a default, and the type implements [`Default`].
/// A field whose name is not its key names the key: `period @ "period_us": …`.
#[macro_export]
macro_rules! section {
    (
        $(#[doc = $about:literal])*
        $(#[derive($($trait:ident),*)])?
        pub struct $name:ident: Default {
            $(
                $(#[doc = $doc:literal])*
                pub $field:ident $(@ $key:literal)?: $type:ty as $rule:expr => $default:expr,
            )*
        }
    ) => {
        $crate::section! {
            $(#[doc = $about])*
            $(#[derive($($trait),*)])?
            pub struct $name {
                $($(#[doc = $doc])* pub $field $(@ $key)?: $type as $rule => $default,)*
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }
    };
    (
        $(#[doc = $about:literal])*
        $(#[derive($($trait:ident),*)])?
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])*
                pub $field:ident $(@ $key:literal)?: $type:ty as $rule:expr $(=> $default:expr)?,
            )*
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq $(, $($trait),*)?)]
        pub struct $name {
            $($(#[doc = $doc])* pub $field: $type,)*
        }

        impl $crate::keys::Section for $name {
            const ABOUT: &'static str = concat!($($about),*);
            const KEYS: &'static [&'static str] = &[$($crate::section!(@key $field $($key)?)),*];

            fn read(source: &dyn $crate::keys::Source) -> Self {
                Self {
                    $($field: <$type as $crate::keys::Field<_>>::read(
                        source,
                        $crate::section!(@key $field $($key)?),
                        &$rule,
                        $crate::section!(@default $($default)?),
                    ),)*
                }
            }

            fn check(&self) -> Result<(), $crate::keys::KeyError> {
                $($crate::keys::Field::check(
                    &self.$field,
                    $crate::section!(@key $field $($key)?),
                    &$rule,
                )?;)*
                Ok(())
            }

            fn excuse(source: &dyn $crate::keys::Source) {
                $(<$type as $crate::keys::Field<_>>::excuse(
                    source,
                    $crate::section!(@key $field $($key)?),
                    &$rule,
                );)*
            }

            fn document(page: &mut $crate::keys::Page) {
                $(<$type as $crate::keys::Field<_>>::document(
                    page,
                    $crate::section!(@key $field $($key)?),
                    &$rule,
                    $crate::section!(@default $($default)?),
                    concat!($($doc),*),
                );)*
            }
        }
    };
    (@key $field:ident $key:literal) => { $key };
    (@key $field:ident) => { stringify!($field) };
    (@default $default:expr) => { Some($default) };
    (@default) => { None };
}

/// Declares a choice by a word, which brings keys of its own: `kind = "after"` comes with `after_s`.
///
/// The keys stand in the table around it (rule [`Flat`](crate::keys::Flat)). `else` names the choice that stands in
/// where the word is wrong.
#[macro_export]
macro_rules! kinds {
    (
        $(#[doc = $about:literal])*
        $(#[derive($($trait:ident),*)])?
        pub enum $name:ident by $tag:literal else $fallback:ident {
            $(
                $(#[doc = $doc:literal])*
                $variant:ident $word:literal
                $({$(
                    $(#[doc = $field_doc:literal])*
                    $field:ident $(@ $key:literal)?: $type:ty as $rule:expr $(=> $default:expr)?,
                )*})?,
            )*
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq $(, $($trait),*)?)]
        pub enum $name {
            $($(#[doc = $doc])* $variant $({$($(#[doc = $field_doc])* $field: $type,)*})?,)*
        }

        impl $name {
            /// The word in files.
            #[must_use]
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => $word,)*
                }
            }
        }

        impl $crate::keys::Section for $name {
            const ABOUT: &'static str = concat!($($about),*);
            const KEYS: &'static [&'static str] =
                &[$tag, $($($($crate::section!(@key $field $($key)?),)*)?)*];

            fn read(source: &dyn $crate::keys::Source) -> Self {
                match source.word($tag, &[$($word),*], $crate::keys::Need::Required) {
                    $(Some($word) => Self::$variant $({
                        $($field: <$type as $crate::keys::Field<_>>::read(
                            source,
                            $crate::section!(@key $field $($key)?),
                            &$rule,
                            $crate::section!(@default $($default)?),
                        ),)*
                    })?,)*
                    _ => {
                        // The word is wrong; the keys that come with it are not to blame.
                        <Self as $crate::keys::Section>::excuse(source);
                        Self::$fallback
                    }
                }
            }

            fn check(&self) -> Result<(), $crate::keys::KeyError> {
                match self {
                    $(Self::$variant $({$($field,)*})? => {
                        $($($crate::keys::Field::check(
                            $field,
                            $crate::section!(@key $field $($key)?),
                            &$rule,
                        )?;)*)?
                        Ok(())
                    })*
                }
            }

            fn excuse(source: &dyn $crate::keys::Source) {
                let _ = source.has($tag);
                $($($(<$type as $crate::keys::Field<_>>::excuse(
                    source,
                    $crate::section!(@key $field $($key)?),
                    &$rule,
                );)*)?)*
            }

            fn document(page: &mut $crate::keys::Page) {
                let words = $crate::keys::quoted_list(&[$($word),*], "or");
                page.key($tag, words, None, concat!($($about),*));
                $(
                    page.key(
                        concat!($tag, " = \"", $word, "\""),
                        "",
                        Some(String::new()),
                        concat!($($doc),*),
                    );
                    $($(<$type as $crate::keys::Field<_>>::document(
                        page,
                        $crate::section!(@key $field $($key)?),
                        &$rule,
                        $crate::section!(@default $($default)?),
                        concat!($($field_doc),*),
                    );)*)?
                )*
            }
        }
    };
}

/// Declares a choice by a word alone.
#[macro_export]
macro_rules! words {
    (
        $(#[doc = $about:literal])*
        $(#[derive($($trait:ident),*)])?
        pub enum $name:ident {
            $($(#[doc = $doc:literal])* $variant:ident $word:literal,)*
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash $(, $($trait),*)?)]
        pub enum $name {
            $($(#[doc = $doc])* $variant,)*
        }

        impl $name {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The word in files.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)*
                }
            }
        }

        impl $crate::keys::Words for $name {
            const WORDS: &'static [&'static str] = &[$($word),*];

            fn of(word: &str) -> Self {
                match word {
                    $($word => Self::$variant,)*
                    _ => Self::ALL[0],
                }
            }

            fn word(self) -> &'static str {
                self.name()
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}
