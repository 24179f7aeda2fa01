//! The one SubDevice of a bus: its sizes, its address, and its state.

use super::al::{AlState, AlStatus};
use ethercrab::error::Error;
use ethercrab::subdevice_group::{PreOp, PreOpPdi};
use ethercrab::{Command, MainDevice, RegisterAddress, SubDeviceGroup};
use spin::Spin;
use spin::rwlock::RwLock;

/// The address that ethercrab gives to the first SubDevice.
pub(super) const FIRST_ADDRESS: u16 = 0x1000;
/// ethercrab requires a power of two greater than one.
pub(super) const MAX_SUB_DEVICES: usize = 2;
/// Room for the process data of both directions; fits into one frame.
pub(super) const MAX_IMAGE: usize = 1024;
/// One SubDevice that is read (1) and written (2) by one LRW.
pub(super) const PROCESS_DATA_WKC: u16 = 3;

/// Only the thread of the bus takes it. ethercrab's own gives up the processor (`sched_yield`) whenever it is refused, which happens on
/// ARM though nobody holds it: a compare and exchange may fail there without a cause.
type Lock = RwLock<(), Spin>;
/// In a state of ethercrab's.
type GroupIn<State> = SubDeviceGroup<MAX_SUB_DEVICES, MAX_IMAGE, Lock, State>;
/// Before its process data are mapped.
pub(super) type UnmappedGroup = GroupIn<PreOp>;
/// ethercrab's typestate stays at PRE-OP: this module requests and checks states itself, to report the AL status code.
pub(super) type Group = GroupIn<PreOpPdi>;

/// Asks for a state without waiting for it.
pub(super) async fn request_state(
    main_device: &MainDevice<'_>,
    wanted: AlState,
) -> Result<(), Error> {
    let write = Command::fpwr(FIRST_ADDRESS, RegisterAddress::AlControl.into());
    write
        .send_receive::<u16>(main_device, u16::from(wanted.bits()))
        .await
        .map(|_| ())
}

/// Reads state, error flag and status code in one go.
pub(super) async fn read_status(main_device: &MainDevice<'static>) -> Result<AlStatus, Error> {
    let read = Command::fprd(FIRST_ADDRESS, RegisterAddress::AlStatus.into());
    read.receive::<[u8; 6]>(main_device)
        .await
        .map(AlStatus::from_registers)
}
