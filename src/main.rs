//! The `overfall` command: arguments in, exit status out. What it does is in [`cli`].

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
