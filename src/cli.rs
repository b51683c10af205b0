//! The command line: what it takes and the plain values it becomes. Nothing is read, written or run here.

use crate::base::family::Family;
use crate::base::limits::{ALL_LIMITS, Limit, Limits};
use crate::run::frame_list::{FrameList, Shard};
use crate::run::progress::Mode;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Renders trees in season from a scene file: pictures and glTF, with nobody at the keyboard.
#[derive(Clone, Debug, Parser)]
#[command(name = "leafseason", version, about, propagate_version = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// Draws the frames of a scene.
    Render(Box<Render>),
    /// Checks a scene and shows what would be done, what is left out, and why; draws nothing.
    Plan(Plan),
    /// Traces a scan of a leaf: key points, mesh, veins, mask and texture, with no clicks.
    Leaf(Box<Leaf>),
    /// Tells how far two pictures are apart: largest difference, RMSE in linear light, FLIP.
    Compare(Compare),
    /// Checks that every frame of a folder is there and whole.
    Verify(Verify),
    /// Writes a commented starter scene.
    New(New),
    /// Measures error against work, stiff and extreme cases, and what is left out; writes tables, charts and a report. Exits with
    /// 1 if a line fails.
    Study(Box<Study>),
    /// Lists the built-in species.
    Species,
    /// Prints the JSON Schema of the scene file, for editors.
    Schema,
}

/// A scene with what the call changes in it.
#[derive(Args, Clone, Debug)]
pub struct SceneArguments {
    /// The scene file.
    pub scene: PathBuf,
    /// Overrides a key of the scene; may be repeated. Example: --set climate.temperature=12.5
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Looks here too for files that the scene names; may be repeated.
    #[arg(long, value_name = "DIR")]
    pub asset_root: Vec<PathBuf>,
    /// The limits in force.
    #[command(flatten)]
    pub limits: LimitArguments,
}

/// The operator's limits.
#[derive(Args, Clone, Debug)]
pub struct LimitArguments {
    /// Bounds the predicted memory, for example 512M or 2G.
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    pub memory_limit: Option<f64>,
    /// Raises or lowers a limit; may be repeated. Names: symbols, leaves, pixels, picture-pixels, vertices, steps, frames,
    /// memory.
    #[arg(long, value_name = "NAME=N")]
    pub limit: Vec<LimitArgument>,
}

/// `leafseason render`.
#[derive(Args, Clone, Debug)]
pub struct Render {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// The folder for the frames.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Only these frames: 3, 1-10, 1-10:2 or a comma list; a frame before the start as --frames=-3.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub frames: Option<FrameList>,
    /// Only the share of worker K of N, from 0/N: every N-th frame of the list.
    #[arg(long, value_name = "K/N", default_value_t)]
    pub shard: Shard,
    /// Threads to use [default: all cores]; fewer where the address space is bounded. Changes no byte of the output.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Writes a report as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// How progress is told.
    #[arg(long, value_name = "FORM", value_enum, default_value_t)]
    pub progress: Mode,
    /// Goes on after a frame has failed; the exit code is 7 then.
    #[arg(long)]
    pub keep_going: bool,
    /// Draws frames anew that are finished already.
    #[arg(long)]
    pub force: bool,
    /// Writes the state of every leaf in every frame as CSV.
    #[arg(long, value_name = "FILE.csv")]
    pub states: Option<PathBuf>,
}

