//! The symbol table.
