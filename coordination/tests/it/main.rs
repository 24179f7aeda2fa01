//! Tests of what is public that need no process of their own: in one program, which is built in a third of the time that a dozen take.

mod acquire_release;
#[cfg(feature = "analysis")]
mod analysis;
#[cfg(feature = "analysis")]
mod analysis_properties;
#[cfg(feature = "analysis")]
mod analysis_replay;
mod examples;
mod fsm_net;
mod fsm_of_net;
mod machines;
#[cfg(feature = "analysis")]
mod nets;
mod petri_fairness;
mod petri_model;
mod protocol;
#[cfg(feature = "analysis")]
mod t_junction;