/// `leafseason plan`.
#[derive(Args, Clone, Debug)]
pub struct Plan {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Prints the plan as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `leafseason leaf`.
#[derive(Args, Clone, Debug)]
pub struct Leaf {
    /// The scan: PNG or JPEG, one whole leaf on a plain background, or with an alpha channel.
    pub picture: PathBuf,
    /// The folder for leaf.toml, mask.png, texture.png and preview.png.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A hand-traced outline and veins, to tell how far the trace is from them.
    #[arg(long, value_name = "FILE.json")]
    pub truth: Option<PathBuf>,
    /// Overrides a key of the table `leaf`; may be repeated. Example: --set leaf.vertices=1000
    #[arg(long, value_name = "leaf.KEY=VALUE")]
    pub set: Vec<Override>,
    /// Writes a report as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Threads to use [default: all cores]. Changes no byte of the output.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// The limits in force.
    #[command(flatten)]
    pub limits: LimitArguments,
}

/// `leafseason compare`.
#[derive(Args, Clone, Debug)]
pub struct Compare {
    /// The one picture.
    pub a: PathBuf,
    /// The other picture.
    pub b: PathBuf,
    /// The largest difference of a channel, in 8-bit steps, that still exits with 0.
    #[arg(long, value_name = "X", default_value_t = 0)]
    pub max: u8,
    /// Prints the figures as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `leafseason verify`.
#[derive(Args, Clone, Debug)]
pub struct Verify {
    /// The folder of frames and manifests.
    pub folder: PathBuf,
}

/// `leafseason study`.
#[derive(Args, Clone, Debug)]
pub struct Study {
    /// A scene whose own leaf, chain, camera and species are studied; built-in problems and all species without one.
    pub scene: Option<PathBuf>,
    /// Overrides a key of the scene; may be repeated.
    #[arg(long, value_name = "KEY=VALUE", requires = "scene")]
    pub set: Vec<Override>,
    /// The folder for tables, charts and report.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What is studied.
    #[arg(long, value_enum, default_value_t)]
    pub family: Family,
    /// Leaves the costliest rows out: a minute in place of twenty.
    #[arg(long)]
    pub quick: bool,
    /// Does the work of one row and nothing else, for its instructions to be counted.
    #[arg(long, value_name = "NAME", hide = true)]
    pub row: Option<String>,
}

/// `leafseason new`.
#[derive(Args, Clone, Debug)]
pub struct New {
    /// The folder to write into.
    pub folder: PathBuf,
    /// The species of the scene.
    #[arg(long, value_name = "NAME", default_value = "red-maple")]
    pub species: String,
}

impl LimitArguments {
    /// The limits in force: the defaults, memory bounded by what is `available` (bytes), changed by `--limit` in the order
    /// given, then by `--memory-limit`.
    #[must_use]
    pub fn get(&self, available: f64) -> Limits {
        let mut limits = Limits::default();
        limits.set(Limit::Memory, limits.get(Limit::Memory).min(available));
        self.limit.iter().for_each(|argument| limits.set(argument.limit, argument.value));
        if let Some(bytes) = self.memory_limit {
            limits.set(Limit::Memory, bytes);
        }
        limits
    }
}

/// One `--set KEY=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// Dotted path of the key.
    pub key: String,
    /// The value as written: TOML, or a bare word for a string.
    pub value: String,
}

impl std::str::FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => {
                Ok(Self { key: key.trim().to_owned(), value: value.trim().to_owned() })
            }
            _ => Err("write KEY=VALUE, for example climate.humidity=0.4".to_owned()),
        }
    }
}

impl Override {
    /// The argument as one text, as messages about it show it.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{}={}", self.key, self.value)
    }
}

/// One `--limit NAME=N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitArgument {
    /// Which limit.
    pub limit: Limit,
    /// Its value, at least 0; for memory in bytes.
    pub value: f64,
}

impl std::str::FromStr for LimitArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = || ALL_LIMITS.map(Limit::name).join(", ");
        let (name, value) = text.split_once('=').ok_or_else(|| format!("write NAME=N; the names are {}", names()))?;
        let limit = ALL_LIMITS.into_iter().find(|limit| limit.name() == name);
        let limit = limit.ok_or_else(|| format!("{name:?} is not a limit; the names are {}", names()))?;
        let value = if limit == Limit::Memory { parse_size(value)? } else { parse_count(value)? };
        Ok(Self { limit, value })
    }
}

/// A whole number, also written 1e6.
fn parse_count(text: &str) -> Result<f64, String> {
    let plain = text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'e' | b'E' | b'+'));
    let number = text.parse::<f64>().ok().filter(|n| plain && n.is_finite() && n.fract() == 0.0);
    number.ok_or_else(|| format!("{text:?} is not a whole number such as 500000 or 1e6"))
}

