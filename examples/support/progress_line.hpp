#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

/// One line that tells how far long work is, twice a second; where nobody looks, one line a minute.
class ProgressLine {
 public:
  ProgressLine(std::string things, double total) : things_(std::move(things)), total_(total) {}

  /// So many are done by this run, after `before` of others.
  void tell(double done, double before) {
    const auto now = std::chrono::steady_clock::now();
    const bool is_end = before + done >= total_;
    if (is_ended_ || done <= 0) return;
    if (!is_end &&
        now - last_ < (is_watched_ ? std::chrono::milliseconds(500) : std::chrono::minutes(1)))
      return;
    last_ = now;
    is_ended_ = is_end;
    const std::chrono::duration<double> passed = now - start_;
    const double rate = done / passed.count();
    std::fprintf(stderr, "%s%.0f of %.0f %s, %.3g a second, %s left   %s", is_watched_ ? "\r" : "",
                 before + done, total_, things_.c_str(), rate,
                 time((total_ - before - done) / rate).c_str(), is_watched_ && !is_end ? "" : "\n");
  }

  static std::string time(double seconds) {
    char text[64];
    const auto whole = static_cast<long>(seconds + 0.5);
    if (whole >= 3600) {
      std::snprintf(text, sizeof text, "%ld h %02ld min", whole / 3600, whole / 60 % 60);
    } else {
      std::snprintf(text, sizeof text, "%ld min %02ld s", whole / 60, whole % 60);
    }
    return text;
  }

 private:
  std::string things_;
  double total_;
  bool is_ended_ = false;
  bool is_watched_ = ::isatty(STDERR_FILENO) != 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_ = start_;
};
