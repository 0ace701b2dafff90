#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "fuzz/bytes.hpp"
#include "gelight/core/error.hpp"
#include "gelight/io/image.hpp"
#include "gelight/io/npy.hpp"

// Files of any content: read, or refused by name.

using namespace gelight;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path =
      (std::filesystem::exists("/dev/shm") ? std::filesystem::path("/dev/shm")
                                           : std::filesystem::temp_directory_path()) /
      ("gelight_fuzz_" + std::to_string(getpid()));
  if (size < 1) return 0;
  {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
  }
  try {
    switch (data[0] % 5) {
      case 0:
        (void)read_npy<float>(path);
        break;
      case 1:
        (void)read_npy<double>(path);
        break;
      case 2:
        (void)read_npy<std::uint8_t>(path);
        break;
      case 3:
        (void)read_npy<Vec3<float>>(path);
        break;
      default:
        (void)read_png(path);
        break;
    }
  } catch (const InvalidInput&) {
    // A refusal, by name.
  }
  std::remove(path.c_str());
  return 0;
}
