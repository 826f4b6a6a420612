//! A run's table as Parquet: the same columns as in CSV, as floating-point or integer numbers.

use super::fence::fenced;
use super::table::{Said, Table, add_name, check_columns, check_length, later, sort};
use crate::{Error, Place};
use bytes::Bytes;
use parquet::basic::{Compression, ConvertedType, LogicalType, Type as Physical};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::{ColumnReaderImpl, get_column_reader, get_typed_column_reader};
use parquet::data_type::{DataType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader, RowGroupMetaData};
use parquet::file::serialized_reader::SerializedPageReader;
use parquet::schema::types::{ColumnDescriptor, Type};
use std::path::Path;
use std::sync::Arc;

/// Most numbers that a table may hold, 1.6 GB of them. A damaged file of a few bytes can claim, and by run
/// lengths even hold, any number of rows.
const MOST_VALUES: usize = 200_000_000;

/// Rows that are decoded at a time.
const BATCH: usize = 65_536;

/// Reads the bytes of a Parquet file.
pub(super) fn parse(path: &Path, bytes: Bytes, said: Said) -> Result<Table, Error> {
    fenced(|| decode(path, bytes, said)).unwrap_or_else(|| {
        Err(Error::bad(path, None, None, "is no readable Parquet file: its parts contradict each other"))
    })
}

fn decode(path: &Path, bytes: Bytes, said: Said) -> Result<Table, Error> {
    if bytes.is_empty() {
        return Err(Error::bad(path, None, None, "is empty"));
    }
    let bytes = Arc::new(bytes);
    let metadata =
        ParquetMetaDataReader::new().parse_and_finish(bytes.as_ref()).map_err(|e| broken(path, &e))?;
    let names = names(path, &metadata)?;
    check_columns(path, Place::Whole, &names, said)?;
    let kinds = names
        .iter()
        .zip(metadata.file_metadata().schema_descr().columns())
        .map(|(name, column)| {
            Number::of(column).map_err(|found| {
                let problem = format!("holds {found}; a column must hold floating-point or integer numbers");
                Error::bad(path, Place::Row(1), Some(name), problem)
            })
        })
        .collect::<Result<Vec<Number>, Error>>()?;
    let rows = rows(path, &metadata, names.len())?;
    check_length(path, rows)?;

    let mut columns = Vec::with_capacity(names.len());
    for (i, (name, kind)) in names.iter().zip(kinds).enumerate() {
        let mut values = Vec::new();
        for group in metadata.row_groups() {
            kind.read(path, name, &bytes, group, i, &mut values)?;
        }
        if values.len() != rows {
            let problem = format!("has {} rows, the file {rows}", values.len());
            return Err(Error::bad(path, None, Some(name), problem));
        }
        if let Some(row) = values.iter().position(|v| !v.is_finite()) {
            let problem = format!("'{}' is not finite", values[row]);
            return Err(Error::bad(path, Place::Row(row as u64 + 1), Some(name), problem));
        }
        if name == "time_s" {
            for (before, pair) in values.windows(2).enumerate() {
                later(path, Place::Row(before as u64 + 2), pair[0], pair[1])?;
            }
        }
        columns.push(values);
    }
    Ok(sort(names, columns, said))
}

