//! The smallest parts of a scene text: words, numbers, strings, blanks and comments.

use super::Flaw;
use super::scan::Scanner;
use crate::error::{Detail, shorten};

impl<'a> Scanner<'a> {
    pub(super) fn quoted(&mut self) -> Result<String, Flaw> {
        let start = self.at;
        let mut escaped = false;
        for (i, c) in self.rest().char_indices().skip(1) {
            match c {
                _ if escaped => escaped = false,
                '\\' => escaped = true,
                '"' => {
                    self.at += i + 1;
                    return self.unescape(start);
                }
                _ => {}
            }
        }
        Err(Flaw::new(start..start + 1, Detail::new("this string is never closed").expected("a closing `\"`")))
    }

    /// Leaves the meaning of escapes to the RON crate, so that both readers agree.
    pub(super) fn unescape(&self, start: usize) -> Result<String, Flaw> {
        ron::from_str(&self.text[start..self.at]).map_err(|error: ron::error::SpannedError| {
            Flaw::new(start..self.at, Detail::new(format!("this string has a wrong escape ({})", error.code)))
        })
    }

    pub(super) fn character(&mut self) -> Result<(), Flaw> {
        let start = self.at;
        let mut escaped = false;
        for (i, c) in self.rest().char_indices().skip(1).take_while(|(i, c)| *i <= 12 && *c != '\n') {
            match c {
                _ if escaped => escaped = false,
                '\\' => escaped = true,
                '\'' => {
                    self.at += i + 1;
                    return Ok(());
                }
                _ => {}
            }
        }
        Err(Flaw::new(start..start + 1, Detail::new("this character is never closed").expected("a closing `'`")))
    }

    pub(super) fn raw_string_hashes(&self) -> Option<usize> {
        let after = self.rest().strip_prefix('r')?;
        let hashes = after.len() - after.trim_start_matches('#').len();
        after[hashes..].starts_with('"').then_some(hashes)
    }

    pub(super) fn raw_string(&mut self) -> Result<String, Flaw> {
        let start = self.at;
        let hashes = self.raw_string_hashes().unwrap_or(0);
        let body = start + hashes + 2;
        let close = format!("\"{}", "#".repeat(hashes));
        match self.text[body..].find(&close) {
            Some(length) => {
                self.at = body + length + close.len();
                Ok(self.text[body..body + length].to_owned())
            }
            None => {
                let detail =
                    Detail::new("this raw string is never closed").expected(format!("a closing `{}`", shorten(&close)));
                Err(Flaw::new(start..body, detail))
            }
        }
    }

    pub(super) fn number(&mut self) {
        let mut last = ' ';
        let length = self.rest().find(|c: char| {
            let sign_belongs = matches!(last, ' ' | 'e' | 'E');
            last = c;
            !(c.is_alphanumeric() || matches!(c, '.' | '_') || (matches!(c, '+' | '-') && sign_belongs))
        });
        self.at += length.unwrap_or(self.rest().len());
    }

    pub(super) fn word(&mut self) -> &'a str {
        let rest = &self.text[self.at..];
        let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    pub(super) fn skip_blanks(&mut self) -> Result<(), Flaw> {
        loop {
            let rest = self.rest();
            let blanks = rest.len() - rest.trim_start_matches(is_blank).len();
            self.at += blanks;
            let rest = &rest[blanks..];
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if rest.starts_with("/*") {
                self.block_comment()?;
            } else {
                return Ok(());
            }
        }
    }

    pub(super) fn block_comment(&mut self) -> Result<(), Flaw> {
        let start = self.at;
        let mut depth = 0usize;
        while let Some(next) = self.rest().find(['/', '*']) {
            self.at += next;
            if self.rest().starts_with("/*") {
                (depth, self.at) = (depth + 1, self.at + 2);
            } else if self.rest().starts_with("*/") {
                (depth, self.at) = (depth - 1, self.at + 2);
            } else {
                self.at += 1;
            }
            if depth == 0 {
                return Ok(());
            }
        }
        Err(Flaw::new(start..start + 2, Detail::new("this comment is never closed").expected("a closing `*/`")))
    }

    pub(super) fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    pub(super) fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    pub(super) fn here(&self) -> String {
        match self.peek() {
            None => "the end of the text".to_owned(),
            Some(c) => format!("`{}`", shorten(&c.to_string())),
        }
    }

    pub(super) fn flaw_here(&self, detail: Detail) -> Flaw {
        Flaw::new(self.at..self.at + self.peek().map_or(0, char::len_utf8), detail)
    }

    pub(super) fn unclosed(&self, start: usize, open: char) -> Flaw {
        Flaw::new(start..start + 1, Detail::new(format!("this `{open}` is never closed")))
    }
}

pub(super) fn starts_word(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

/// The blanks of RON.
fn is_blank(c: char) -> bool {
    matches!(c, '\t'..='\r' | ' ' | '\u{85}' | '\u{200E}' | '\u{200F}' | '\u{2028}' | '\u{2029}')
}
