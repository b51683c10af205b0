//! Progress for people and for render farms. `auto` writes lines to a terminal, `json` an object a line, `openjd` the lines
//! that Open Job Description workers read. A line is flushed as soon as it is written; a reader that went away is no fault.

use clap::ValueEnum;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};

/// The form of progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// Lines on stderr when it is a terminal, nothing otherwise.
    #[default]
    Auto,
    /// Nothing.
    None,
    /// A JSON object a line on stdout.
    Json,
    /// The lines of Open Job Description on stdout.
    #[value(name = "openjd")]
    OpenJd,
}

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event<'a> {
    /// The run begins.
    Started {
        /// Frames of this run.
        frames: u64,
    },
    /// A frame was drawn and its files stand.
    Drawn {
        /// Its number.
        frame: i64,
    },
    /// A frame stood already.
    Kept {
        /// Its number.
        frame: i64,
    },
    /// A frame failed.
    Failed {
        /// Its number.
        frame: i64,
        /// Why.
        message: &'a str,
    },
    /// Something is being done that takes time.
    Status {
        /// What.
        message: &'a str,
    },
    /// The run cannot go on.
    Stopped {
        /// Why.
        message: &'a str,
    },
}

/// Writes progress and keeps count.
pub struct Progress {
    mode: Mode,
    out: Option<Box<dyn Write + Send>>,
    frames: u64,
    done: u64,
}

impl Progress {
    /// Progress to the stream that belongs to the mode.
    #[must_use]
    pub fn new(mode: Mode) -> Self {
        let out: Option<Box<dyn Write + Send>> = match mode {
            Mode::Auto if io::stderr().is_terminal() => Some(Box::new(io::stderr())),
            Mode::Auto | Mode::None => None,
            Mode::Json | Mode::OpenJd => Some(Box::new(io::stdout())),
        };
        Self { mode, out, frames: 0, done: 0 }
    }

    /// Progress to a given stream.
    #[must_use]
    pub fn to(mode: Mode, out: Box<dyn Write + Send>) -> Self {
        Self { mode, out: Some(out), frames: 0, done: 0 }
    }

    /// Tells of an event. When the reader has gone, this and all further events are dropped.
    pub fn tell(&mut self, event: Event<'_>) {
        match event {
            Event::Started { frames } => (self.frames, self.done) = (frames, 0),
            Event::Drawn { .. } | Event::Kept { .. } | Event::Failed { .. } => self.done += 1,
            Event::Status { .. } | Event::Stopped { .. } => {}
        }
        let text = match self.mode {
            Mode::None => return,
            Mode::Auto => self.plain(event),
            Mode::Json => self.json(event),
            Mode::OpenJd => self.open_jd(event),
        };
        let Some(out) = &mut self.out else { return };
        if out.write_all(text.as_bytes()).and_then(|()| out.flush()).is_err() {
            self.out = None;
        }
    }

    /// Share of the frames that are done, in per cent; 100 when there are none to do.
    fn per_cent(&self) -> f64 {
        if self.frames == 0 { 100.0 } else { (100.0 * self.done as f64 / self.frames as f64).min(100.0) }
    }

    fn plain(&self, event: Event<'_>) -> String {
        let (done, frames) = (self.done, self.frames);
        match event {
            Event::Started { frames } => format!("{frames} frames to do\n"),
            Event::Drawn { frame } => format!("[{done}/{frames}] frame {frame} drawn\n"),
            Event::Kept { frame } => format!("[{done}/{frames}] frame {frame} kept\n"),
            Event::Failed { frame, message } => {
                format!("[{done}/{frames}] frame {frame} failed: {}\n", escaped(message))
            }
            Event::Status { message } | Event::Stopped { message } => format!("{}\n", escaped(message)),
        }
    }