/// Bytes with an optional unit: K, M, G, T (powers of 1000) or Ki, Mi, Gi, Ti (powers of 1024), a B may follow.
fn parse_size(text: &str) -> Result<f64, String> {
    let wrong = || format!("{text:?} is not a size such as 512M, 2G or 1.5GiB");
    let at = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let (number, unit) = text.split_at(at);
    let number = number.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(wrong)?;
    let factor = match unit.strip_suffix('B').unwrap_or(unit) {
        "" => 1.0,
        "K" | "k" => 1e3,
        "M" => 1e6,
        "G" => 1e9,
        "T" => 1e12,
        "Ki" => 1024.0,
        "Mi" => 1_048_576.0,
        "Gi" => 1_073_741_824.0,
        "Ti" => 1_099_511_627_776.0,
        _ => return Err(wrong()),
    };
    Ok(number * factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn parsed(arguments: &[&str]) -> Result<Command, clap::Error> {
        Cli::try_parse_from([&["leafseason"], arguments].concat()).map(|cli| cli.command)
    }

    fn render(arguments: &[&str]) -> Render {
        match parsed(&[&["render", "s.toml"], arguments].concat()).unwrap() {
            Command::Render(render) => *render,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn defaults_are_those_of_the_contract() {
        let found = render(&[]);
        assert_eq!((found.out.to_str(), found.shard, found.progress), (Some("out"), Shard::default(), Mode::Auto));
        assert!(found.frames.is_none() && found.threads.is_none() && !found.keep_going && !found.force);
        assert_eq!(found.scene.limits.get(f64::INFINITY), Limits::default());
    }

    #[test]
    fn every_flag_of_render_is_read() {
        let found = render(&[
            "--out",
            "o",
            "--frames",
            "-3--1,4",
            "--shard",
            "1/4",
            "--set",
            "a.b=1",
            "--set",
            "c = [1, 2]",
            "--threads",
            "7",
            "--report",
            "r.json",
            "--progress",
            "openjd",
            "--keep-going",
            "--force",
            "--asset-root",
            "x",
            "--asset-root",
            "y",
            "--states",
            "s.csv",
            "--memory-limit",
            "2G",
            "--limit",
            "leaves=1e3",
            "--limit",
            "symbols=5",
        ]);
        assert_eq!(found.frames, Some("-3--1,4".parse().unwrap()));
        assert_eq!((found.shard, found.threads), (Shard { index: 1, count: 4 }, Some(7)));
        let set: Vec<String> = found.scene.set.iter().map(Override::text).collect();
        assert_eq!(set, ["a.b=1", "c=[1, 2]"]);
        assert_eq!((found.progress, found.scene.asset_root.len()), (Mode::OpenJd, 2));
        assert!(found.keep_going && found.force && found.report.is_some() && found.states.is_some());
        let limits = found.scene.limits.get(f64::INFINITY);
        let values = [Limit::Leaves, Limit::Symbols, Limit::Memory, Limit::Frames].map(|limit| limits.get(limit));
        assert_eq!(values, [1000.0, 5.0, 2e9, Limits::default().get(Limit::Frames)]);
    }

    #[test]
    fn a_negative_frame_may_stand_behind_a_blank_or_an_equals_sign() {
        let wanted = Some("-3".parse().unwrap());
        assert_eq!(render(&["--frames", "-3"]).frames, wanted);
        assert_eq!(render(&["--frames=-3"]).frames, wanted);
    }

    #[test]
    fn wrong_usage_exits_with_2() {
        let table: &[&[&str]] = &[
            &[],
            &["paint"],
            &["render"],
            &["render", "s", "--frames", "5-1"],
            &["render", "s", "--shard", "4/4"],
            &["render", "s", "--threads", "0"],
            &["render", "s", "--set", "novalue"],
            &["render", "s", "--limit", "dragons=3"],
            &["render", "s", "--limit", "leaves=-3"],
            &["render", "s", "--limit", "leaves=nan"],
            &["render", "s", "--memory-limit", "many"],
            &["render", "s", "--progress", "dots"],
            &["compare", "a.png"],
            &["compare", "a", "b", "--max", "256"],
        ];
        for arguments in table {
            assert_eq!(parsed(arguments).unwrap_err().exit_code(), 2, "{arguments:?}");
        }
        assert_eq!(parsed(&["--help"]).unwrap_err().exit_code(), 0);
    }

    #[test]
    fn sizes_are_read() {
        let table =
            [("0", 0.0), ("512M", 512e6), ("2G", 2e9), ("2GB", 2e9), ("1.5KiB", 1536.0), ("1Ti", 1_099_511_627_776.0)];
        for (text, bytes) in table {
            assert_eq!(parse_size(text), Ok(bytes), "{text}");
        }
        for text in ["", "M", "-1M", "1X", "1 M", "1e3", "inf", "1.2.3"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_flag_that_a_refusal_names_is_understood() {
        for limit in ALL_LIMITS {
            let flag = limit.flag(123_456_789.0);
            let arguments: Vec<&str> = flag.split(' ').collect();
            assert!(render(&arguments).scene.limits.get(f64::INFINITY).get(limit) >= 123_456_789.0, "{flag}");
        }
    }
}
