#pragma once

#include <cstdio>
#include <string>

#include "plain_words.hpp"

// What all lessons share: where the picture goes, and what must hold of the result.

class Lesson {
 public:
  /// The picture is `name`.png in the folder that the first argument names, out/ without one;
  /// `usage` tells of up to `most` arguments.
  Lesson(int count, char** arguments, const std::string& name,
         const std::string& usage = "[FOLDER]", int most = 1) {
    picture_ = folder_argument(count, arguments, name + " " + usage, most) + "/" + name + ".png";
    require_writable(picture_);
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
