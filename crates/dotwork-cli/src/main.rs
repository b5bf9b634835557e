//! The `dotwork` command.
//!
//! [`args`] is what was typed, [`options`] what it means for a scene; each subcommand has a file of its own; [`report`]
//! says what happened and decides the exit code: 0 done, 1 the run failed, 2 the command was not understood.

mod animate;
mod args;
mod bake;
mod bench;
mod demo;
mod ffmpeg;
mod info;
mod manual;
mod options;
mod output;
mod render;
mod report;
mod scene;
mod styles;
mod words;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Cli, Command};
use crate::report::{Failure, Report};

fn main() -> ExitCode {
    output::survive_size_limits();
    let result = match Cli::try_parse() {
        Ok(cli) => run(cli),
        Err(e) if e.use_stderr() => Err(Failure::from(e)),
        // Help and version were asked for.
        Err(e) => report::print(&e.render().to_string()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.exit(),
    }
}

fn run(cli: Cli) -> Result<(), Failure> {
    if let Some(threads) = cli.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build_global().map_err(|e| Failure::Run(format!("cannot start {threads} threads: {e}")))?;
    }
    let mut report = Report::new(cli.quiet);
    match cli.command {
        Command::Render(args) => render::run(&args, &mut report),
        Command::Animate(args) => animate::run(&args, &mut report),
        Command::Bake(args) => bake::run(&args, &mut report),
        Command::Info(args) => info::run(&args, &mut report),
        Command::Styles(args) => styles::run(&args),
        Command::Demo(args) => demo::run(&args),
        Command::Bench(args) => bench::run(&args, &mut report),
        Command::Completions { shell } => manual::completions(shell),
        Command::Man { command } => manual::page(command.as_deref()),
    }
}
