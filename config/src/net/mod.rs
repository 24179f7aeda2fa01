//! What a net file holds, once it is read and valid: a coordination between robots in roles and the
//! mediator, as protocols and a Petri net.

mod coordination;
mod data;

pub use data::{
    MEDIATOR, NetArray, NetCommand, NetConfig, NetFlag, NetParty, NetPlace, NetProtocol, NetRole,
    NetSet, NetSituation, NetTransition,
};
