//! What a net file holds, once it is read and valid: a coordination between robots in roles and the
//! mediator, as protocols and a Petri net.

mod coordination;
mod data;
mod rules;

pub use data::{
    MEDIATOR, NetArray, NetCommand, NetConfig, NetFile, NetFlag, NetMetamodel, NetParty, NetPlace,
    NetProtocol, NetRole, NetSet, NetSituation, NetTransition,
};
