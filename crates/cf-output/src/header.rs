//! The XML header of a VTK file with raw appended data: tags, attributes, and checked access to the blocks.

use std::str::FromStr;

use crate::text::unescape;

/// An opening (or self-closing) tag.
#[derive(Debug, Clone)]
pub(crate) struct Tag {
    pub name: String,
    /// Name of the enclosing element, empty at the top.
    pub section: String,
    attributes: Vec<(String, String)>,
}

impl Tag {
    pub fn attribute(&self, name: &str) -> Result<&str, String> {
        let found = self.attributes.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| value.as_str()).ok_or_else(|| format!("<{}> has no {name}", self.name))
    }

    /// Exactly `N` numbers separated by white space.
    pub fn numbers<T: FromStr, const N: usize>(&self, name: &str) -> Result<[T; N], String> {
        let wrong = || format!("{name} of <{}> is not {N} numbers", self.name);
        let words = self.attribute(name)?.split_ascii_whitespace();
        let values: Vec<T> = words.take(N + 1).map_while(|w| w.parse().ok()).collect();
        values.try_into().map_err(|_| wrong())
    }
}

/// All tags of a text in order.
pub(crate) fn tags(text: &str) -> Result<Vec<Tag>, String> {
    let (mut found, mut open) = (vec![], vec![]);
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = tag_end(rest).ok_or("a tag is not closed")?;
        let (inside, after) = (&rest[..end], &rest[end + 1..]);
        rest = after;
        if inside.starts_with(['?', '!']) {
            continue;
        }
        if let Some(name) = inside.strip_prefix('/') {
            if open.pop().as_deref() != Some(name.trim()) {
                return Err(format!("</{}> closes nothing", name.trim()));
            }
            continue;
        }
        let (body, alone) = match inside.strip_suffix('/') {
            Some(body) => (body, true),
            None => (inside, false),
        };
        let name_end = body.find(char::is_whitespace).unwrap_or(body.len());
        let name = body[..name_end].to_string();
        let section = open.last().cloned().unwrap_or_default();
        if !alone {
            open.push(name.clone());
        }
        found.push(Tag { name, section, attributes: attributes(&body[name_end..])? });
    }
    Ok(found)
}

/// The first `>` outside quotes.
fn tag_end(text: &str) -> Option<usize> {
    let mut quoted = false;
    text.bytes().position(|b| {
        quoted ^= b == b'"';
        b == b'>' && !quoted
    })
}

fn attributes(text: &str) -> Result<Vec<(String, String)>, String> {
    let mut found = vec![];
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let (name, after) = rest.split_once("=\"").ok_or("an attribute has no quoted value")?;
        let (value, after) = after.split_once('"').ok_or("an attribute is not closed")?;
        found.push((name.trim().to_string(), unescape(value)));
        rest = after.trim_start();
    }
    Ok(found)
}

/// Header tags and the appended bytes of one file.
pub(crate) struct Header<'a> {
    tags: Vec<Tag>,
    data: &'a [u8],
    /// Bytes not yet claimed by an array: two arrays cannot share a block, so a small file stays small.
    unclaimed: usize,
}

impl<'a> Header<'a> {
    /// Splits the file and checks that it is of `kind`, little endian, raw, with 64-bit lengths.
    pub fn parse(bytes: &'a [u8], kind: &str) -> Result<Self, String> {
        const MARK: &[u8] = b"<AppendedData encoding=\"raw\">";
        let split = bytes.windows(MARK.len()).position(|w| w == MARK).ok_or("has no raw appended data")?;
        let after = bytes[split + MARK.len()..].trim_ascii_start();
        let data = after.strip_prefix(b"_").ok_or("the appended data does not start with an underscore")?;
        let text = std::str::from_utf8(&bytes[..split]).map_err(|_| "the header is not text")?;
        let header = Self { tags: tags(text)?, data, unclaimed: data.len() };
        let file = header.find("VTKFile")?;
        for (name, expected) in [("type", kind), ("byte_order", "LittleEndian"), ("header_type", "UInt64")] {
            let found = file.attribute(name)?;
            if found != expected {
                return Err(format!("{name} is {found}, not {expected}"));
            }
        }
        Ok(header)
    }

    /// The first tag of a name.
    pub fn find(&self, name: &str) -> Result<&Tag, String> {
        self.tags.iter().find(|t| t.name == name).ok_or_else(|| format!("has no <{name}>"))
    }

    /// The arrays directly inside an element.
    pub fn arrays(&self, section: &str) -> Vec<Tag> {
        let inside = |t: &&Tag| t.name == "DataArray" && t.section == section;
        self.tags.iter().filter(inside).cloned().collect()
    }

    /// The bytes of an array that must hold `tuples` items of `bytes_each`.
    pub fn block(&mut self, tag: &Tag, bytes_each: usize, tuples: usize) -> Result<&'a [u8], String> {
        let name = tag.attribute("Name")?;
        let short = || format!("array '{name}' is not wholly in the file");
        let [offset] = tag.numbers::<usize, 1>("offset")?;
        let (length, rest) = self.data.get(offset..).and_then(|d| d.split_first_chunk::<8>()).ok_or_else(short)?;
        let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| short())?;
        if bytes_each == 0 || bytes_each.checked_mul(tuples) != Some(length) {
            return Err(format!("array '{name}' has {length} bytes, not {tuples} x {bytes_each}"));
        }
        let block = rest.get(..length).ok_or_else(short)?;
        self.unclaimed = self.unclaimed.checked_sub(length + 8).ok_or("arrays overlap")?;
        Ok(block)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_know_their_section_and_attributes() {
        let found = tags("<?xml?><A x=\"1 2\"><B y=\"a&gt;b>\"/><C></C></A>").unwrap();
        let shape: Vec<(&str, &str)> = found.iter().map(|t| (t.name.as_str(), t.section.as_str())).collect();
        assert_eq!(shape, [("A", ""), ("B", "A"), ("C", "A")]);
        assert_eq!(found[1].attribute("y").unwrap(), "a>b>");
        assert_eq!(found[0].numbers::<u32, 2>("x").unwrap(), [1, 2]);
        assert!(found[0].numbers::<u32, 1>("x").is_err() && found[0].numbers::<u32, 3>("x").is_err());
    }

    #[test]
    fn broken_markup_is_an_error() {
        for text in ["<A", "<A x=1>", "<A x=\"1>", "</A>", "<A></B>"] {
            assert!(tags(text).is_err(), "{text}");
        }
    }

    #[test]
    fn blocks_may_not_overlap() {
        let text = "<VTKFile type=\"T\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><S>\
                    <DataArray Name=\"a\" offset=\"0\"/><DataArray Name=\"b\" offset=\"0\"/></S></VTKFile>";
        let mut bytes = text.as_bytes().to_vec();
        bytes.extend(b"<AppendedData encoding=\"raw\">_");
        bytes.extend(4_u64.to_le_bytes());
        bytes.extend([1, 2, 3, 4]);
        let mut header = Header::parse(&bytes, "T").unwrap();
        let arrays = header.arrays("S");
        assert_eq!(header.block(&arrays[0], 1, 4).unwrap(), [1, 2, 3, 4]);
        assert_eq!(header.block(&arrays[1], 1, 4).unwrap_err(), "arrays overlap");
    }
}
