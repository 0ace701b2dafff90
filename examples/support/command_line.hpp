#pragma once

#include <CLI/CLI.hpp>

#include "plain_words.hpp"

/// Reads the command line. False if nothing more is asked for than --help, which it prints; throws
/// what told() says of what it cannot read.
[[nodiscard]] inline bool read_command_line(CLI::App& app, int count, char** arguments) {
  try {
    app.parse(count, arguments);
    return true;
  } catch (const CLI::Success& asked) {
    app.exit(asked);
    return false;
  }
}
