//! Reads files that a user names. Devices, pipes and folders are refused before they are opened.

use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Longest text that is read \[bytes]. A scene of 100 000 bodies has a tenth of it.
pub const MAX_TEXT_BYTES: u64 = 64 << 20;

/// Longest file of other data, a mesh or a frame, that is read \[bytes].
pub const MAX_BYTES: u64 = 16 << 30;

/// Reads a text in UTF-8; a byte order mark is removed.
///
/// # Errors
/// When the system refuses, when it is no file (a pipe, a device, a folder), longer than [`MAX_TEXT_BYTES`], or not in
/// UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read_up_to(path, MAX_TEXT_BYTES)?;
    let is_utf_16 = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    let text = String::from_utf8(bytes).map_err(|error| {
        let line = 1
            + (error.as_bytes()[..error.utf8_error().valid_up_to()].iter())
                .filter(|&&byte| byte == b'\n')
                .count();
        invalid(if is_utf_16 {
            "it is text in UTF-16; save it as UTF-8".to_owned()
        } else {
            format!("line {line} is not text in UTF-8; save it as UTF-8")
        })
    })?;
    Ok(match without_mark(&text) {
        rest if rest.len() == text.len() => text,
        rest => rest.to_owned(),
    })
}

/// Length of a file \[bytes] and a checksum of its content, by which a change is noticed.
///
/// # Errors
/// As [`read_bytes`].
pub fn fingerprint(path: &Path) -> io::Result<(u64, u32)> {
    let mut file = open(path)?;
    let (mut length, mut sum) = (0, crc32fast::Hasher::new());
    let mut part = vec![0; 1 << 16];
    loop {
        let read = match file.read(&mut part) {
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            read => read?,
        };
        if read == 0 {
            return Ok((length, sum.finalize()));
        }
        length += read as u64;
        sum.update(&part[..read]);
    }
}

/// Reads a file's bytes.
///
/// # Errors
/// When the system refuses, when it is no file (a pipe, a device, a folder), or longer than [`MAX_BYTES`].
pub fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    read_up_to(path, MAX_BYTES)
}

/// A text without the byte order mark that editors on Windows put before it.
pub(crate) fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// Opens a file to read it.
///
/// # Errors
/// When the system refuses, or it is no file (a pipe, a device, a folder).
pub fn open(path: &Path) -> io::Result<File> {
    is_file(path)?;
    File::open(path)
}

/// Why no file is at `path`, in a sentence; none if one is.
pub(crate) fn no_file(path: &Path) -> Option<String> {
    let shown = path.display();
    match fs::metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            Some(format!("there is no file `{shown}`"))
        }
        Err(error) => Some(format!("`{shown}` cannot be read: {error}")),
        Ok(found) if is_regular(&found) => None,
        Ok(found) => Some(format!("`{shown}` is {}; name a file", kind_of(&found))),
    }
}

/// What the system knows of a file. Opening a pipe would wait for a writer, so it is asked before.
fn is_file(path: &Path) -> io::Result<Metadata> {
    let found = fs::metadata(path)?;
    if !is_regular(&found) {
        let what = kind_of(&found);
        return Err(invalid(format!("it is {what}; name a file")));
    }
    Ok(found)
}

/// Whether a disk holds the file.
fn is_regular(found: &Metadata) -> bool {
    found.is_file() && !is_of_the_system(found)
}

/// Whether it is one of the files that the kernel makes when they are read (`/proc/kmsg`). They are told as regular,
/// and reading one may wait for ever.
#[cfg(unix)]
fn is_of_the_system(found: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    let device = |path: &str| fs::metadata(path).ok().map(|of| of.dev());
    let root = device("/");
    let of_kernel = ["/proc", "/sys", "/sys/kernel/debug", "/sys/kernel/tracing"].map(device);
    let mut of_kernel = of_kernel
        .into_iter()
        .filter(|of| of.is_some() && *of != root);
    of_kernel.any(|of| of == Some(found.dev()))
}

#[cfg(not(unix))]
fn is_of_the_system(_: &Metadata) -> bool {
    false
}

fn read_up_to(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let found = is_file(path)?;
    let too_long = || invalid(format!("it is longer than {} MiB", most >> 20));
    if found.len() > most {
        return Err(too_long());
    }
    let mut bytes = Vec::new();
    // A file may grow while it is read.
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(too_long());
    }
    Ok(bytes)
}

fn invalid(message: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, message)
}

fn kind_of(found: &Metadata) -> &'static str {
    let kind = found.file_type();
    if found.is_file() {
        return "a file of the operating system, which makes it while it is read";
    }
    if kind.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    "no file"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(path: &Path) -> String {
        read_text(path).expect_err("refused").to_string()
    }

    #[test]
    fn a_mark_is_left_out_and_other_encodings_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("text");
        let of = |bytes: &[u8]| {
            fs::write(&path, bytes).expect("a file");
            read_text(&path).map_err(|error| error.to_string())
        };
        assert_eq!(of(b"\xef\xbb\xbf(a)"), Ok("(a)".to_owned()));
        assert_eq!(of(b"(a)\xef\xbb\xbf"), Ok("(a)\u{feff}".to_owned()));
        let refusal = |bytes| of(bytes).expect_err("refused");
        assert!(refusal(b"\xff\xfe(\0)\0").contains("UTF-16"));
        assert!(refusal(b"(\n\n\xe4)").contains("line 3 is not text in UTF-8"));
    }

    #[test]
    fn what_is_no_file_is_refused_by_its_kind() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(refusal(folder.path()).contains("a folder"));
        let long = folder.path().join("long");
        let file = File::create(&long).expect("a file");
        file.set_len(MAX_TEXT_BYTES + 1).expect("a sparse file");
        assert!(refusal(&long).contains("longer than 64 MiB"));
        #[cfg(unix)]
        {
            assert!(refusal(Path::new("/dev/zero")).contains("a device"));
            for of_kernel in ["/proc/kmsg", "/proc/cpuinfo", "/sys/kernel/notes"] {
                if fs::metadata(of_kernel).is_ok() {
                    let (said, found) =
                        (refusal(Path::new(of_kernel)), no_file(Path::new(of_kernel)));
                    assert!(
                        said.contains("of the operating system"),
                        "{of_kernel}: {said}"
                    );
                    assert!(found.is_some_and(|found| found.contains("name a file")));
                }
            }
            let pipe = folder.path().join("pipe");
            let made = std::process::Command::new("mkfifo").arg(&pipe).status();
            assert!(made.is_ok_and(|status| status.success()));
            assert!(refusal(&pipe).contains("a pipe"));
            let opened = open(&pipe).expect_err("refused").to_string();
            assert!(opened.contains("a pipe"), "{opened}");
            for (path, what) in [
                (&*pipe, "is a pipe"),
                (Path::new("/dev/zero"), "is a device"),
                (folder.path(), "is a folder"),
                (&folder.path().join("none"), "there is no file"),
                (&long.join("none"), "cannot be read"),
            ] {
                let said = no_file(path).expect("no file");
                assert!(said.contains(what), "{said}");
            }
            assert_eq!(no_file(&long), None);
        }
    }
}
