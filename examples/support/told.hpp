#pragma once

#include <string>

/// Thrown where somebody asked for help, which is no failure.
struct HelpAsked {
  std::string words;
};

/// What main returns where it fails: says on standard error what is being caught, and on standard
/// output the help that was asked for. To be called as
/// `int main() try { ... } catch (...) { return told(); }`.
[[nodiscard]] int told() noexcept;
