//! Received frames in memory that the kernel shares (packet(7), `PACKET_RX_RING`): looking whether one is there takes no system call.

use std::io;
use std::os::fd::{AsRawFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering};

/// Room for one frame with the kernel's header before it; an Ethernet frame has at most 1514 bytes.
const FRAME_BYTES: usize = 2048;
/// Whole pages, whatever their size is on the processors that there are.
const BLOCK_BYTES: usize = 1 << 16;
/// For 128 frames: a thread that was held up finds them there.
const BLOCKS: usize = 4;
const FRAMES: usize = BLOCKS * BLOCK_BYTES / FRAME_BYTES;
const BYTES: usize = BLOCKS * BLOCK_BYTES;

/// The frames that a packet socket receives, in their order.
pub(super) struct Ring {
    memory: NonNull<u8>,
    next: usize,
}

// SAFETY: the memory belongs to the ring alone, beside the kernel.
unsafe impl Send for Ring {}

impl Ring {
    /// Has a packet socket receive into a ring from now on, and no longer by `recv`. Before it is bound, so that no frame is in its queue.
    pub(super) fn of(socket: &OwnedFd) -> io::Result<Self> {
        let version = libc::tpacket_versions::TPACKET_V2 as libc::c_int;
        set(socket, libc::PACKET_VERSION, &version)?;
        let request = libc::tpacket_req {
            tp_block_size: BLOCK_BYTES as u32,
            tp_block_nr: BLOCKS as u32,
            tp_frame_size: FRAME_BYTES as u32,
            tp_frame_nr: FRAMES as u32,
        };
        set(socket, libc::PACKET_RX_RING, &request)?;
        // SAFETY: the kernel chooses the place; length and descriptor are those of the ring.
        let memory = unsafe {
            let protection = libc::PROT_READ | libc::PROT_WRITE;
            let descriptor = socket.as_raw_fd();
            libc::mmap(
                std::ptr::null_mut(),
                BYTES,
                protection,
                libc::MAP_SHARED | libc::MAP_POPULATE,
                descriptor,
                0,
            )
        };
        if memory == libc::MAP_FAILED {
            let error = io::Error::last_os_error();
            // Else the socket would go on to receive where nobody looks.
            // SAFETY: a structure of numbers, for which zero is valid: no ring.
            let none: libc::tpacket_req = unsafe { std::mem::zeroed() };
            let _ = set(socket, libc::PACKET_RX_RING, &none);
            return Err(error);
        }
        let memory = NonNull::new(memory.cast()).ok_or(io::ErrorKind::OutOfMemory)?;
        Ok(Self { memory, next: 0 })
    }

    /// Takes the next frame, cut if the buffer is shorter, and returns how much of it is there; `None` when none has come.
    pub(super) fn take(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let at = self.next * FRAME_BYTES;
        // SAFETY: `next` is below the number of frames, so that this is inside the mapping.
        let header = unsafe { self.memory.add(at) }
            .cast::<libc::tpacket2_hdr>()
            .as_ptr();
        // SAFETY: each frame begins with a header, aligned as the mapping is; while the ring is there the kernel and we use its status as
        // an atomic number.
        let status = unsafe { AtomicU32::from_ptr(&raw mut (*header).tp_status) };
        if status.load(Ordering::Acquire) & libc::TP_STATUS_USER == 0 {
            return None;
        }
        // SAFETY: the kernel has written the header, and leaves it alone until its status is given back.
        let (frame_at, kept) = unsafe { ((*header).tp_mac, (*header).tp_snaplen) };
        let frame_at = usize::from(frame_at).min(FRAME_BYTES);
        let kept = (kept as usize).min(FRAME_BYTES - frame_at);
        let length = kept.min(buffer.len());
        // SAFETY: both are inside this frame of the ring, which is ours until its status is given back.
        let frame = unsafe { self.memory.add(at + frame_at) };
        // SAFETY: `length` bytes are in the frame and in the buffer, which do not overlap.
        unsafe { std::ptr::copy_nonoverlapping(frame.as_ptr(), buffer.as_mut_ptr(), length) };
        status.store(libc::TP_STATUS_KERNEL, Ordering::Release);
        self.next = (self.next + 1) % FRAMES;
        Some(length)
    }
}

impl Drop for Ring {
    fn drop(&mut self) {
        // SAFETY: mapped by `of` with this length, and nobody has a reference into it.
        unsafe { libc::munmap(self.memory.as_ptr().cast(), BYTES) };
    }
}

fn set<T>(socket: &OwnedFd, option: libc::c_int, value: &T) -> io::Result<()> {
    let length = size_of::<T>() as libc::socklen_t;
    let value = std::ptr::from_ref(value).cast();
    // SAFETY: pointer and length describe a value that outlives the call.
    match unsafe { libc::setsockopt(socket.as_raw_fd(), libc::SOL_PACKET, option, value, length) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}
