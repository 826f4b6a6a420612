//! Parquet: columns of numbers, truth values and lists of numbers of one length (as LeRobot keeps its states).

use crate::budget::{Budget, MOST_ARRAY, MOST_COLUMNS};
use crate::fence::fenced;
use crate::table::{Column, EMPTY, EXACT, Fault, Log, TRUTH, Table};
use crate::{LogError, Place};
use bytes::Bytes;
use parquet::basic::{Compression, ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::{ColumnReaderImpl, get_column_reader, get_typed_column_reader};
use parquet::data_type::{BoolType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader, RowGroupMetaData};
use parquet::file::serialized_reader::SerializedPageReader;
use parquet::schema::types::ColumnDescriptor;
use std::cell::Cell;
use std::path::Path;
use std::sync::Arc;

/// What a column of such holds, and in which unit.
pub(crate) const STAMPS: &str = "time stamps";

/// Values that are decoded at a time.
const BATCH: usize = 65_536;

/// Reads the bytes of a Parquet file.
pub(crate) fn parse(path: &Path, bytes: Bytes) -> Result<Log, LogError> {
    fenced(|| decode(path, bytes)).unwrap_or_else(|| {
        Err(LogError::whole(path, "is no readable Parquet file: its parts contradict each other"))
    })
}

fn decode(path: &Path, bytes: Bytes) -> Result<Log, LogError> {
    if bytes.is_empty() {
        return Err(LogError::whole(path, "is empty"));
    }
    let mut budget = Budget::of_file(bytes.len());
    let bytes = Arc::new(bytes);
    let metadata =
        ParquetMetaDataReader::new().parse_and_finish(bytes.as_ref()).map_err(|e| broken(path, &e))?;
    let rows = rows(path, &metadata)?;
    let mut log = Log { format: "Parquet", ..Log::default() };
    let mut table = Table::default();
    let schema = metadata.file_metadata().schema_descr();
    for (index, descriptor) in schema.columns().iter().enumerate() {
        let name = name(descriptor);
        if table.columns.len() >= MOST_COLUMNS {
            return Err(LogError::whole(path, format!("has more than {MOST_COLUMNS} columns")));
        }
        if name.is_empty() {
            let problem = format!("column {} has no name", table.columns.len() + 1);
            return Err(LogError::whole(path, problem));
        }
        let lists = descriptor.max_rep_level();
        let kind = match Number::of(descriptor) {
            Ok(kind) if lists <= 1 => kind,
            found => {
                let found = found.err().unwrap_or_else(|| "lists of lists".to_owned());
                budget.take(rows).map_err(|problem| LogError::whole(path, problem))?;
                table.columns.push(not_numbers(&name, rows, &found));
                continue;
            }
        };
        let source = Source {
            path,
            name: &name,
            bytes: &bytes,
            metadata: &metadata,
            index,
            rows,
            lists,
            origin: Cell::new(0),
        };
        if lists == 0 {
            let mut column = Column::named(&name);
            budget.take(rows).map_err(|problem| LogError::whole(path, problem))?;
            kind.read(&source, &mut Flat { column: &mut column })?;
            if column.values.len() != rows {
                let problem = format!("has {} rows, the file {rows}", column.values.len());
                return Err(LogError::new(path, Place::Whole, Some(&name), problem));
            }
            column.holds = kind.holds();
            column.origin = source.origin.get();
            table.columns.push(column);
        } else {
            let mut lists = Lists { columns: Vec::new(), row: 0, at: 0, problem: None, budget: &mut budget };
            kind.read(&source, &mut lists)?;
            lists.finish(&source, &kind, &mut table, &mut log.notes)?;
        }
    }
    for (i, column) in table.columns.iter().enumerate() {
        if table.columns[..i].iter().any(|c| c.name == column.name) {
            return Err(LogError::new(path, Place::Whole, Some(&column.name), "stands in the header twice"));
        }
    }
    log.tables.push(table);
    Ok(log)
}

/// The name of a column, of nested ones with the names of what they stand in; the inner names of a list mean nothing.
fn name(column: &ColumnDescriptor) -> String {
    let parts = column.path().parts();
    let kept = if column.max_rep_level() > 0 && parts.len() >= 3 { &parts[..parts.len() - 2] } else { parts };
    kept.join(".").trim().to_owned()
}

/// A column of something else than numbers.
fn not_numbers(name: &str, rows: usize, found: &str) -> Column {
    let problem = format!("holds {found}; a column must hold floating-point or integer numbers");
    Column {
        name: name.to_owned(),
        values: vec![f64::NAN; rows],
        fault: (rows > 0).then_some(Fault { row: 0, problem }),
        ..Column::default()
    }
}

/// An error of the decoder, in one line.
fn broken(path: &Path, error: &ParquetError) -> LogError {
    let problem = format!("is no readable Parquet file: {error}");
    LogError::whole(path, problem.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// How many rows the file says that it has.
fn rows(path: &Path, metadata: &ParquetMetaData) -> Result<usize, LogError> {
    metadata
        .row_groups()
        .iter()
        .try_fold(0usize, |sum, group| sum.checked_add(usize::try_from(group.num_rows()).ok()?))
        .ok_or_else(|| LogError::whole(path, "is no readable Parquet file: it claims less than no rows"))
}

/// What a column's numbers are stored as.
#[derive(Clone, Copy)]
enum Number {
    Bool,
    Double,
    Float,
    Int32,
    Int64,
    Unsigned32,
    Unsigned64,
    /// Time stamps as whole numbers of this many to a second.
    Stamp(&'static str),
}

impl Number {
    /// How this column is stored, or what it holds instead of numbers.
    fn of(column: &ColumnDescriptor) -> Result<Self, String> {
        let plain = match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Integer { is_signed, .. }), _) => Some(*is_signed),
            (Some(LogicalType::Timestamp { unit, .. }), _) => {
                return Ok(Self::Stamp(match unit {
                    TimeUnit::MILLIS => "milliseconds",
                    TimeUnit::MICROS => "microseconds",
                    TimeUnit::NANOS => "nanoseconds",
                }));
            }
            (Some(other), _) => return Err(format!("{other:?}")),
            (
                None,
                ConvertedType::UINT_8
                | ConvertedType::UINT_16
                | ConvertedType::UINT_32
                | ConvertedType::UINT_64,
            ) => Some(false),
            (
                None,
                ConvertedType::NONE
                | ConvertedType::INT_8
                | ConvertedType::INT_16
                | ConvertedType::INT_32
                | ConvertedType::INT_64,
            ) => Some(true),
            (None, ConvertedType::TIMESTAMP_MILLIS) => return Ok(Self::Stamp("milliseconds")),
            (None, ConvertedType::TIMESTAMP_MICROS) => return Ok(Self::Stamp("microseconds")),
            (None, _) => None,
        };
        match (column.physical_type(), plain) {
            (_, None) => Err(format!("{}", column.converted_type())),
            (Physical::BOOLEAN, _) => Ok(Self::Bool),
            (Physical::DOUBLE, _) => Ok(Self::Double),
            (Physical::FLOAT, _) => Ok(Self::Float),
            (Physical::INT32, Some(true)) => Ok(Self::Int32),
            (Physical::INT64, Some(true)) => Ok(Self::Int64),
            (Physical::INT32, Some(false)) => Ok(Self::Unsigned32),
            (Physical::INT64, Some(false)) => Ok(Self::Unsigned64),
            (other, _) => Err(format!("{other}")),
        }
    }

    /// What is said of a column that holds no plain numbers.
    fn holds(self) -> Option<String> {
        match self {
            Self::Bool => Some(TRUTH.to_owned()),
            Self::Stamp(unit) => Some(format!("{STAMPS} (Timestamp) in {unit}")),
            _ => None,
        }
    }

    /// Gives all values of the column to a sink, row group by row group.
    fn read(self, source: &Source, sink: &mut impl Sink) -> Result<(), LogError> {
        // The unsigned types are stored in the bits of the signed ones.
        match self {
            Self::Bool => source.pour::<BoolType>(|v| f64::from(u8::from(v)), sink),
            Self::Double => source.pour::<DoubleType>(|v| v, sink),
            Self::Float => source.pour::<FloatType>(f64::from, sink),
            Self::Int32 => source.pour::<Int32Type>(f64::from, sink),
            Self::Int64 | Self::Stamp(_) => {
                let first = Cell::new(None);
                let told = |v: i64| {
                    if first.get().is_none() {
                        // Nanoseconds since 1970 have more digits than a double: the first is subtracted.
                        source.origin.set(if v.unsigned_abs() > EXACT && source.lists == 0 { v } else { 0 });
                        first.set(Some(v));
                    }
                    v.wrapping_sub(source.origin.get()) as f64
                };
                source.pour::<Int64Type>(told, sink)
            }
            Self::Unsigned32 => source.pour::<Int32Type>(|v| f64::from(v.cast_unsigned()), sink),
            Self::Unsigned64 => source.pour::<Int64Type>(|v| v.cast_unsigned() as f64, sink),
        }
    }
}

/// What takes the values of a column: each with whether it begins a row; `None` for an empty cell.
trait Sink {
    fn take(&mut self, begins: bool, value: Option<f64>) -> Result<(), String>;
}

/// One number a row.
struct Flat<'a> {
    column: &'a mut Column,
}

