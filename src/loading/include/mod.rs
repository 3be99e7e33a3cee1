//! `include`: parts of a scene in files of their own, with paths relative to the file that names them.
//!
//! - `fluid: include("water.ron")`: the file holds the value. In a list, `[include("walls.ron"), Sphere(…)]`, the
//!   entries of a file that holds a list are entries of it.
//! - `include: "base.ron"`, or a list of files: they hold fields of the bracket, `(spacing: …, boundaries: […])`. Lists
//!   that several of them give are joined; anything else may be given once.
//!
//! The files are put together to one text, and every part of it keeps its origin: errors point into the file that they
//! are in. Files that a fragment names (meshes, tables) are relative to the fragment.

mod mapped;
mod merge;

use std::fs;
use std::path::{Path, PathBuf};

use mapped::Mapped;

use super::explain::explain_in_file;
use super::ron_text::options;
use super::spans::{Kind, Node, line_column, scan};
use crate::input::{no_file, read_text, without_mark};
use crate::scene::{Place, SceneError};

/// Most fragments in one scene, and most bytes of the whole: fragments that include each other twice grow without end.
const MOST_FRAGMENTS: usize = 1000;
const MOST_BYTES: usize = 64 << 20;

/// The word for fragments, as a field and as a value.
const WORD: &str = "include";
/// Fields that name a file.
const FILE_FIELDS: [&str; 2] = ["file", "order"];

/// A scene's text with its fragments put in.
#[derive(Debug)]
pub(super) struct Source {
    whole: Mapped,
    files: Vec<SourceFile>,
}

/// A file of a scene.
#[derive(Debug)]
struct SourceFile {
    /// As errors call it.
    name: String,
    text: String,
    /// Fragments that it was included by, and itself, to notice circles.
    path: PathBuf,
}

impl Source {
    /// Puts the fragments of a text into it. `file_name` stands in errors, and paths are relative to its folder.
    pub(super) fn new(text: &str, file_name: &str) -> Result<Self, SceneError> {
        let path = PathBuf::from(file_name);
        let text = without_mark(text).to_owned();
        let mut source = Self {
            whole: Mapped::default(),
            files: vec![SourceFile {
                name: file_name.to_owned(),
                text,
                path,
            }],
        };
        source.whole = source.expand(0, &mut vec![0])?;
        Ok(source)
    }

    /// The whole text.
    pub(super) fn text(&self) -> &str {
        &self.whole.text
    }

    /// The files of fragments.
    pub(super) fn fragments(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().skip(1).map(|file| file.path.as_path())
    }

    /// An error in the whole text, at the place where the files have it.
    pub(super) fn placed(&self, mut error: SceneError) -> SceneError {
        if self.files.len() > 1
            && let SceneError::Syntax { place, .. } | SceneError::Invalid { place, .. } = &mut error
            && let Place::File { line, column, .. } = place
        {
            let byte = super::spans::byte_at(&self.whole.text, *line, *column);
            let (file, byte) = self.whole.origin(byte);
            *place = self.place(file, byte);
        }
        error
    }

    fn place(&self, file: usize, byte: usize) -> Place {
        let SourceFile { name, text, .. } = &self.files[file];
        let (line, column) = line_column(text, byte);
        Place::File {
            file: name.clone(),
            line,
            column,
        }
    }

    fn refuse<T>(&self, (file, byte): (usize, usize), message: String) -> Result<T, SceneError> {
        let place = self.place(file, byte);
        Err(SceneError::Syntax { place, message })
    }

    /// A file with its fragments put in. `within` are the files around it, itself the last.
    fn expand(&mut self, file: usize, within: &mut Vec<usize>) -> Result<Mapped, SceneError> {
        let own = Mapped::of_file(&self.files[file].text, file);
        let text = own.text.clone();
        let Some(tree) = scan(&text) else {
            // The scene's own mistakes are told by whoever reads the whole.
            return if within.len() == 1 {
                Ok(own)
            } else {
                Err(self.no_value(file))
            };
        };
        if !includes(&tree) {
            return Ok(own);
        }
        let mut out = Mapped::default();
        self.put(&own, &tree, &mut out, within)?;
        out.copy(&own, tree.span.end..text.len());
        let mut whole = Mapped::default();
        whole.copy(&own, 0..tree.span.start);
        whole.append(&out);
        Ok(whole)
    }

