//! The `leafseason` command: reads arguments, calls the library, prints and exits.

use clap::Parser;
use leafseason::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use leafseason::base::limits::{Limit, Limits};
use leafseason::base::message;
use leafseason::cli::{Cli, Command, Compare, Leaf, New, Plan, Render, SceneArguments, Study, Verify};
use leafseason::report::Report;
use leafseason::run::memory;
use leafseason::run::progress::{Event, Progress};
use leafseason::run::signals::Signals;
use leafseason::run::{self, Options};
use leafseason::scene::{self, Asset, Scene};
use leafseason::study::desk::{Request, Subject};
use leafseason::{compare, species, study};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

fn main() -> ExitCode {
    std::panic::set_hook(Box::new(tell_of_panic));
    let outcome = std::panic::catch_unwind(|| {
        let cli = match Cli::try_parse() {
            Ok(cli) => cli,
            Err(answer) => return tell_of_arguments(&answer),
        };
        command(cli.command).unwrap_or_else(|faults| {
            complain(&message::render_all(&faults.0));
            faults.exit_code()
        })
    });
    ExitCode::from(outcome.unwrap_or_else(|_| Fault::Bug.exit_code()))
}

/// One line for the first panic; others are of threads that fell with it.
fn tell_of_panic(panic: &std::panic::PanicHookInfo<'_>) {
    static TOLD: AtomicBool = AtomicBool::new(false);
    if TOLD.swap(true, Ordering::Relaxed) {
        return;
    }
    let what = message::shown(panic.payload_as_str().unwrap_or("unknown"), 500);
    let place = panic.location().map_or_else(String::new, |at| format!(" at {}:{}", at.file(), at.line()));
    let version = env!("CARGO_PKG_VERSION");
    complain(&format!(
        "error: this is a bug of leafseason {version}{place}: {what}; please report it with the scene\n"
    ));
}

/// Prints help, or what is wrong with the arguments, and returns the exit code. The parser quotes arguments as they are,
/// control characters and all; it is asked again with arguments that are safe to print.
fn tell_of_arguments(answer: &clap::Error) -> u8 {
    if answer.exit_code() != 0 {
        let safe = std::env::args_os().map(|argument| message::shown(&argument.to_string_lossy(), 1000));
        match Cli::try_parse_from(safe) {
            Err(answer) if answer.exit_code() != 0 => complain(&answer.render().to_string()),
            _ => complain("error: an argument holds control characters or is not UTF-8\n"),
        }
        return Fault::Usage.exit_code();
    }
    print(&answer.render().to_string()).unwrap_or_else(|faults| faults.exit_code())
}

fn command(command: Command) -> Result<u8, Diagnostics> {
    match command {
        Command::Render(arguments) => render(&arguments),
        Command::Plan(arguments) => plan(&arguments),
        Command::Leaf(arguments) => trace_leaf(&arguments),
        Command::Compare(arguments) => compare_pictures(&arguments),
        Command::Verify(arguments) => verify(&arguments),
        Command::New(arguments) => new_scene(&arguments),
        Command::Study(arguments) => study(&arguments),
        Command::Species => {
            let lines: String = species::list().iter().map(|(name, line)| format!("{name:<16} {line}\n")).collect();
            print(&lines)
        }
        Command::Schema => print(&json(&scene::json_schema())?),
    }
}

fn render(arguments: &Render) -> Result<u8, Diagnostics> {
    let signals = Signals::listen()
        .map_err(|error| Diagnostic::error(Fault::Bug, format!("signals cannot be heard: {error}"), ""))?;
    use_threads(arguments.threads)?;
    let (scene, limits) = read(&arguments.scene)?;
    if let Some(path) = &arguments.report {
        run::destination::file(path)?;
    }
    let options = Options {
        out: arguments.out.clone(),
        frames: arguments.frames.clone(),
        shard: Some(arguments.shard),
        keep_going: arguments.keep_going,
        force: arguments.force,
        states: arguments.states.clone(),
        limits,
        leave_out: true,
    };
    let mut progress = Progress::new(arguments.progress);
    let outcome = run::render(&scene, &options, &mut progress, &signals).inspect_err(|faults| {
        progress.tell(Event::Stopped { message: &faults.to_string() });
    })?;
    tell(&outcome.report, arguments.report.as_deref())?;
    if let Some(code) = signals.exit_code().filter(|_| outcome.interrupted) {
        return Ok(code);
    }
    for (frame, faults) in &outcome.failed {
        complain(&format!("frame {frame} failed:\n{}", message::render_all(&faults.0)));
    }
    Ok(if outcome.failed.is_empty() { 0 } else { 7 })
}