impl Sink for Flat<'_> {
    fn take(&mut self, _: bool, value: Option<f64>) -> Result<(), String> {
        match value {
            Some(value) => self.column.push(value),
            None => self.column.push_fault(|| EMPTY.to_owned()),
        }
        Ok(())
    }
}

/// A list of numbers a row: as many columns as the first row's list has numbers.
struct Lists<'a> {
    columns: Vec<Column>,
    /// Rows that have begun, and numbers of the last of them.
    row: usize,
    at: usize,
    problem: Option<String>,
    budget: &'a mut Budget,
}

impl Sink for Lists<'_> {
    fn take(&mut self, begins: bool, value: Option<f64>) -> Result<(), String> {
        if begins {
            self.end_row();
            self.row += 1;
            self.at = 0;
        }
        if self.problem.is_some() || self.row == 0 {
            return Ok(());
        }
        if self.row == 1 {
            if self.columns.len() == MOST_ARRAY {
                self.problem = Some(format!("lists of more than {MOST_ARRAY} numbers"));
                self.columns.clear();
                return Ok(());
            }
            self.columns.push(Column::default());
        }
        let Some(column) = self.columns.get_mut(self.at) else {
            if value.is_some() {
                self.problem = Some(format!("lists of different lengths, first in row {}", self.row));
            }
            return Ok(());
        };
        self.budget.take(1)?;
        match value {
            Some(value) => column.push(value),
            None => column.push_fault(|| EMPTY.to_owned()),
        }
        self.at += 1;
        Ok(())
    }
}

