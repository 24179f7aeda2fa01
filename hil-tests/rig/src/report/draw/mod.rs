//! What all drawings are made with.

pub(super) mod canvas;
pub(super) mod floor;
pub(super) mod frame;
pub(super) mod labels;
pub(super) mod marks;
pub(super) mod outline;
pub(super) mod scale;
pub(super) mod scale_bar;
pub(super) mod sheet;
pub(super) mod thin;
