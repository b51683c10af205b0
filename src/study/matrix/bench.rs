//! What cases of the matrix work with: a folder of scratch, and this program in a process of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A small scene, its stages made cheap.
pub const SMALL: &str = "species = \"red-maple\"\nseed = 1\n";
/// What makes it cheap, as assignments, so that a case may say otherwise.
const CHEAP: [&str; 10] = [
    "tree.age=3",
    "leaf.vertices=40",
    "deform.shapes=1",
    "colour.variants=1",
    "colour.size=16",
    "image.width=24",
    "image.height=16",
    "image.samples=1",
    "light.shadow_size=0",
    "time.day=5",
];

/// The folder and the program.
pub struct Bench {
    folder: PathBuf,
    program: Option<PathBuf>,
}

/// How a process ended.
#[derive(Clone, Debug, Default)]
pub struct Ended {
    /// The exit code; none after a signal.
    pub code: Option<i32>,
    /// What it said.
    pub told: String,
    /// The names of the files that it left in its output folder.
    pub files: Vec<String>,
}

impl Bench {
    /// A bench with its scratch below a folder.
    pub fn new(out: &Path, program: Option<PathBuf>) -> Self {
        let folder = out.join("matrix-scratch");
        let _ = fs::remove_dir_all(&folder);
        let _ = fs::create_dir_all(&folder);
        Self { folder: folder.canonicalize().unwrap_or(folder), program }
    }

    /// Removes the scratch.
    pub fn clean(&self) {
        let _ = fs::remove_dir_all(&self.folder);
    }

    /// Writes a file beside the scenes.
    pub fn put(&self, name: &str, bytes: &[u8]) {
        let _ = fs::write(self.folder.join(name), bytes);
    }

    /// Renders a scene in a process; `sets` stand above what makes it cheap.
    pub fn render(&self, name: &str, scene: &str, sets: &[&str]) -> Ended {
        self.put(&format!("{name}.toml"), scene.as_bytes());
        let out = self.folder.join(format!("{name}-out"));
        let report = self.folder.join(format!("{name}.json"));
        let mut arguments = vec!["render".to_owned(), format!("{name}.toml"), "--out".to_owned()];
        arguments.push(out.to_string_lossy().into_owned());
        arguments.extend(["--report".to_owned(), report.to_string_lossy().into_owned()]);
        arguments.extend(["--progress".to_owned(), "none".to_owned()]);
        let cheap = CHEAP.iter().filter(|set| {
            let key = set.split('=').next().unwrap_or("");
            let table = key.split('.').next().unwrap_or("");
            let own_table = scene.contains(&format!("[{table}]")) || scene.contains(&format!("{table} ="));
            !own_table && !sets.iter().any(|own| own.starts_with(&format!("{table}=")))
        });
        for set in cheap.chain(sets) {
            arguments.extend(["--set".to_owned(), (*set).to_owned()]);
        }
        let mut ended = self.run(&arguments);
        ended.files = names(&out);
        ended
    }

    /// The stages of the report that `render` left under a name.
    pub fn stages(&self, name: &str) -> Vec<String> {
        let text = fs::read(self.folder.join(format!("{name}.json"))).unwrap_or_default();
        let report: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
        let stages = report["stages"].as_array().cloned().unwrap_or_default();
        stages.iter().filter_map(|stage| stage["name"].as_str().map(str::to_owned)).collect()
    }

    /// Runs the program in the folder of scratch.
    pub fn run(&self, arguments: &[String]) -> Ended {
        let Some(program) = &self.program else {
            return Ended { told: "the program itself cannot be found".to_owned(), ..Ended::default() };
        };
        let output = Command::new(program).args(arguments).current_dir(&self.folder).stdin(Stdio::null()).output();
        match output {
            Ok(output) => Ended {
                code: output.status.code(),
                told: String::from_utf8_lossy(&output.stderr).into_owned(),
                files: Vec::new(),
            },
            Err(error) => Ended { told: error.to_string(), ..Ended::default() },
        }
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

impl Ended {
    /// Whether it was refused: an exit code of a refusal, one message that names all of `words`, and no file left.
    pub fn is_refusal(&self, words: &[&str]) -> super::Seen {
        let is_refused = self.code.is_some_and(|code| (1..70).contains(&code));
        let names_all = words.iter().all(|word| self.told.contains(word));
        let first = self.told.lines().find(|line| line.contains("error")).unwrap_or("no message");
        // The folder of scratch is another one on another machine.
        let first = first.find(": error").map_or(first, |at| &first[at + 2..]);
        let code = self.code.map_or_else(|| "a signal".to_owned(), |code| format!("exit {code}"));
        let files = if self.files.is_empty() { String::new() } else { format!("; left {}", self.files.join(", ")) };
        (is_refused && names_all && self.files.is_empty(), format!("{code}: {first}{files}"))
    }

    /// Whether it ended well and left a picture.
    pub fn is_drawn(&self) -> super::Seen {
        let drawn = self.files.iter().any(|name| name.ends_with(".png"));
        let first = self.told.lines().find(|line| line.contains("error")).unwrap_or("");
        let code = self.code.map_or_else(|| "a signal".to_owned(), |code| format!("exit {code}"));
        (self.code == Some(0) && drawn, if drawn { format!("{code}, drawn") } else { format!("{code} {first}") })
    }
}
