//! Values of Part 21 strings: what stands between the quotes -> text.

use crate::model::SyntaxRepair;
use std::borrow::Cow;

/// Appends the value of a string to `out`, and returns what it took to read it.
///
/// `raw` is what stands between the quotes, in UTF-8 or else ISO 8859-1. Line breaks are dropped: programs break long
/// lines. A directive that breaks the rules of ISO 10303-21, or selects an alphabet other than ISO 8859-1, stays as it
/// is written.
pub(super) fn decode(raw: &[u8], out: &mut String) -> Option<SyntaxRepair> {
    // Most names are empty.
    if raw.is_empty() {
        return None;
    }
    let text: Cow<'_, str> = match std::str::from_utf8(raw) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(raw.iter().map(|byte| char::from(*byte)).collect()),
    };
    if !text.bytes().any(|byte| matches!(byte, b'\'' | b'\\' | b'\r' | b'\n')) {
        out.push_str(&text);
        return None;
    }
    let text = text.replace("''", "'").replace(['\r', '\n'], "");
    let mut rest = text.as_str();
    let (mut latin, mut repair) = (true, None);
    while let Some(at) = rest.find('\\') {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let length = if let Some(page) = page(rest) {
            latin = page == b'A';
            if latin { Some(4) } else { None }
        } else {
            directive(rest, latin, out, &mut repair)
        };
        let length = length.unwrap_or_else(|| {
            let length = as_written(rest);
            out.push_str(&rest[..length]);
            repair = Some(SyntaxRepair::Escape);
            length
        });
        rest = &rest[length..];
    }
    out.push_str(rest);
    repair
}

/// The letter of `\PA\` to `\PI\`, which select the part of ISO 8859 of `\S\`.
fn page(text: &str) -> Option<u8> {
    match text.as_bytes() {
        [b'\\', b'P', letter @ b'A'..=b'I', b'\\', ..] => Some(*letter),
        _ => None,
    }
}

/// Appends the character or characters of the directive that `text` starts with, and returns its length. `None` if it
/// breaks the rules.
fn directive(text: &str, latin: bool, out: &mut String, repair: &mut Option<SyntaxRepair>) -> Option<usize> {
    let bytes = text.as_bytes();
    if bytes.starts_with(b"\\\\") {
        out.push('\\');
        return Some(2);
    }
    let (digits, length) = match bytes.get(1..3)? {
        b"S\\" => {
            let character = *bytes.get(3).filter(|byte| latin && matches!(byte, 0x20..=0x7E))?;
            out.push(char::from(character | 0x80));
            return Some(4);
        }
        b"X\\" => {
            let digits = text.get(3..5)?;
            out.push(char::from(u8::try_from(hexadecimal(digits)?).ok()?));
            (digits, 5)
        }
        b"X2" | b"X4" => {
            let digits = run(text)?;
            out.push_str(&characters(digits, if bytes[2] == b'2' { 4 } else { 8 })?);
            (digits, digits.len() + 8)
        }
        _ => return None,
    };
    if digits.bytes().any(|digit| digit.is_ascii_lowercase()) {
        repair.get_or_insert(SyntaxRepair::LowercaseHexadecimal);
    }
    Some(length)
}

/// The digits between `\X2\` or `\X4\` and `\X0\`.
fn run(text: &str) -> Option<&str> {
    let rest = text.strip_prefix("\\X2\\").or_else(|| text.strip_prefix("\\X4\\"))?;
    let (digits, end) = rest.split_at(rest.bytes().take_while(u8::is_ascii_hexdigit).count());
    end.starts_with("\\X0\\").then_some(digits)
}

/// Characters of `width` hexadecimal digits each: units of UTF-16, or code points.
fn characters(digits: &str, width: usize) -> Option<String> {
    if digits.is_empty() || !digits.len().is_multiple_of(width) {
        return None;
    }
    let codes = (0..digits.len()).step_by(width).map(|at| hexadecimal(&digits[at..at + width]));
    if width == 4 {
        let units: Option<Vec<u16>> = codes.map(|code| u16::try_from(code?).ok()).collect();
        String::from_utf16(&units?).ok()
    } else {
        codes.map(|code| char::from_u32(code?)).collect()
    }
}

fn hexadecimal(digits: &str) -> Option<u32> {
    // The parser of the standard library takes a sign.
    digits.bytes().all(|digit| digit.is_ascii_hexdigit()).then(|| u32::from_str_radix(digits, 16).ok())?
}

/// Length of a directive that stays as it is written.
fn as_written(text: &str) -> usize {
    let bytes = text.as_bytes();
    match (bytes.get(1..3), run(text), page(text), bytes.get(3)) {
        (_, Some(digits), ..) => digits.len() + 8,
        (_, _, Some(_), _) | (Some(b"S\\"), _, _, Some(0x20..=0x7E)) => 4,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::decode;
    use crate::model::SyntaxRepair;

    #[test]
    fn strings_have_the_values_that_the_standard_gives_them() {
        let escape = Some(SyntaxRepair::Escape);
        for (raw, value, repair) in [
            (&b""[..], "", None),
            (b"it''s", "it's", None),
            (b"a\r\nb", "ab", None),
            (br"a\\b", r"a\b", None),
            (br"\X2\03B103B2\X0\!", "αβ!", None),
            (br"\X2\D83DDE00\X0\", "😀", None),
            (br"\X4\0001F600\X0\", "😀", None),
            (br"\X\E9t\X\E9", "été", None),
            (br"\X\e9", "é", Some(SyntaxRepair::LowercaseHexadecimal)),
            (br"\S\v\PA\\S\v", "öö", None),
            (b"\xE9", "é", None),
            ("é".as_bytes(), "é", None),
            (br"\PB\\S\v", r"\PB\\S\v", escape),
            (br"\PB\\PA\\S\v", r"\PB\ö", escape),
            (br"\X2\zz\X0\", r"\X2\zz\X0\", escape),
            (br"\X2\D83D\X0\", r"\X2\D83D\X0\", escape),
            (br"\X2\00E9", r"\X2\00E9", escape),
            (br"\X\+1", r"\X\+1", escape),
            (br"\n\", r"\n\", escape),
            (br"\X2\123\X0\", r"\X2\123\X0\", escape),
        ] {
            let mut out = "before ".to_owned();
            let found = decode(raw, &mut out);
            assert_eq!((out.as_str(), found), (format!("before {value}").as_str(), repair), "{raw:?}");
        }
    }

    #[test]
    fn many_directives_without_an_end_take_one_pass() {
        let raw = br"\X2\ ".repeat(1 << 20);
        let mut out = String::new();
        assert_eq!((decode(&raw, &mut out), out.as_bytes()), (Some(SyntaxRepair::Escape), raw.as_slice()));
    }
}
