#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

// What all lessons share: where the picture goes, and what must hold of the result.

class Lesson {
 public:
  /// The picture is `name`.png in the folder that the first argument names, out/ without one.
  Lesson(int count, char** arguments, const std::string& name) {
    const std::filesystem::path folder = count > 1 ? arguments[1] : "out";
    std::filesystem::create_directories(folder);
    picture_ = (folder / (name + ".png")).string();
  }

  [[nodiscard]] const std::string& picture() const { return picture_; }

  /// Says whether what the sentence claims is true of the result.
  void expect(bool holds, const std::string& claim) {
    std::printf("%s %s\n", holds ? "yes:  " : "WRONG:", claim.c_str());
    all_hold_ = all_hold_ && holds;
  }

  /// What main returns: 0 if all that was expected holds.
  [[nodiscard]] int result() const {
    std::printf("Picture: %s\n", picture_.c_str());
    return all_hold_ ? 0 : 1;
  }

 private:
  std::string picture_;
  bool all_hold_ = true;
};
