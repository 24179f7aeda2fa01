//! The directory: which symbols there are, as one value in the shared memory itself.

use bytemuck::{Pod, Zeroable};

use super::namespace::check_name;
use super::{Datatype, SymbolError};

/// The key of the directory in the blackboard.
pub(super) const DIRECTORY_KEY: u64 = 0;
/// To be raised with every change of the layout below.
pub(super) const FORMAT: u32 = 1;

const NAME_LIMIT: usize = 40;
const MAX_SYMBOLS: usize = 128;
/// One bit each in the set of readers.
const MAX_ACTIVITIES: usize = 32;

/// One symbol, as listed by a table or an inspector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SymbolInfo {
    /// The first half of the semantic id.
    pub datatype: String,
    /// The second half of the semantic id.
    pub model: String,
    /// The activity that writes it.
    pub owner: String,
    /// The activities that looked it up at start-up, in the order in which they did first.
    pub readers: Vec<String>,
    /// The size of one value, without its time stamp.
    pub size_bytes: usize,
}

/// Text of up to [`NAME_LIMIT`] bytes, padded with zeros.
#[derive(Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Name([u8; NAME_LIMIT]);

impl Name {
    fn new(what: &'static str, text: &str) -> Result<Self, SymbolError> {
        check_name(what, text, NAME_LIMIT)?;
        let mut bytes = [0; NAME_LIMIT];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        Ok(Self(bytes))
    }

    fn text(&self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0);
        String::from_utf8_lossy(&self.0[..end.unwrap_or(NAME_LIMIT)]).into_owned()
    }
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Row {
    datatype: Name,
    model: Name,
    owner: u32,
    readers: u32,
    size_bytes: u32,
    /// Whether its owner has taken the writer.
    taken: u32,
}

/// The directory's layout in shared memory.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Directory {
    pub(super) format: u32,
    pub(super) sealed: u32,
    activity_count: u32,
    symbol_count: u32,
    activities: [Name; MAX_ACTIVITIES],
    rows: [Row; MAX_SYMBOLS],
}

impl Datatype for Directory {
    const NAME: &'static str = "symbol_directory";
}

/// A row's place in the directory, which gives its key in the blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RowId(usize);

impl RowId {
    pub(super) fn key(self) -> u64 {
        self.0 as u64 + 1
    }
}

impl Directory {
    pub(super) fn new() -> Box<Self> {
        let mut directory: Box<Self> = Box::new(Zeroable::zeroed());
        directory.format = FORMAT;
        directory
    }

    /// Adds a symbol, unless its semantic id is taken.
    pub(super) fn add<T: Datatype>(
        &mut self,
        owner: &str,
        model: &str,
    ) -> Result<RowId, SymbolError> {
        let datatype_name = Name::new("the datatype", T::NAME)?;
        let model_name = Name::new("the model", model)?;
        if let Some(row) = self.find(T::NAME, model) {
            return Err(SymbolError::Duplicate {
                datatype: T::NAME.into(),
                model: model.into(),
                first: self.owner(row).into(),
                second: owner.into(),
            });
        }
        let number = self.rows().len();
        if number >= MAX_SYMBOLS {
            return Err(SymbolError::TooMany {
                what: "symbols",
                limit: MAX_SYMBOLS,
            });
        }
        let owner = self.activity(owner)?;
        self.rows[number] = Row {
            datatype: datatype_name,
            model: model_name,
            owner,
            readers: 0,
            size_bytes: size_of::<T>() as u32,
            taken: 0,
        };
        self.symbol_count += 1;
        Ok(RowId(number))
    }

