//! The parser against whole, broken and arbitrary streams.