/// An error of the decoder, in one line.
fn broken(path: &Path, error: &ParquetError) -> Error {
    let problem = format!("is no readable Parquet file: {error}");
    Error::bad(path, None, None, problem.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The columns' names; each must be one plain column.
fn names(path: &Path, metadata: &ParquetMetaData) -> Result<Vec<String>, Error> {
    let mut names = Vec::new();
    for field in metadata.file_metadata().schema_descr().root_schema().get_fields() {
        add_name(path, Place::Whole, &mut names, field.name().trim())?;
        let plain = matches!(field.as_ref(), Type::PrimitiveType { basic_info, .. }
            if basic_info.repetition() != parquet::basic::Repetition::REPEATED);
        if !plain {
            let problem = "holds lists or records; a column must hold one number per row";
            return Err(Error::bad(path, Place::Row(1), Some(field.name()), problem));
        }
    }
    Ok(names)
}

/// How many rows the file says that it has.
fn rows(path: &Path, metadata: &ParquetMetaData, columns: usize) -> Result<usize, Error> {
    let rows = metadata
        .row_groups()
        .iter()
        .try_fold(0usize, |sum, group| sum.checked_add(usize::try_from(group.num_rows()).ok()?));
    rows.filter(|rows| rows.saturating_mul(columns) <= MOST_VALUES).ok_or_else(|| {
        let problem = format!("says that it holds more than {MOST_VALUES} numbers; cut the run into several");
        Error::bad(path, None, None, problem)
    })
}

/// What a column's numbers are stored as.
#[derive(Clone, Copy)]
enum Number {
    Double,
    Float,
    Int32,
    Int64,
    Unsigned32,
    Unsigned64,
}

impl Number {
    /// How this column is stored, or what it holds instead of numbers.
    fn of(column: &ColumnDescriptor) -> Result<Self, String> {
        let plain = match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Integer { is_signed, .. }), _) => Some(*is_signed),
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
            (None, _) => None,
        };
        match (column.physical_type(), plain) {
            (_, None) => Err(format!("{}", column.converted_type())),
            (Physical::DOUBLE, _) => Ok(Self::Double),
            (Physical::FLOAT, _) => Ok(Self::Float),
            (Physical::INT32, Some(true)) => Ok(Self::Int32),
            (Physical::INT64, Some(true)) => Ok(Self::Int64),
            (Physical::INT32, Some(false)) => Ok(Self::Unsigned32),
            (Physical::INT64, Some(false)) => Ok(Self::Unsigned64),
            (other, _) => Err(format!("{other}")),
        }
    }

    /// Appends a row group's values of column `index`.
    fn read(
        self,
        path: &Path,
        name: &str,
        bytes: &Arc<Bytes>,
        group: &RowGroupMetaData,
        index: usize,
        out: &mut Vec<f64>,
    ) -> Result<(), Error> {
        let column = Column { path, name, bytes, group, index };
        // The unsigned types are stored in the bits of the signed ones.
        match self {
            Self::Double => column.append::<DoubleType>(|v| v, out),
            Self::Float => column.append::<FloatType>(f64::from, out),
            Self::Int32 => column.append::<Int32Type>(f64::from, out),
            Self::Int64 => column.append::<Int64Type>(|v| v as f64, out),
            Self::Unsigned32 => column.append::<Int32Type>(|v| f64::from(v.cast_unsigned()), out),
            Self::Unsigned64 => column.append::<Int64Type>(|v| v.cast_unsigned() as f64, out),
        }
    }
}

/// One column of a row group.
struct Column<'a> {
    path: &'a Path,
    name: &'a str,
    bytes: &'a Arc<Bytes>,
    group: &'a RowGroupMetaData,
    index: usize,
}

impl Column<'_> {
    fn append<T: DataType>(&self, number: impl Fn(T::T) -> f64, out: &mut Vec<f64>) -> Result<(), Error> {
        let broken = |e: ParquetError| broken(self.path, &e);
        let rows = usize::try_from(self.group.num_rows()).unwrap_or(0);
        let chunk = self.group.column(self.index);
        let codec = chunk.compression();
        if !matches!(codec, Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::ZSTD(_)) {
            let problem = format!("is packed with {codec}; of the codecs, snappy and zstd are read, or none");
            return Err(Error::bad(self.path, None, Some(self.name), problem));
        }
        let pages = SerializedPageReader::new(self.bytes.clone(), chunk, rows, None).map_err(broken)?;
        let pages = Box::new(Honest { pages, most: rows });
        let reader = get_column_reader(chunk.column_descr_ptr(), pages);
        let mut reader: ColumnReaderImpl<T> = get_typed_column_reader(reader);
        let optional = chunk.column_descr().max_def_level() > 0;
        let (mut values, mut levels) = (Vec::new(), Vec::new());
        let end = out.len() + rows;
        loop {
            values.clear();
            levels.clear();
            let wanted = BATCH.min(end - out.len());
            let (read, _, _) =
                reader.read_records(wanted, Some(&mut levels), None, &mut values).map_err(broken)?;
            if let Some(null) = levels[..if optional { read } else { 0 }].iter().position(|&l| l == 0) {
                let row = Place::Row((out.len() + null) as u64 + 1);
                return Err(Error::bad(self.path, row, Some(self.name), "the cell is empty"));
            }
            out.extend(values.drain(..).map(&number));
            if read == 0 || out.len() == end {
                return Ok(());
            }
        }
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
                "a page claims {} values in a group of {} rows",
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
