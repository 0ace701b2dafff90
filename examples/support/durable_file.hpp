#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>

// Files that are either whole or not there, whenever the process is killed or the machine stops.

namespace durable_detail {

[[noreturn]] inline void fail(const std::string& doing, const std::string& path) {
  throw std::runtime_error("cannot " + doing + " " + path + ": " + std::strerror(errno) +
                           " (what was written before stays valid)");
}

class Descriptor {
 public:
  Descriptor(const std::string& path, int flags)
      : path_(path), file_(::open(path.c_str(), flags, 0666)) {
    if (file_ < 0) fail("open", path_);
  }
  ~Descriptor() { ::close(file_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void write(std::span<const std::byte> bytes) const {
    while (!bytes.empty()) {
      const ssize_t written = ::write(file_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail("write", path_);
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  }
  void sync() const {
    if (::fsync(file_) != 0) fail("bring to the disk", path_);
  }
  /// Whether no other process has locked it: where the file system has no locks, none has.
  [[nodiscard]] bool lock() const {
    struct flock whole {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    return ::fcntl(file_, F_SETLK, &whole) == 0 || (errno != EACCES && errno != EAGAIN);
  }

 private:
  std::string path_;
  int file_;
};

inline std::filesystem::path folder_of(const std::string& path) {
  return std::filesystem::absolute(path).parent_path();
}

/// A name beside the file that no other process of any machine uses at once.
inline std::string temporary_name(const std::string& path) {
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  return path + "." + host + "." + std::to_string(::getpid()) + ".tmp";
}

}  // namespace durable_detail

/// Lets a write beyond the system's limit on files fail with its reason, which else kills the
/// process without a word.
inline void outlive_file_limits() { std::signal(SIGXFSZ, SIG_IGN); }

/// Writes a file so that under its name there is, at any moment, all of it or what was there
/// before: under another name, brought to the disk, then renamed. Throws std::runtime_error with
/// the system's reason, such as a full disk, and leaves nothing behind then.
inline void write_durably(const std::string& path, std::span<const std::byte> bytes) {
  using namespace durable_detail;
  const std::string temporary = temporary_name(path);
  try {
    const Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    file.write(bytes);
    file.sync();
    if (std::rename(temporary.c_str(), path.c_str()) != 0) fail("rename to", path);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  Descriptor(folder_of(path).string(), O_RDONLY | O_DIRECTORY).sync();  // the name itself
}

/// Removes what processes that were killed in `write_durably` have left of a file.
inline void remove_half_written(const std::string& path) {
  const std::string begin = std::filesystem::path(path).filename().string() + ".";
  for (const auto& entry : std::filesystem::directory_iterator(durable_detail::folder_of(path))) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begin) && name.ends_with(".tmp")) std::filesystem::remove(entry.path());
  }
}

/// Keeps a file to one process of all machines, until it ends, however it ends. Throws
/// std::runtime_error where another has it.
class OneProcess {
 public:
  explicit OneProcess(const std::string& path) : file_(path, O_WRONLY | O_CREAT) {
    if (!file_.lock()) throw std::runtime_error("another process is writing here, see " + path);
  }

 private:
  durable_detail::Descriptor file_;
};
