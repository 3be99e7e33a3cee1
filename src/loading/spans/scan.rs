//! Reads RON's shape: brackets, names, commas, comments, literals.

use super::{Field, Kind, Node};

/// Deeper nesting is refused; the deepest scene has about six levels.
const MAX_DEPTH: usize = 64;

/// Reads the shape of a RON text that holds one value; none if it is not well formed.
pub(in crate::loading) fn scan(text: &str) -> Option<Node<'_>> {
    let mut scanner = Scanner { text, at: 0 };
    scanner.skip_blank()?;
    while scanner.rest().starts_with("#!") {
        scanner.at += scanner.rest().find(']')? + 1;
        scanner.skip_blank()?;
    }
    let node = scanner.value(0)?;
    scanner.skip_blank()?;
    scanner.rest().is_empty().then_some(node)
}

struct Scanner<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Scanner<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn eat(&mut self, token: char) -> bool {
        let found = self.peek() == Some(token);
        if found {
            self.at += token.len_utf8();
        }
        found
    }

    /// Skips white space and comments; none if a block comment has no end.
    fn skip_blank(&mut self) -> Option<()> {
        loop {
            let rest = self.rest();
            self.at += rest.len() - rest.trim_start().len();
            let rest = self.rest();
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if rest.starts_with("/*") {
                self.skip_block_comment()?;
            } else {
                return Some(());
            }
        }
    }

    fn skip_block_comment(&mut self) -> Option<()> {
        let mut depth = 0_usize;
        loop {
            let rest = self.rest();
            if rest.starts_with("/*") {
                depth += 1;
                self.at += 2;
            } else if rest.starts_with("*/") {
                depth -= 1;
                self.at += 2;
            } else {
                self.at += rest.chars().next()?.len_utf8();
            }
            if depth == 0 {
                return Some(());
            }
        }
    }

    fn value(&mut self, depth: usize) -> Option<Node<'a>> {
        if depth > MAX_DEPTH {
            return None;
        }
        let start = self.at;
        let name = self.name();
        let after_name = self.at;
        if name.is_some() {
            self.skip_blank()?;
        }
        let kind = match self.peek() {
            Some('(') => self.parenthesis(depth)?,
            Some('[') if name.is_none() => Kind::List(self.items('[', ']', depth)?),
            Some('{') if name.is_none() => self.map(depth)?,
            _ if name.is_some() => {
                self.at = after_name;
                return Some(Node {
                    span: start..after_name,
                    name: None,
                    kind: Kind::Leaf,
                });
            }
            _ => self.scalar()?,
        };
        Some(Node {
            span: start..self.at,
            name,
            kind,
        })
    }

    /// A name, unless what follows is a literal that starts with a letter.
    fn name(&mut self) -> Option<&'a str> {
        let rest = self.rest();
        let literal = ["b\"", "b'", "r\"", "r#\"", "r##", "br"];
        if literal.iter().any(|start| rest.starts_with(start)) {
            return None;
        }
        let body = rest.strip_prefix("r#").unwrap_or(rest);
        if !body.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            return None;
        }
        let length = body
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(body.len());
        self.at += rest.len() - body.len() + length;
        Some(&body[..length])
    }

    fn parenthesis(&mut self, depth: usize) -> Option<Kind<'a>> {
        let open = self.at;
        self.at += 1;
        self.skip_blank()?;
        let named = self.name().is_some() && {
            self.skip_blank()?;
            self.peek() == Some(':') && !self.rest().starts_with("::")
        };
        self.at = open;
        if named {
            self.fields(depth).map(Kind::Fields)
        } else {
            self.items('(', ')', depth).map(Kind::Tuple)
        }
    }

    fn fields(&mut self, depth: usize) -> Option<Vec<Field<'a>>> {
        let mut fields = Vec::new();
        self.eat('(');
        loop {
            self.skip_blank()?;
            if self.eat(')') {
                return Some(fields);
            }
            let start = self.at;
            let key = self.name()?;
            let key_span = start..self.at;
            self.skip_blank()?;
            if !self.eat(':') {
                return None;
            }
            self.skip_blank()?;
            let value = self.value(depth + 1)?;
            fields.push(Field {
                key,
                key_span,
                value,
            });
            self.separator(')')?;
        }
    }

    fn items(&mut self, open: char, close: char, depth: usize) -> Option<Vec<Node<'a>>> {
        let mut items = Vec::new();
        self.eat(open);
        loop {
            self.skip_blank()?;
            if self.eat(close) {
                return Some(items);
            }
            items.push(self.value(depth + 1)?);
            self.separator(close)?;
        }
    }

    /// A comma, or nothing before the closing bracket.
    fn separator(&mut self, close: char) -> Option<()> {
        self.skip_blank()?;
        (self.eat(',') || self.peek() == Some(close)).then_some(())
    }

    fn map(&mut self, depth: usize) -> Option<Kind<'a>> {
        self.eat('{');
        loop {
            self.skip_blank()?;
            if self.eat('}') {
                return Some(Kind::Leaf);
            }
            self.value(depth + 1)?;
            self.skip_blank()?;
            if !self.eat(':') {
                return None;
            }
            self.skip_blank()?;
            self.value(depth + 1)?;
            self.separator('}')?;
        }
    }

    fn scalar(&mut self) -> Option<Kind<'a>> {
        let rest = self.rest();
        let body = rest.trim_start_matches(['b', 'r']);
        let hashes = body.len() - body.trim_start_matches('#').len();
        let prefix = rest.len() - body.len();
        let length = if rest[..prefix].contains('r') {
            let close = format!("\"{}", "#".repeat(hashes));
            let inner = body[hashes..].strip_prefix('"')?;
            prefix + hashes + 1 + inner.find(&close)? + close.len()
        } else if let Some(inner) = body.strip_prefix('"') {
            prefix + 1 + quoted_length(inner, '"')?
        } else if let Some(inner) = body.strip_prefix('\'') {
            prefix + 1 + quoted_length(inner, '\'')?
        } else {
            // A number: up to a bracket, a comma, a colon, white space or a comment.
            rest.find(|c: char| c.is_whitespace() || "()[]{},:/\"'".contains(c))
                .unwrap_or(rest.len())
        };
        self.at += length;
        (length > 0).then_some(Kind::Leaf)
    }
}

/// Bytes up to and with the closing quote; a backslash escapes the character after it.
fn quoted_length(text: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    for (at, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return Some(at + 1),
            _ => {}
        }
    }
    None
}