impl Lists<'_> {
    fn end_row(&mut self) {
        if self.problem.is_none() && self.at != self.columns.len() {
            self.problem = Some(format!("lists of different lengths, first in row {}", self.row));
        }
    }

    fn finish(
        mut self,
        source: &Source,
        kind: &Number,
        table: &mut Table,
        notes: &mut Vec<String>,
    ) -> Result<(), LogError> {
        self.end_row();
        if self.row != source.rows && self.problem.is_none() {
            let problem = format!("has {} rows, the file {}", self.row, source.rows);
            return Err(LogError::new(source.path, Place::Whole, Some(source.name), problem));
        }
        if let Some(problem) = self.problem {
            self.budget.take(source.rows).map_err(|problem| LogError::whole(source.path, problem))?;
            table.columns.push(not_numbers(source.name, source.rows, &problem));
            // What was read until then is no whole column.
            return Ok(());
        }
        if self.columns.is_empty() {
            notes.push(format!("column '{}' holds empty lists", source.name));
        }
        for (i, mut column) in self.columns.into_iter().enumerate() {
            column.name = format!("{}[{i}]", source.name);
            column.holds = kind.holds();
            table.columns.push(column);
        }
        Ok(())
    }
}

/// One column of the file.
struct Source<'a> {
    path: &'a Path,
    name: &'a str,
    bytes: &'a Arc<Bytes>,
    metadata: &'a ParquetMetaData,
    index: usize,
    rows: usize,
    /// How deep its lists are; 0 for plain numbers.
    lists: i16,
    /// What was subtracted from every whole number.
    origin: Cell<i64>,
}

