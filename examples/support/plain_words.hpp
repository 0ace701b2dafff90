#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "told.hpp"

// What a program says, in one line, of what it cannot do.

/// A whole number that a user wrote. Throws std::runtime_error where it is none from least to most.
[[nodiscard]] int whole_number(std::string_view words, const std::string& what, int least,
                               int most);

/// Throws std::runtime_error if the file cannot be written; leaves what is there as it is.
void require_writable(const std::filesystem::path& file);

/// Makes a folder. Throws std::runtime_error if no file can be written into it.
void make_folder(const std::filesystem::path& folder);

/// The folder that a program's first argument names, out without one, made. Throws HelpAsked for
/// --help or -h, and std::runtime_error, which says the usage, for another option or more than
/// `most` arguments.
[[nodiscard]] std::string folder_argument(int count, char** arguments, const std::string& usage,
                                          int most = 1);