fn plan(arguments: &Plan) -> Result<u8, Diagnostics> {
    use_threads(None)?;
    let (scene, limits) = read(&arguments.scene)?;
    let plan = run::plan(&scene, &Options { limits, ..Options::default() })?;
    print(&if arguments.json { json(&plan)? } else { plan.text() })
}

fn trace_leaf(arguments: &Leaf) -> Result<u8, Diagnostics> {
    use_threads(arguments.threads)?;
    if let Some(path) = &arguments.report {
        run::destination::file(path)?;
    }
    let limits = arguments.limits.get(memory::available(rayon::current_num_threads()));
    let sets: Vec<String> = arguments.set.iter().map(|set| set.text()).collect();
    let settings = scene::leaf_settings(&sets, &limits)?;
    let (picture, out, truth) = (arguments.picture.clone(), arguments.out.clone(), arguments.truth.clone());
    let report = run::leaf::trace(&run::leaf::Job { picture, out, truth, settings, limits })?;
    tell(&report, arguments.report.as_deref())?;
    Ok(0)
}

/// Tells what there is to know of a run: its notes, and the report as a file or as a short table.
fn tell(report: &Report, path: Option<&Path>) -> Result<(), Diagnostics> {
    let notes: Vec<Diagnostic> = report.notes.iter().map(|note| Diagnostic::warning(note, "")).collect();
    complain(&message::render_all(&notes));
    match path {
        Some(path) => run::write_report(path, report),
        None => {
            complain(&report.table());
            Ok(())
        }
    }
}

fn compare_pictures(arguments: &Compare) -> Result<u8, Diagnostics> {
    use_threads(None)?;
    let limits = Limits::default();
    let picture = |path: &Path| {
        let asset = Asset::outside(path);
        // no flag of this command raises a limit
        let help = |fault: Diagnostic| match fault.fault {
            Fault::Limit => Diagnostic { help: "compare parts of the pictures".to_owned(), ..fault },
            _ => fault,
        };
        scene::read_picture(&asset, &limits).map_err(help)
    };
    let (a, b) = (picture(&arguments.a)?, picture(&arguments.b)?);
    run::comparison::allow(&a)?;
    let comparison = match compare::compare(&a, &b) {
        Ok(comparison) => comparison,
        Err(sizes) => {
            if arguments.json {
                print(&json(&serde_json::json!({ "error": sizes.to_string() }))?)?;
            } else {
                complain(&format!("{sizes}\n"));
            }
            return Ok(1);
        }
    };
    if arguments.json {
        print(&json(&comparison)?)?;
    } else {
        let compare::Comparison { max_difference, differing_pixels, rmse, flip } = comparison;
        print(&format!(
            "max difference {max_difference}, differing pixels {differing_pixels}, RMSE {rmse:.3e} (linear light), FLIP {flip:.3e}\n"
        ))?;
    }
    Ok(u8::from(comparison.max_difference > arguments.max))
}

fn verify(arguments: &Verify) -> Result<u8, Diagnostics> {
    let folder = &arguments.folder;
    let found = run::verify::verify(folder).map_err(|error| {
        let what = format!("cannot read the folder {}: {error}", message::shown(&folder.to_string_lossy(), 200));
        Diagnostic::error(Fault::Usage, what, "name the folder that `render` wrote to")
    })?;
    // names of files are not ours and may hold anything
    let line = |fault: &run::verify::Fault| message::shown(&fault.to_string(), 1000) + "\n";
    let faults: String = found.faults.iter().map(line).collect();
    print(&format!("{faults}{} frame(s), {} file(s), {} fault(s)\n", found.frames, found.files, found.faults.len()))?;
    Ok(u8::from(!found.faults.is_empty()))
}

