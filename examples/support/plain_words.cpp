#include "plain_words.hpp"

#include <charconv>
#include <cstdio>
#include <exception>
#include <fstream>
#include <new>
#include <stdexcept>

int told() noexcept {
  const auto say = [](const char* words) {
    std::fflush(stdout);
    std::fprintf(stderr, "%s\n", words);
    return 1;
  };
  try {
    throw;
  } catch (const HelpAsked& help) {
    std::printf("%s\n", help.words.c_str());
    return 0;
  } catch (const std::bad_alloc&) {
    return say("there is not enough memory for something of this size");
  } catch (const std::length_error&) {  // a vector of more than can be counted
    return say("there is not enough memory for something of this size");
  } catch (const std::filesystem::filesystem_error& error) {
    return say((error.path1().string() + ": " + error.code().message()).c_str());
  } catch (const std::exception& error) {
    return say(error.what());
  } catch (...) {
    return say("something failed that has no name");
  }
}

int whole_number(std::string_view words, const std::string& what, int least, int most) {
  int value = 0;
  const auto [end, fault] = std::from_chars(words.data(), words.data() + words.size(), value);
  if (fault == std::errc() && end == words.data() + words.size() && value >= least &&
      value <= most) {
    return value;
  }
  throw std::runtime_error(what + " is \"" + std::string(words) + "\", not a whole number from " +
                           std::to_string(least) + " to " + std::to_string(most));
}

void require_writable(const std::filesystem::path& file) {
  const bool is_new = !std::filesystem::exists(file);
  const bool opens = std::ofstream(file, std::ios::app).is_open();
  if (!opens) throw std::runtime_error("cannot write " + file.string());
  if (is_new) std::filesystem::remove(file);
}

void make_folder(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder) && !std::filesystem::is_directory(folder)) {
    throw std::runtime_error(folder.string() + " is a file, not a folder for pictures");
  }
  if (folder.empty()) throw std::runtime_error("the folder for the pictures has no name");
  std::filesystem::create_directories(folder);
  const auto probe = folder / "written_to_see_if_it_can_be";
  const bool opens = std::ofstream(probe, std::ios::app).is_open();
  if (!opens) throw std::runtime_error("cannot write into the folder " + folder.string());
  std::filesystem::remove(probe);
}

std::string folder_argument(int count, char** arguments, const std::string& usage, int most) {
  for (int i = 1; i < count; ++i) {
    const std::string_view argument = arguments[i];
    if (argument != "--help" && argument != "-h") continue;
    throw HelpAsked{"usage: " + usage +
                    "\nChecks what it shows, and puts its pictures into FOLDER; without one into "
                    "out, which is made."};
  }
  if (count > most + 1 || (count > 1 && arguments[1][0] == '-')) {
    throw std::runtime_error("usage: " + usage);
  }
  const std::string folder = count > 1 ? arguments[1] : "out";
  make_folder(folder);
  return folder;
}