    fn json(&self, event: Event<'_>) -> String {
        #[derive(Serialize)]
        struct Line<'a> {
            #[serde(flatten)]
            event: Event<'a>,
            done: u64,
            percent: f64,
        }
        let line = Line { event, done: self.done, percent: self.per_cent() };
        // Strings and finite numbers cannot fail to serialise.
        let text = serde_json::to_string(&line).unwrap_or_default();
        format!("{}\n", ascii(&text))
    }

    /// Workers match these words at the start of a line and take the rest as it stands, so that no text of a user may
    /// start a line: `openjd_env` would set the environment of later tasks.
    fn open_jd(&self, event: Event<'_>) -> String {
        let progress = format!("openjd_progress: {:.1}\n", self.per_cent());
        let counted = |word: &str, frame: i64| {
            format!("openjd_status: frame {frame} {word} ({}/{})\n{progress}", self.done, self.frames)
        };
        match event {
            Event::Started { frames } => format!("openjd_status: {frames} frames to do\n{progress}"),
            Event::Drawn { frame } => counted("drawn", frame),
            Event::Kept { frame } => counted("kept", frame),
            Event::Failed { frame, message } => format!("openjd_fail: frame {frame}: {}\n{progress}", escaped(message)),
            Event::Status { message } => format!("openjd_status: {}\n", escaped(message)),
            Event::Stopped { message } => format!("openjd_fail: {}\n", escaped(message)),
        }
    }
}

/// Text of a user made safe to print: control characters, line breaks and marks that reorder or hide text are written as
/// escapes.
#[must_use]
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() || is_invisible(c) {
            safe.extend(c.escape_default());
        } else {
            safe.push(c);
        }
    }
    safe
}

/// Line and paragraph separators, directional marks, zero-width characters and the byte order mark.
fn is_invisible(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// JSON with everything beyond ASCII as escapes: the same for every locale of a reader, and no control sequences.
fn ascii(json: &str) -> String {
    let mut safe = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() && c != '\u{7f}' {
            safe.push(c);
        } else {
            let mut units = [0; 2];
            for unit in c.encode_utf16(&mut units) {
                // Writing to a String cannot fail.
                let _ = write!(safe, "\\u{unit:04x}");
            }
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Vec<u8>>>);

    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn told(mode: Mode, events: &[Event<'_>]) -> String {
        let shared = Shared::default();
        let mut progress = Progress::to(mode, Box::new(shared.clone()));
        events.iter().for_each(|&event| progress.tell(event));
        String::from_utf8(shared.0.lock().unwrap().clone()).unwrap()
    }

    const RUN: [Event<'static>; 4] = [
        Event::Started { frames: 3 },
        Event::Drawn { frame: -1 },
        Event::Kept { frame: 0 },
        Event::Failed { frame: 1, message: "no\nopenjd_env: A=B \u{1b}[2J" },
    ];

    #[test]
    fn open_jd_lines_are_exact_and_users_cannot_start_one() {
        assert_eq!(
            told(Mode::OpenJd, &RUN),
            "openjd_status: 3 frames to do\nopenjd_progress: 0.0\n\
             openjd_status: frame -1 drawn (1/3)\nopenjd_progress: 33.3\n\
             openjd_status: frame 0 kept (2/3)\nopenjd_progress: 66.7\n\
             openjd_fail: frame 1: no\\nopenjd_env: A=B \\u{1b}[2J\nopenjd_progress: 100.0\n"
        );
    }

    #[test]
    fn every_json_line_is_an_object_that_says_the_same() {
        let text = told(Mode::Json, &RUN);
        assert!(text.is_ascii() && !text.contains('\u{1b}'));
        let lines: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[1], serde_json::json!({"event": "drawn", "frame": -1, "done": 1, "percent": 100.0 / 3.0}));
        assert_eq!(lines[3]["message"], "no\nopenjd_env: A=B \u{1b}[2J");
        assert_eq!(lines[3]["percent"], 100.0);
    }

    #[test]
    fn plain_lines_count_and_none_is_silent() {
        assert!(told(Mode::Auto, &RUN).contains("[2/3] frame 0 kept\n"));
        assert_eq!(told(Mode::None, &RUN), "");
        assert!(told(Mode::OpenJd, &[Event::Started { frames: 0 }]).ends_with("openjd_progress: 100.0\n"));
    }

    #[test]
    fn a_closed_pipe_is_no_fault() {
        struct Closed;
        impl Write for Closed {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::BrokenPipe.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let mut progress = Progress::to(Mode::Json, Box::new(Closed));
        RUN.iter().for_each(|&event| progress.tell(event));
        assert!(progress.out.is_none());
    }

    #[test]
    fn escapes_leave_plain_text_alone() {
        assert_eq!(escaped("Ahorn \"rot\" – 楓"), "Ahorn \"rot\" – 楓");
        assert_eq!(escaped("a\u{202e}b\rc\u{9b}d"), "a\\u{202e}b\\rc\\u{9b}d");
    }
}
