//! ZIP archives as NumPy writes them: members that are stored or deflated.
//!
//! Names, sizes and places are taken from the directory at the archive's end (PKWARE's APPNOTE 6.3.10, 4.3.12 and
//! 4.3.16). The library that reads every kind of archive would change what half of the other dependencies are built with.

use crate::budget::MOST_INFLATED;
use std::borrow::Cow;
use std::io::Read;

/// A file in an archive.
#[derive(Debug)]
pub(crate) struct Member {
    pub name: String,
    deflated: bool,
    crc: u32,
    packed: usize,
    size: usize,
    /// Where its own header begins.
    at: usize,
}

fn number<const N: usize>(bytes: &[u8], at: usize) -> Option<u64> {
    let part: [u8; N] = bytes.get(at..at.checked_add(N)?)?.try_into().ok()?;
    Some(part.iter().rev().fold(0, |sum, &b| sum << 8 | u64::from(b)))
}

fn short(bytes: &[u8], at: usize) -> Option<usize> {
    number::<2>(bytes, at).map(|n| n as usize)
}

fn long(bytes: &[u8], at: usize) -> Option<usize> {
    number::<4>(bytes, at).map(|n| n as usize)
}

/// The members in the order of the directory.
pub(crate) fn members(bytes: &[u8]) -> Result<Vec<Member>, String> {
    const END: &[u8] = b"PK\x05\x06";
    // A comment of up to 65535 bytes may follow the end record's 22.
    let from = bytes.len().saturating_sub(22 + 65_535);
    let end = bytes[from..].windows(END.len()).rposition(|w| w == END).map(|at| from + at);
    let end = end.ok_or("it has no directory at its end")?;
    let broken = || "its directory is broken".to_owned();
    let count = short(bytes, end + 10).ok_or_else(broken)?;
    let mut at = long(bytes, end + 16).ok_or_else(broken)?;
    let mut members = Vec::new();
    for _ in 0..count {
        if bytes.get(at..).is_none_or(|b| !b.starts_with(b"PK\x01\x02")) {
            return Err(broken());
        }
        let member = member(bytes, at).ok_or_else(broken)??;
        let lengths = [28, 30, 32].map(|field| short(bytes, at + field).unwrap_or(0));
        at += 46 + lengths.iter().sum::<usize>();
        members.push(member);
    }
    Ok(members)
}

fn member(bytes: &[u8], at: usize) -> Option<Result<Member, String>> {
    let name = bytes.get(at + 46..at + 46 + short(bytes, at + 28)?)?;
    let name = String::from_utf8_lossy(name).into_owned();
    let (method, packed, size, header) =
        (short(bytes, at + 10)?, long(bytes, at + 20)?, long(bytes, at + 24)?, long(bytes, at + 42)?);
    if short(bytes, at + 8)? & 1 == 1 {
        return Some(Err(format!("'{name}' is encrypted")));
    }
    if [packed, size, header].contains(&0xFFFF_FFFF) {
        return Some(Err(format!("'{name}' is larger than 4 GB")));
    }
    let deflated = match method {
        0 => false,
        8 => true,
        other => return Some(Err(format!("'{name}' is packed by method {other}; deflate is read, or none"))),
    };
    let crc = number::<4>(bytes, at + 16)? as u32;
    Some(Ok(Member { name, deflated, crc, packed, size, at: header }))
}

/// The content of a member, checked by its length and checksum.
pub(crate) fn content<'a>(bytes: &'a [u8], member: &Member) -> Result<Cow<'a, [u8]>, String> {
    let broken = || "its place in the archive is broken".to_owned();
    let (name, extra) = (short(bytes, member.at + 26), short(bytes, member.at + 28));
    let from = name.zip(extra).map(|(name, extra)| member.at + 30 + name + extra).ok_or_else(broken)?;
    let packed = bytes.get(from..from + member.packed).ok_or_else(broken)?;
    let content = if member.deflated {
        let limit = MOST_INFLATED.max(bytes.len() as u64).min(member.size as u64);
        let mut content = Vec::new();
        flate2::read::DeflateDecoder::new(packed)
            .take(limit + 1)
            .read_to_end(&mut content)
            .map_err(|e| format!("cannot be unpacked: {e}"))?;
        Cow::Owned(content)
    } else {
        Cow::Borrowed(packed)
    };
    if content.len() != member.size {
        return Err(format!("does not unpack to the {} bytes that it claims", member.size));
    }
    let mut crc = flate2::Crc::new();
    crc.update(&content);
    if crc.sum() != member.crc {
        return Err("has a wrong checksum".to_owned());
    }
    Ok(content)
}