impl Source<'_> {
    fn pour<T: DataType>(&self, number: impl Fn(T::T) -> f64, sink: &mut impl Sink) -> Result<(), LogError> {
        for group in self.metadata.row_groups() {
            self.pour_group::<T>(group, &number, sink)?;
        }
        Ok(())
    }

    fn pour_group<T: DataType>(
        &self,
        group: &RowGroupMetaData,
        number: impl Fn(T::T) -> f64,
        sink: &mut impl Sink,
    ) -> Result<(), LogError> {
        let broken = |e: ParquetError| broken(self.path, &e);
        let rows = usize::try_from(group.num_rows()).unwrap_or(0);
        let chunk = group.column(self.index);
        let codec = chunk.compression();
        if !matches!(codec, Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::ZSTD(_)) {
            let problem = format!("is packed with {codec}; of the codecs, snappy and zstd are read, or none");
            return Err(LogError::new(self.path, Place::Whole, Some(self.name), problem));
        }
        let descriptor = chunk.column_descr();
        let listed = descriptor.max_rep_level() > 0;
        // A list has as many values as it likes, but a page never more than a file of this size could hold.
        let most = if listed {
            rows.saturating_mul(MOST_ARRAY).min(self.bytes.len().saturating_mul(64))
        } else {
            rows
        };
        let pages = SerializedPageReader::new(self.bytes.clone(), chunk, rows, None).map_err(broken)?;
        let pages = Box::new(Honest { pages, most });
        let mut reader: ColumnReaderImpl<T> =
            get_typed_column_reader(get_column_reader(chunk.column_descr_ptr(), pages));
        let defined = descriptor.max_def_level();
        let (mut values, mut defs, mut reps) = (Vec::new(), Vec::new(), Vec::new());
        let mut left = rows;
        while left > 0 {
            values.clear();
            defs.clear();
            reps.clear();
            // Records of lists are decoded a few at a time, as each may be long.
            let wanted = left.min(if listed { BATCH / 64 } else { BATCH });
            let (records, _, levels) =
                reader.read_records(wanted, Some(&mut defs), Some(&mut reps), &mut values).map_err(broken)?;
            if records == 0 && levels == 0 {
                break;
            }
            left -= records.min(left);
            let mut next = values.drain(..).map(&number);
            let count = if defined > 0 { levels } else { next.len() };
            for i in 0..count {
                let present = defined == 0 || defs.get(i).is_some_and(|&d| d == defined);
                let begins = !listed || reps.get(i).is_some_and(|&r| r == 0);
                let value = if present { next.next() } else { None };
                sink.take(begins, value).map_err(|problem| LogError::whole(self.path, problem))?;
            }
            if records == 0 {
                break;
            }
        }
        Ok(())
    }
}

/// A page reader that refuses pages with more values than their row group has rows: the decoder makes room
/// for as many as a page claims before it looks at any.
struct Honest {
    pages: SerializedPageReader<Bytes>,
    most: usize,
}

impl Iterator for Honest {
    type Item = ParquetResult<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Honest {
    fn get_next_page(&mut self) -> ParquetResult<Option<Page>> {
        let page = self.pages.get_next_page()?;
        match &page {
            Some(page) if page.num_values() as usize > self.most => Err(ParquetError::General(format!(
                "a page claims {} values where at most {} can be",
                page.num_values(),
                self.most
            ))),
            _ => Ok(page),
        }
    }

    fn peek_next_page(&mut self) -> ParquetResult<Option<PageMetadata>> {
        self.pages.peek_next_page()
    }

    fn skip_next_page(&mut self) -> ParquetResult<()> {
        self.pages.skip_next_page()
    }
}
