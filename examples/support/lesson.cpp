#include "lesson.hpp"

#include <cstdio>

#include "plain_words.hpp"

Lesson::Lesson(int count, char** arguments, const std::string& name, const std::string& usage,
               int most) {
  picture_ = folder_argument(count, arguments, name + " " + usage, most) + "/" + name + ".png";
  require_writable(picture_);
}

void Lesson::expect(bool holds, const std::string& claim) {
  std::printf("%s %s\n", holds ? "yes:  " : "WRONG:", claim.c_str());
  all_hold_ = all_hold_ && holds;
}

int Lesson::result() const {
  std::printf("Picture: %s\n", picture_.c_str());
  return all_hold_ ? 0 : 1;
}