    /// The row of the symbol of type `T` called `model`; the error tells unknown from mistyped.
    pub(super) fn look_up<T: Datatype>(
        &self,
        asked_by: &str,
        model: &str,
    ) -> Result<RowId, SymbolError> {
        let asked_by = || asked_by.into();
        let datatype = || T::NAME.into();
        if let Some(row) = self.find(T::NAME, model) {
            let found_bytes = self.rows[row.0].size_bytes as usize;
            if found_bytes != size_of::<T>() {
                return Err(SymbolError::OtherLayout {
                    asked_by: asked_by(),
                    datatype: datatype(),
                    model: model.into(),
                    owner: self.owner(row).into(),
                    expected_bytes: size_of::<T>(),
                    found_bytes,
                });
            }
            return Ok(row);
        }
        let known = self.list_ids().into();
        let same_model = self.rows().iter().position(|row| row.model.text() == model);
        Err(match same_model.map(RowId) {
            Some(row) => SymbolError::Mistyped {
                asked_by: asked_by(),
                datatype: datatype(),
                model: model.into(),
                found: self.rows[row.0].datatype.text().into(),
                owner: self.owner(row).into(),
                known,
            },
            None => SymbolError::Unknown {
                asked_by: asked_by(),
                datatype: datatype(),
                model: model.into(),
                known,
            },
        })
    }

    /// Notes that `reader` reads the symbol.
    pub(super) fn add_reader(&mut self, row: RowId, reader: &str) -> Result<(), SymbolError> {
        let reader = self.activity(reader)?;
        self.rows[row.0].readers |= 1 << reader;
        Ok(())
    }

    pub(super) fn set_taken(&mut self, row: RowId) {
        self.rows[row.0].taken = 1;
    }

    pub(super) fn is_taken(&self, row: RowId) -> bool {
        self.rows[row.0].taken != 0
    }

    /// The symbols whose writers nobody has taken.
    pub(super) fn not_taken(&self) -> Vec<String> {
        let rows = self.rows().iter().enumerate();
        rows.filter(|(_, row)| row.taken == 0)
            .map(|(number, row)| {
                let owner = self.owner(RowId(number));
                format!("{}/{} of `{owner}`", row.datatype.text(), row.model.text())
            })
            .collect()
    }

    pub(super) fn owner(&self, row: RowId) -> String {
        self.activity_name(self.rows[row.0].owner)
    }

    pub(super) fn list(&self) -> Vec<SymbolInfo> {
        let info = |row: &Row| SymbolInfo {
            datatype: row.datatype.text(),
            model: row.model.text(),
            owner: self.activity_name(row.owner),
            readers: (0..MAX_ACTIVITIES as u32)
                .filter(|activity| row.readers & (1 << activity) != 0)
                .map(|activity| self.activity_name(activity))
                .collect(),
            size_bytes: row.size_bytes as usize,
        };
        self.rows().iter().map(info).collect()
    }

    fn find(&self, datatype: &str, model: &str) -> Option<RowId> {
        let same = |row: &Row| row.datatype.text() == datatype && row.model.text() == model;
        self.rows().iter().position(same).map(RowId)
    }

    fn list_ids(&self) -> String {
        let ids: Vec<String> = self
            .rows()
            .iter()
            .map(|row| format!("{}/{}", row.datatype.text(), row.model.text()))
            .collect();
        ids.join(", ")
    }

    fn activity(&mut self, name: &str) -> Result<u32, SymbolError> {
        let name = Name::new("the activity", name)?;
        let count = self.activity_count;
        let known = &self.activities[..count as usize];
        if let Some(number) = known.iter().position(|other| *other == name) {
            return Ok(number as u32);
        }
        let Some(free) = self.activities.get_mut(count as usize) else {
            return Err(SymbolError::TooMany {
                what: "activities",
                limit: MAX_ACTIVITIES,
            });
        };
        *free = name;
        self.activity_count += 1;
        Ok(count)
    }

    fn activity_name(&self, number: u32) -> String {
        let name = self.activities.get(number as usize);
        name.map_or_else(String::new, Name::text)
    }

    /// The rows in use; the count may come from another process and is not trusted.
    fn rows(&self) -> &[Row] {
        &self.rows[..(self.symbol_count as usize).min(MAX_SYMBOLS)]
    }
}
