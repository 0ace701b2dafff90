#pragma once

#include <string>

#include "told.hpp"

// What all lessons share: where the picture goes, and what must hold of the result.

class Lesson {
 public:
  /// The picture is `name`.png in the folder that the first argument names, out/ without one;
  /// `usage` tells of up to `most` arguments.
  Lesson(int count, char** arguments, const std::string& name,
         const std::string& usage = "[FOLDER]", int most = 1);

  [[nodiscard]] const std::string& picture() const { return picture_; }

  /// Says whether what the sentence claims is true of the result.
  void expect(bool holds, const std::string& claim);

  /// What main returns: 0 if all that was expected holds.
  [[nodiscard]] int result() const;

 private:
  std::string picture_;
  bool all_hold_ = true;
};
