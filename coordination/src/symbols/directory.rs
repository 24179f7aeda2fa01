//! The directory: which symbols there are, as one value in the shared memory itself.

use bytemuck::{Pod, Zeroable};

use super::namespace::check_name;
use super::{Datatype, SemanticId, SymbolError};

/// The key of the directory in the blackboard.
pub(super) const DIRECTORY_KEY: u64 = 0;
/// To be raised with every change of the layout below.
pub(super) const FORMAT: u32 = 2;
/// The page of what was declared before the table was built: the table's own blackboard.
pub(super) const DECLARED: u64 = 0;

const NAME_LIMIT: usize = 40;
const URI_LIMIT: usize = 80;
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
    /// The activities that read it, in no particular order.
    pub readers: Vec<String>,
    /// The size of one value, without its time stamp.
    pub size_bytes: usize,
    /// What the datatype's name and layout conform to: [`Datatype::METAMODEL`].
    pub metamodel: String,
    /// Whether it was added while the robot ran, and can be removed.
    pub is_added: bool,
}

impl SymbolInfo {
    /// The symbol's semantic id with its metamodel.
    #[must_use]
    pub fn semantic_id(&self) -> SemanticId {
        SemanticId {
            metamodel: self.metamodel.clone(),
            datatype: self.datatype.clone(),
            model: self.model.clone(),
        }
    }
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

/// A URI of up to [`URI_LIMIT`] visible ASCII characters, padded with zeros.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Uri([u8; URI_LIMIT]);

impl Uri {
    fn new(uri: &str) -> Result<Self, SymbolError> {
        let has_scheme = uri.split_once(':').is_some_and(|(scheme, rest)| {
            scheme.starts_with(|first: char| first.is_ascii_alphabetic()) && !rest.is_empty()
        });
        if uri.len() > URI_LIMIT || !has_scheme || !uri.bytes().all(|byte| byte.is_ascii_graphic())
        {
            return Err(SymbolError::BadMetamodel {
                found: uri.into(),
                limit: URI_LIMIT,
            });
        }
        let mut bytes = [0; URI_LIMIT];
        bytes[..uri.len()].copy_from_slice(uri.as_bytes());
        Ok(Self(bytes))
    }

