//! Tests of the tubes.
