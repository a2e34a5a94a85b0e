//! The command line of a command that cargo runs by an alias.

use clap::Parser;
use std::ffi::OsString;

/// The arguments of this process, the program first, as its parser is to see them.
///
/// The aliases end in `--`, so that `cargo study --list` is not taken for an option of cargo. Whoever writes a `--` of
/// his own, as in `cargo identify -- LENGTHS.csv --noise 0.06`, means the same and not that no option follows.
pub fn arguments() -> impl Iterator<Item = OsString> {
    without_first_dashes(std::env::args_os())
}

/// Reads the command line. What is wrong with it ends the process with code 1: 2 means something else to these commands.
pub fn parse<T: Parser>() -> T {
    T::try_parse_from(arguments()).unwrap_or_else(|error| {
        // asked for help, it is no error
        let code = i32::from(error.use_stderr());
        let _ = error.print();
        std::process::exit(code)
    })
}

fn without_first_dashes(arguments: impl Iterator<Item = OsString>) -> impl Iterator<Item = OsString> {
    arguments.enumerate().filter(|(index, argument)| !(*index == 1 && argument == "--")).map(|(_, argument)| argument)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_first_dashes_are_taken_off() {
        let seen = |line: &str| -> Vec<String> {
            let arguments = without_first_dashes(line.split(' ').map(OsString::from));
            arguments.map(|argument| argument.to_string_lossy().into_owned()).collect()
        };
        assert_eq!(seen("identify -- log.csv --zeros"), ["identify", "log.csv", "--zeros"]);
        assert_eq!(seen("identify log.csv --zeros"), ["identify", "log.csv", "--zeros"]);
        assert_eq!(seen("identify -- -- --odd.csv"), ["identify", "--", "--odd.csv"]);
        assert_eq!(seen("identify --zeros -- log.csv"), ["identify", "--zeros", "--", "log.csv"]);
    }
}
