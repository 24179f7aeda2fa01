//! The plain executor that ours is compared with: `figure_4.c`, after Fig. 4 of the paper, compiled when
//! the program starts, for the machine that it runs on (`-O3 -march=native`), and loaded.

use std::process::Command;
use std::ptr::NonNull;

use coordination::petri::{PlaceId, PlaceKind, Structure, TransitionId};
use libloading::Library;

const SOURCE: &str = include_str!("figure_4.c");

/// The `figure_4` of the C source.
#[repr(C)]
struct Raw {
    _private: [u8; 0],
}

type New = unsafe extern "C" fn(
    places: u32,
    transitions: u32,
    starts: *const u32,
    arcs: *const u16,
    is_sink: *const u8,
    is_marked: *const u8,
) -> *mut Raw;
type Free = unsafe extern "C" fn(*mut Raw);
type SetMarking = unsafe extern "C" fn(*mut Raw, places: *const u16, count: u32);
type IsMarked = unsafe extern "C" fn(*const Raw, place: u16) -> i32;
type Traced = unsafe extern "C" fn(*mut Raw, firings: u32, trace: *mut u16) -> u32;
type Evaluations = unsafe extern "C" fn(*mut Raw, count: u32, firings: u32) -> u64;

/// What the C source exports.
pub struct Rival {
    new: New,
    free: Free,
    set_marking: SetMarking,
    is_marked: IsMarked,
    traced: Traced,
    evaluations: Evaluations,
    /// The functions are in it.
    _library: Library,
}

impl Rival {
    /// The compiled executor, or why there is none: without a C compiler nothing can be compared.
    pub fn compile() -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let source = folder.path().join("figure_4.c");
        let library = folder.path().join("figure_4.so");
        std::fs::write(&source, SOURCE).map_err(|error| error.to_string())?;
        let target = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
        let tool = cc::Build::new()
            .cargo_metadata(false)
            .cargo_warnings(false)
            .host(&target)
            .target(&target)
            .out_dir(folder.path())
            .opt_level(3)
            .std("c11")
            .pic(true)
            .flag_if_supported("-march=native")
            .try_get_compiler()
            .map_err(|error| error.to_string())?;
        let mut command: Command = tool.to_command();
        command.args(["-shared", "-o"]).args([&library, &source]);
        let compiler = tool.path().display();
        let output = { command.output() }.map_err(|error| format!("{compiler}: {error}"))?;
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr);
            return Err(format!("{compiler}: {errors}"));
        }
        // SAFETY: the library was just compiled from our source, which runs nothing when it is loaded.
        let library = unsafe { Library::new(&library) }.map_err(|error| error.to_string())?;
        // SAFETY: these are the types of the functions in `figure_4.c`; the pointers are used only through
        // this struct, which holds the library.
        let api = unsafe {
            let error = |error: libloading::Error| error.to_string();
            Self {
                new: *library.get::<New>(b"figure_4_new\0").map_err(error)?,
                free: *library.get::<Free>(b"figure_4_free\0").map_err(error)?,
                set_marking: *{ library.get::<SetMarking>(b"figure_4_set_marking\0") }
                    .map_err(error)?,
                is_marked: *{ library.get::<IsMarked>(b"figure_4_is_marked\0") }.map_err(error)?,
                traced: *{ library.get::<Traced>(b"figure_4_traced\0") }.map_err(error)?,
                evaluations: *{ library.get::<Evaluations>(b"figure_4_evaluations\0") }
                    .map_err(error)?,
                _library: library,
            }
        };
        Ok(api)
    }
}

/// A net as the C source takes it.
pub struct Numbers {
    starts: Vec<u32>,
    arcs: Vec<u16>,
    is_sink: Vec<u8>,
    is_marked: Vec<u8>,
    transitions: usize,
}

impl Numbers {
    pub fn of(net: &Structure) -> Self {
        let (mut starts, mut arcs) = (vec![0], Vec::new());
        for transition in net.transitions() {
            for list in [net.inputs(transition), net.outputs(transition)] {
                arcs.extend(list.iter().map(|place| place.0));
                starts.push(arcs.len() as u32);
            }
        }
        let sinks = net.places().map(|place| net.kind(place) == PlaceKind::Sink);
        Self {
            starts,
            arcs,
            is_sink: sinks.map(u8::from).collect(),
            is_marked: net.places().map(|place| net.marked(place).into()).collect(),
            transitions: net.transition_count(),
        }
    }
}

/// The plain executor of one net.
pub struct Figure4<'a> {
    rival: &'a Rival,
    raw: NonNull<Raw>,
    places: usize,
    transitions: usize,
}

impl<'a> Figure4<'a> {
    pub fn new(rival: &'a Rival, net: &Numbers) -> Self {
        let places = net.is_sink.len();
        // SAFETY: `starts` has two entries per transition and one more, its last is the length of `arcs`,
        // both bytes are there for each place, and the C source copies what it needs.
        let raw = unsafe {
            (rival.new)(
                places as u32,
                net.transitions as u32,
                net.starts.as_ptr(),
                net.arcs.as_ptr(),
                net.is_sink.as_ptr(),
                net.is_marked.as_ptr(),
            )
        };
        Self {
            rival,
            raw: NonNull::new(raw).expect("there is memory"),
            places,
            transitions: net.transitions,
        }
    }

    pub fn set_marking(&mut self, places: &[PlaceId]) {
        let places: Vec<_> = places.iter().map(|place| place.0).collect();
        assert!({ places.iter() }.all(|&place| usize::from(place) < self.places));
        // SAFETY: `raw` lives as long as `self`, and every place is one of the net.
        unsafe { (self.rival.set_marking)(self.raw.as_ptr(), places.as_ptr(), places.len() as u32) }
    }

    pub fn is_marked(&self, place: PlaceId) -> bool {
        assert!(place.index() < self.places);
        // SAFETY: `raw` lives as long as `self`, and the place is one of the net.
        unsafe { (self.rival.is_marked)(self.raw.as_ptr(), place.0) != 0 }
    }

    /// One evaluation: what fired, in order.
    pub fn traced(&mut self, firings: u32) -> Vec<TransitionId> {
        let mut trace = vec![0; self.transitions];
        // SAFETY: `raw` lives as long as `self`, and no transition fires twice in an evaluation.
        let fired = unsafe { (self.rival.traced)(self.raw.as_ptr(), firings, trace.as_mut_ptr()) };
        trace.truncate(fired as usize);
        trace.into_iter().map(TransitionId).collect()
    }

    /// That many evaluations; how many transitions fired.
    pub fn evaluations(&mut self, count: usize, firings: u32) -> u64 {
        // SAFETY: `raw` lives as long as `self`.
        unsafe { (self.rival.evaluations)(self.raw.as_ptr(), count as u32, firings) }
    }
}

impl Drop for Figure4<'_> {
    fn drop(&mut self) {
        // SAFETY: it came from `new`, and is not used any more.
        unsafe { (self.rival.free)(self.raw.as_ptr()) }
    }
}
