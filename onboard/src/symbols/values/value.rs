//! What every value of the table has.

/// Declares a value of the table: plain data with a datatype, zero at first.
macro_rules! value {
    ($(#[$meta:meta])* $name:ident, $datatype:literal { $($(#[$field_meta:meta])* $field:ident: $kind:ty,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)]
        #[repr(C)]
        pub struct $name { $($(#[$field_meta])* pub $field: $kind,)* }

        impl Default for $name {
            fn default() -> Self { bytemuck::Zeroable::zeroed() }
        }

        coordination::datatype!($name, $datatype, description::SYMBOLS);
    };
}
