//! The whole check.

use alloc::vec::Vec;

use super::super::data::ModelData;
use super::super::error::ModelError;
use super::super::structure::Structure;
use super::errors::Check;

/// The structure of a sound model, or everything that is wrong with it.
pub(in crate::petri) fn resolve(data: &ModelData) -> Result<Structure, Vec<ModelError>> {
    let mut check = Check {
        data,
        errors: Vec::new(),
    };
    check.sizes();
    check.names();
    if !check.errors.is_empty() {
        // Numbers may be ambiguous or not fit; what follows relies on them.
        return Err(check.errors);
    }
    let marked = check.marks();
    let ending = check.sets();
    check.bindings();
    let structure = check.arcs(marked, &ending);
    if check.errors.is_empty() {
        Ok(structure)
    } else {
        Err(check.errors)
    }
}