    /// What is wrong with a fragment that is no value.
    fn no_value(&self, file: usize) -> SceneError {
        let SourceFile { name, text, .. } = &self.files[file];
        match options().from_str::<ron::Value>(text) {
            Err(error) => explain_in_file::<ron::Value>(&error, text, name),
            Ok(_) => SceneError::Syntax {
                place: self.place(file, 0),
                message: "the fragment holds no single value".to_owned(),
            },
        }
    }

    /// Reads and expands a fragment that a text names at a byte of it.
    fn fragment(
        &mut self,
        (from, node): (&Mapped, &Node),
        within: &mut Vec<usize>,
    ) -> Result<Mapped, SceneError> {
        let origin = from.origin(node.span.start);
        let path: Result<String, _> = ron::from_str(&from.text[node.span.clone()]);
        let Ok(path) = path else {
            let message =
                "expected the path of a file in double quotes, such as `include(\"water.ron\")`";
            return self.refuse(origin, message.to_owned());
        };
        let folder = self.files[origin.0]
            .path
            .parent()
            .unwrap_or(Path::new(""))
            .to_owned();
        let full = folder.join(&path);
        if let Some(reason) = no_file(&full) {
            return self.refuse(
                origin,
                format!("{reason}; paths are relative to the file that names them"),
            );
        }
        let same = |other: &usize| {
            let other = &self.files[*other].path;
            fs::canonicalize(other)
                .is_ok_and(|other| fs::canonicalize(&full).is_ok_and(|full| full == other))
        };
        if let Some(first) = within.iter().position(same) {
            let names = within[first..]
                .iter()
                .map(|file| self.files[*file].name.as_str());
            let circle: Vec<&str> = names.chain([path.as_str()]).collect();
            return self.refuse(
                origin,
                format!("a file includes itself: {}", circle.join(" → ")),
            );
        }
        if self.files.len() > MOST_FRAGMENTS {
            return self.refuse(
                origin,
                format!("a scene has at most {MOST_FRAGMENTS} fragments"),
            );
        }
        let text = match read_text(&full) {
            Ok(text) => text,
            Err(error) => return self.refuse(origin, format!("cannot read `{path}`: {error}")),
        };
        self.files.push(SourceFile {
            name: full.display().to_string(),
            text,
            path: full,
        });
        let file = self.files.len() - 1;
        within.push(file);
        let expanded = self.expand(file, within);
        within.pop();
        let fragment = value_of(
            &expanded?,
            Path::new(&path).parent().unwrap_or(Path::new("")),
        );
        if fragment.text.len() > MOST_BYTES {
            return self.refuse(
                origin,
                format!("the fragments are longer than {} MiB", MOST_BYTES >> 20),
            );
        }
        Ok(fragment)
    }
}

/// Whether a value names fragments.
fn includes(node: &Node) -> bool {
    if included(node).is_some() {
        return true;
    }
    match &node.kind {
        Kind::Fields(fields) => {
            let mut fields = fields.iter();
            fields.any(|field| field.key == WORD || includes(&field.value))
        }
        Kind::Tuple(items) | Kind::List(items) => items.iter().any(|item| includes(item)),
        Kind::Leaf => false,
    }
}

/// The path in `include("…")`.
fn included<'t, 'a>(node: &'t Node<'a>) -> Option<&'t Node<'a>> {
    match &node.kind {
        Kind::Tuple(items) if node.name == Some(WORD) => match items.as_slice() {
            [path] => Some(path),
            _ => None,
        },
        _ => None,
    }
}

/// The value of a fragment, without comments around it, and with the paths in it relative to the file that includes it
/// from `folder`.
fn value_of(fragment: &Mapped, folder: &Path) -> Mapped {
    let Some(tree) = scan(&fragment.text) else {
        return fragment.clone();
    };
    let mut paths = Vec::new();
    tree.leaves("", &mut |path, leaf| {
        let field = path.rsplit('.').next().unwrap_or_default();
        let text = &fragment.text[leaf.span.clone()];
        if FILE_FIELDS.contains(&field)
            && let Ok(file) = ron::from_str::<String>(text)
            && let Ok(moved) = ron::to_string(&folder.join(file).display().to_string())
        {
            paths.push((leaf.span.clone(), moved));
        }
    });
    paths.sort_by_key(|(span, _)| span.start);
    let mut out = Mapped::default();
    let mut done = tree.span.start;
    for (span, moved) in paths {
        out.copy(fragment, done..span.start);
        out.glue(&moved, fragment.origin(span.start));
        done = span.end;
    }
    out.copy(fragment, done..tree.span.end);
    out
}