    fn text(&self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0);
        String::from_utf8_lossy(&self.0[..end.unwrap_or(URI_LIMIT)]).into_owned()
    }
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Row {
    metamodel: Uri,
    datatype: Name,
    model: Name,
    /// The blackboard that its value is in, as two words: [`DECLARED`], or a number that no other symbol of this run ever has.
    page: [u32; 2],
    /// Not removed.
    used: u32,
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

// The same on processors of any width: without padding, and nothing longer than 32 bits.
const _: () = {
    assert!(size_of::<Row>() == 188 && align_of::<Row>() == 4);
    assert!(size_of::<Directory>() == 25_360 && align_of::<Directory>() == 4);
};

impl Datatype for Directory {
    const NAME: &'static str = "symbol_directory";
}

/// A row's place in the directory, which gives its key in the blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RowId(usize);

impl RowId {
    /// Its key in the blackboard of the table.
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

    /// Adds a symbol on `page`, unless its semantic id is taken.
    pub(super) fn add<T: Datatype>(
        &mut self,
        owner: &str,
        model: &str,
        page: u64,
    ) -> Result<RowId, SymbolError> {
        let metamodel = Uri::new(T::METAMODEL)?;
        let datatype = Name::new("the datatype", T::NAME)?;
        let model_name = Name::new("the model", model)?;
        if let Some(row) = self.find(T::NAME, model) {
            return Err(SymbolError::Duplicate {
                datatype: T::NAME.into(),
                model: model.into(),
                first: self.owner(row).into(),
                second: owner.into(),
            });
        }
        // A row that was given back keeps its number, because others keep theirs.
        let number = self.rows[..self.count()]
            .iter()
            .position(|row| row.used == 0);
        let number = number.unwrap_or(self.count());
        if number >= MAX_SYMBOLS {
            return Err(SymbolError::TooMany {
                what: "symbols",
                limit: MAX_SYMBOLS,
            });
        }
        let owner = self.activity(owner)?;
        self.rows[number] = Row {
            metamodel,
            datatype,
            model: model_name,
            page: [page as u32, (page >> 32) as u32],
            used: 1,
            owner,
            readers: 0,
            size_bytes: size_of::<T>() as u32,
            taken: 0,
        };
        self.symbol_count = self.symbol_count.max(number as u32 + 1);
        Ok(RowId(number))
    }

    /// Withdraws a symbol.
    pub(super) fn remove(&mut self, row: RowId) {
        self.rows[row.0] = Row::zeroed();
    }

    /// The page that a symbol's value is in.
    pub(super) fn page(&self, row: RowId) -> u64 {
        self.rows[row.0].page()
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
            let metamodel = self.rows[row.0].metamodel.text();
            if metamodel != T::METAMODEL {
                return Err(SymbolError::OtherMetamodel {
                    asked_by: asked_by(),
                    datatype: datatype(),
                    model: model.into(),
                    owner: self.owner(row).into(),
                    expected: T::METAMODEL.into(),
                    found: metamodel.into(),
                });
            }
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
        let same_model = self.rows().find(|(_, row)| row.model.text() == model);
        Err(match same_model.map(|(row, _)| row) {
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

    /// Notes that `reader` reads the symbol; the number of the reader.
    pub(super) fn add_reader(&mut self, row: RowId, reader: &str) -> Result<u32, SymbolError> {
        let reader = self.activity(reader)?;
        self.rows[row.0].readers |= 1 << reader;
        Ok(reader)
    }

    /// Notes that a reader does not read the symbol any more.
    pub(super) fn remove_reader(&mut self, row: RowId, reader: u32) {
        self.rows[row.0].readers &= !(1 << reader);
    }

    pub(super) fn set_taken(&mut self, row: RowId, is_taken: bool) {
        self.rows[row.0].taken = is_taken.into();
    }

    /// The declared symbols whose writers nobody has taken.
    pub(super) fn not_taken(&self) -> Vec<String> {
        let not_taken = self
            .rows()
            .filter(|(_, row)| row.page() == DECLARED && row.taken == 0);
        not_taken
            .map(|(number, row)| {
                let owner = self.owner(number);
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
            metamodel: row.metamodel.text(),
            is_added: row.page() != DECLARED,
        };
        self.rows().map(|(_, row)| info(row)).collect()
    }

    fn find(&self, datatype: &str, model: &str) -> Option<RowId> {
        let same = |row: &Row| row.datatype.text() == datatype && row.model.text() == model;
        let mut rows = self.rows();
        rows.find_map(|(number, row)| same(row).then_some(number))
    }

    fn list_ids(&self) -> String {
        let id = |row: &Row| format!("{}/{}", row.datatype.text(), row.model.text());
        let ids: Vec<String> = self.rows().map(|(_, row)| id(row)).collect();
        ids.join(", ")
    }

    fn activity(&mut self, name: &str) -> Result<u32, SymbolError> {
        let name = Name::new("the activity", name)?;
        let count = (self.activity_count as usize).min(MAX_ACTIVITIES);
        let known = &self.activities[..count];
        if let Some(number) = known.iter().position(|other| *other == name) {
            return Ok(number as u32);
        }
        // The place of one that no symbol names any more serves again.
        let number = match count < MAX_ACTIVITIES {
            true => Some(count as u32),
            false => (0..MAX_ACTIVITIES as u32).find(|&number| !self.is_named(number)),
        };
        let number = number.ok_or(SymbolError::TooMany {
            what: "activities",
            limit: MAX_ACTIVITIES,
        })?;
        self.activities[number as usize] = name;
        self.activity_count = self.activity_count.max(number + 1);
        Ok(number)
    }

    fn is_named(&self, activity: u32) -> bool {
        let names = |row: &Row| row.owner == activity || row.readers & (1 << activity) != 0;
        self.rows().any(|(_, row)| names(row))
    }

    fn activity_name(&self, number: u32) -> String {
        let name = self.activities.get(number as usize);
        name.map_or_else(String::new, Name::text)
    }

    /// The symbols that are there.
    fn rows(&self) -> impl Iterator<Item = (RowId, &Row)> {
        let numbered = self.rows[..self.count()].iter().enumerate();
        numbered
            .filter(|(_, row)| row.used != 0)
            .map(|(number, row)| (RowId(number), row))
    }

    /// How many rows are or were in use; the count may come from another process and is not trusted.
    fn count(&self) -> usize {
        (self.symbol_count as usize).min(MAX_SYMBOLS)
    }
}

impl Row {
    fn page(&self) -> u64 {
        u64::from(self.page[0]) | u64::from(self.page[1]) << 32
    }
}
