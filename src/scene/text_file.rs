//! Text files of the user's: bounded before they are read, UTF-8, without a byte order mark.

use super::TextFile;
use super::asset::hexadecimal;
use crate::base::diagnostic::{Diagnostic, Fault, Place, Source};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Largest scene or species file, in bytes.
pub const LARGEST: u64 = 16_000_000;

/// Reads a text file; `name` is how messages call it.
///
/// # Errors
/// It cannot be read, is too large, or is not UTF-8 (with the place of the first wrong byte).
pub fn read(path: &Path, name: &str) -> Result<(Arc<Source>, TextFile), Diagnostic> {
    let unreadable = |error: &dyn std::fmt::Display| {
        let place = Place { source: source(name, String::new()), span: 0..0 };
        let help = "give the path of a scene file that may be read";
        Diagnostic::error(Fault::Scene, format!("cannot read this file: {error}"), help).at(Some(place))
    };
    let found = std::fs::metadata(path).map_err(|error| unreadable(&error))?;
    if !found.is_file() {
        // opening a pipe waits for its writer, and a device may never end
        return Err(unreadable(&"it is a folder, pipe or device"));
    }
    let length = found.len();
    let mut bytes = Vec::new();
    if length <= LARGEST {
        let file = File::open(path).map_err(|error| unreadable(&error))?;
        // it may have grown: never take more than one byte too many
        file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(|error| unreadable(&error))?;
    }
    if length > LARGEST || bytes.len() as u64 > LARGEST {
        let what = format!("{name} is larger than {} MB, the most that is read of a text file", LARGEST / 1_000_000);
        return Err(Diagnostic::error(
            Fault::Limit,
            what,
            "no flag raises this; put long lists into pictures or series",
        ));
    }
    let sha256 = hexadecimal(&Sha256::digest(&bytes));
    let text = decode(bytes, name)?;
    Ok((source(name, text), TextFile { name: name.to_owned(), sha256 }))
}

fn decode(bytes: Vec<u8>, name: &str) -> Result<String, Diagnostic> {
    match String::from_utf8(bytes) {
        Ok(text) => Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text)),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let bytes = error.into_bytes();
            let what = format!("byte 0x{:02x} is not UTF-8", bytes[at]);
            let source = source(name, String::from_utf8_lossy(&bytes).into_owned());
            let place = Place { source, span: at..at + 1 };
            Err(Diagnostic::error(Fault::Scene, what, "save the file as UTF-8").at(Some(place)))
        }
    }
}

fn source(name: &str, text: String) -> Arc<Source> {
    Arc::new(Source { name: name.to_owned(), text })
}