fn new_scene(arguments: &New) -> Result<u8, Diagnostics> {
    let folder = &arguments.folder;
    if species::text(&arguments.species).is_none() {
        let known: Vec<&str> = species::names().collect();
        let what = format!("there is no built-in species `{}`", message::shown(&arguments.species, 60));
        return Err(Diagnostic::error(Fault::Usage, what, format!("take one of: {}", known.join(", "))).into());
    }
    let file = folder.join("scene.toml");
    let failed = |error: &dyn std::fmt::Display| {
        let what = format!("cannot write {}: {error}", message::shown(&file.to_string_lossy(), 200));
        Diagnostic::error(Fault::Output, what, "name another folder")
    };
    if file.exists() {
        return Err(failed(&"it exists already").into());
    }
    std::fs::create_dir_all(folder).map_err(|error| failed(&error))?;
    let text = scene::starter(&arguments.species);
    run::files::write(&file, text.as_bytes()).map_err(|error| failed(&error))?;
    print(&format!("{}\n", message::shown(&file.to_string_lossy(), 1000)))
}

fn study(arguments: &Study) -> Result<u8, Diagnostics> {
    use_threads(None)?;
    if let Some(row) = &arguments.row {
        let is_known = study::do_row(row);
        return if is_known { Ok(0) } else { Err(Diagnostic::error(Fault::Usage, "there is no such row", "").into()) };
    }
    let mut limits = Limits::default();
    let sets: Vec<String> = arguments.set.iter().map(|set| set.text()).collect();
    let read = |path: &PathBuf| {
        let scene = scene::read(path, &sets, &[], &Limits::default())?.0;
        Ok::<_, Diagnostics>(Subject { scene, path: path.clone(), sets: sets.clone() })
    };
    let subject = arguments.scene.as_ref().map(read).transpose()?;
    limits.set(Limit::Memory, limits.get(Limit::Memory).min(memory::available(rayon::current_num_threads())));
    let request = Request {
        out: arguments.out.clone(),
        family: arguments.family,
        quick: arguments.quick,
        subject,
        program: std::env::current_exe().ok(),
        limits,
    };
    let passes = study::run(&request, &mut |row| complain(&format!("{row}\n")))?;
    let report = arguments.out.join("report.md");
    print(&format!("{}\n", message::shown(&report.to_string_lossy(), 1000)))?;
    Ok(u8::from(!passes))
}

/// Reads a scene with its arguments and prints its warnings.
fn read(arguments: &SceneArguments) -> Result<(Scene, Limits), Diagnostics> {
    let limits = arguments.limits.get(memory::available(rayon::current_num_threads()));
    let sets: Vec<String> = arguments.set.iter().map(|set| set.text()).collect();
    let (scene, warnings) = scene::read(&arguments.scene, &sets, &arguments.asset_root, &limits)?;
    complain(&message::render_all(&warnings));
    Ok((scene, limits))
}

/// Starts the threads: as many as asked for, else one for each core; fewer where the address space is small.
fn use_threads(threads: Option<u16>) -> Result<(), Diagnostics> {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let count = memory::threads(threads.map_or_else(cores, usize::from));
    rayon::ThreadPoolBuilder::new().num_threads(count).build_global().map_err(|error| {
        let what = format!("threads cannot be started: {error}");
        Diagnostic::error(Fault::Limit, what, "ask for fewer with --threads, or let the system allow more").into()
    })
}

fn json(value: &impl serde::Serialize) -> Result<String, Diagnostics> {
    let text = serde_json::to_string_pretty(value);
    text.map(|text| text + "\n")
        .map_err(|error| Diagnostic::error(Fault::Bug, format!("no JSON can be made of it: {error}"), "").into())
}

/// Prints what was asked for; a reader that has gone away is no fault, a full disk is.
fn print(text: &str) -> Result<u8, Diagnostics> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            let what = format!("cannot write to the standard output: {error}");
            Err(Diagnostic::error(Fault::Output, what, "free space, or write elsewhere").into())
        }
        _ => Ok(0),
    }
}

/// Prints what the person should know.
fn complain(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}
