//! `dotwork completions` and `dotwork man`: made from the same definitions as the command line.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::args::Cli;
use crate::report::{self, Failure};

/// Prints a completion script.
pub fn completions(shell: Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "dotwork", &mut script);
    report::print(&String::from_utf8_lossy(&script))
}

/// Prints the manual page of the program or of a subcommand.
pub fn page(command: Option<&str>) -> Result<(), Failure> {
    let mut root = Cli::command();
    // Fills in the options that subcommands share, and their full names.
    root.build();
    let chosen = match command {
        None => root,
        Some(name) => match root.find_subcommand(name) {
            Some(sub) => sub.clone(),
            None => return Err(Failure::Usage(format!("there is no command '{name}'; try dotwork --help"))),
        },
    };
    let mut page = Vec::new();
    let render = clap_mangen::Man::new(chosen)
        .source(concat!("dotwork ", env!("CARGO_PKG_VERSION")))
        .render(&mut page);
    render.map_err(|e| Failure::Run(format!("the manual page cannot be made: {e}")))?;
    report::print(&String::from_utf8_lossy(&page))
}
