#pragma once

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

// What the programs need of HDF5. Its library bears one thread at a time: `lock()`.

namespace hdf5 {

/// Errors are thrown, not printed: each thread has to ask for that.
inline void be_quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

[[nodiscard]] inline std::unique_lock<std::mutex> lock() {
  static std::mutex mutex;
  std::unique_lock guard(mutex);
  be_quiet();
  return guard;
}

/// What HDF5 returned, unless it failed.
template <std::signed_integral Result>
Result checked(Result result, const std::string& doing) {
  if (result < 0) throw std::runtime_error("HDF5 cannot " + doing);
  return result;
}

/// An open thing of HDF5's.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& doing)
      : id_(checked(id, doing)), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// The numbers that columns hold.
enum class Number { u8, i32, u64, f32, f64 };

template <class T>
[[nodiscard]] constexpr Number number_of() {
  if constexpr (std::same_as<T, std::uint8_t>) return Number::u8;
  if constexpr (std::same_as<T, std::int32_t>) return Number::i32;
  if constexpr (std::same_as<T, std::uint64_t>) return Number::u64;
  if constexpr (std::same_as<T, float>) return Number::f32;
  if constexpr (std::same_as<T, double>) return Number::f64;
}

[[nodiscard]] inline hid_t type_of(Number number) {
  switch (number) {
    case Number::u8:
      return H5T_NATIVE_UINT8;
    case Number::i32:
      return H5T_NATIVE_INT32;
    case Number::u64:
      return H5T_NATIVE_UINT64;
    case Number::f32:
      return H5T_NATIVE_FLOAT;
    default:
      return H5T_NATIVE_DOUBLE;
  }
}

[[nodiscard]] inline std::size_t bytes_of(Number number) {
  return number == Number::u8 ? 1 : number == Number::i32 || number == Number::f32 ? 4 : 8;
}

[[nodiscard]] inline Handle space(const std::vector<hsize_t>& shape) {
  return {H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose,
          "make a space"};
}

/// Properties of a dataset that is the same whenever it is written.
[[nodiscard]] inline Handle dataset_properties() {
  Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "make properties");
  checked(H5Pset_obj_track_times(properties, false), "leave the time out");
  return properties;
}

/// Lets what is missing be read as numbers of which all bits are set: NaN, -1, 255 and so on.
inline void fill_with_ones(hid_t properties, Number number) {
  const std::uint64_t ones = ~std::uint64_t{0};
  checked(H5Pset_fill_value(properties, type_of(number), &ones), "set what is read of nothing");
}

[[nodiscard]] inline Handle new_dataset(hid_t file, const std::string& name, Number number,
                                        const std::vector<hsize_t>& shape, hid_t properties) {
  return {H5Dcreate2(file, name.c_str(), type_of(number), space(shape), H5P_DEFAULT, properties,
                     H5P_DEFAULT),
          H5Dclose, "make the dataset " + name};
}

/// The checksum of a chunk as HDF5's filter fletcher32 has it: of words of two bytes, the first of
/// which weighs more.
[[nodiscard]] inline std::uint32_t fletcher32(std::span<const std::byte> bytes) {
  constexpr std::size_t words_at_once = 360;  // of which the sums do not overflow
  std::uint32_t first = 0, second = 0;
  const auto fold = [](std::uint32_t sum) { return (sum & 0xFFFF) + (sum >> 16); };
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = std::min(bytes.size(), at + 2 * words_at_once);
    for (; at < end; at += 2) {
      const auto low = at + 1 < end ? std::to_integer<std::uint32_t>(bytes[at + 1]) : 0;
      first += (std::to_integer<std::uint32_t>(bytes[at]) << 8) | low;
      second += first;
    }
    first = fold(first);
    second = fold(second);
  }
  return (fold(second) << 16) | fold(first);
}

/// The four bytes that HDF5's filter fletcher32 puts after a chunk, the lowest first.
[[nodiscard]] inline std::array<std::byte, 4> checksum(std::span<const std::byte> chunk) {
  const std::uint32_t sum = fletcher32(chunk);
  return {std::byte(sum & 0xFF), std::byte((sum >> 8) & 0xFF), std::byte((sum >> 16) & 0xFF),
          std::byte(sum >> 24)};
}

/// A text of a fixed length, which HDF5 keeps where checksums are; of one of another length that is
/// damaged it dies.
[[nodiscard]] inline Handle fixed_text(std::size_t length) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "make a text");
  checked(H5Tset_size(type, length), "make a text");
  return type;
}

/// A file in memory, to be written in one piece: HDF5 itself does not tell why a disk refuses.
class MemoryFile {
 public:
  MemoryFile()
      : file_(H5Fcreate(new_name().c_str(), H5F_ACC_TRUNC, creation(), access()), H5Fclose,
              "make a file in memory") {
    // Its tables shall have checksums, for which the format is to be that of 1.10. But such a file
    // is marked as open while it is, with a checksum of that; one that begins as of 1.8 is not.
    checked(H5Fset_libver_bounds(file_, H5F_LIBVER_V110, H5F_LIBVER_V110), "choose a format");
  }
  operator hid_t() const { return file_; }

  void attribute(const std::string& name, const std::string& text) const {
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "make a text");
    checked(H5Tset_size(type, H5T_VARIABLE), "make a text");
    checked(H5Tset_cset(type, H5T_CSET_UTF8), "make a text");
    const Handle one(H5Screate(H5S_SCALAR), H5Sclose, "make a space");
    const Handle attribute(H5Acreate2(file_, name.c_str(), type, one, H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose, "make the attribute " + name);
    const char* words = text.c_str();
    checked(H5Awrite(attribute, type, static_cast<const void*>(&words)), "write " + name);
  }

  /// Says which part of others this is.
  void mark_as_part(const std::string& name) const {
    const Handle type = fixed_text(name.size());
    const Handle one(H5Screate(H5S_SCALAR), H5Sclose, "make a space");
    const Handle mark(H5Acreate2(file_, "part", type, one, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                      "mark " + name);
    checked(H5Awrite(mark, type, name.data()), "mark " + name);
  }

  /// All of it, until something more is put into it.
  [[nodiscard]] std::span<const std::byte> bytes() const {
    checked(H5Fflush(file_, H5F_SCOPE_LOCAL), "finish a file");
    const auto size = checked(H5Fget_file_image(file_, nullptr, 0), "finish a file");
    void* memory = nullptr;  // of the driver: the address of its address
    checked(H5Fget_vfd_handle(file_, H5P_DEFAULT, &memory), "finish a file");
    return {*static_cast<const std::byte* const*>(memory), static_cast<std::size_t>(size)};
  }

 private:
  // HDF5 takes files of one name for one file.
  static std::string new_name() {
    static std::uint64_t count = 0;
    return "in memory " + std::to_string(++count);
  }
  static Handle access() {
    Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make properties");
    checked(H5Pset_fapl_core(access, std::size_t{1} << 20, false), "make a file in memory");
    checked(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V110), "choose a format");
    return access;
  }
  static Handle creation() {
    Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "make properties");
    checked(H5Pset_obj_track_times(creation, false), "leave the time out");
    return creation;
  }

  Handle file_;
};

/// A file that is read. Throws std::runtime_error, which names it, where one that it joins is not
/// there or is another one: HDF5 reads fill values in its place, without a word.
class ReadFile {
 public:
  explicit ReadFile(std::string path) : path_(std::move(path)), file_(open(path_)) {
    for (const auto& [part, names] : joined()) {
      try {
        ReadFile(part).require_part(names);
      } catch (const std::runtime_error& why) {
        throw std::runtime_error("the part " + part + " of " + path_ +
                                 " is missing or broken; make it anew by the same run (" +
                                 why.what() + ")");
      }
    }
  }

  /// Throws std::runtime_error where this is not the part that its name tells, or lacks a dataset.
  void require_part(const std::vector<std::string>& datasets) const {
    const std::string name = std::filesystem::path(path_).filename().string();
    const Handle mark(H5Aopen(file_, "part", H5P_DEFAULT), H5Aclose, "find what part this is");
    std::string own(name.size(), 0);
    checked(H5Aread(mark, fixed_text(own.size()), own.data()), "read what part this is");
    if (own != name) throw std::runtime_error(path_ + " was made as " + own);
    for (const std::string& dataset : datasets) {
      if (!has(dataset)) throw std::runtime_error("there is no " + dataset + " in " + path_);
    }
  }

  /// Throws std::runtime_error, which names file and dataset, where numbers of it are not those
  /// that were written, by their checksums; compressed ones stay compressed.
  void require_undamaged(const std::string& name) const {
    const Handle data = dataset(name);
    const Handle made(H5Dget_create_plist(data), H5Pclose, "read " + path_);
    const std::vector<hsize_t> all = shape(name);
    std::vector<hsize_t> chunk(all.size()), at(all.size(), 0);
    if (H5Pget_layout(made) != H5D_CHUNKED) {
      throw std::runtime_error(name + " of " + path_ + " has no checksums");
    }
    checked(H5Pget_chunk(made, static_cast<int>(chunk.size()), chunk.data()), "read " + path_);
    std::vector<std::byte> bytes;
    for (bool is_more = true; is_more;) {
      hsize_t size = 0;
      checked(H5Dget_chunk_storage_size(data, at.data(), &size), "find a chunk of " + path_);
      bytes.resize(size);
      std::uint32_t skipped = 0;
      const bool is_read =
          size > 4 && H5Dread_chunk(data, H5P_DEFAULT, at.data(), &skipped, bytes.data()) >= 0 &&
          skipped == 0;
      const auto sum = is_read ? checksum(std::span(bytes).first(size - 4)) : checksum({});
      if (!is_read || !std::equal(sum.begin(), sum.end(), bytes.end() - 4)) {
        throw std::runtime_error(name + " of " + path_ + " is damaged in its row " +
                                 std::to_string(at[0]));
      }
      is_more = false;  // unless some index has room for another chunk, the last one first
      for (std::size_t i = all.size(); i-- > 0 && !is_more;) {
        at[i] += chunk[i];
        is_more = at[i] < all[i];
        if (!is_more) at[i] = 0;
      }
    }
  }

  [[nodiscard]] bool has(const std::string& name) const {
    return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
  }

  [[nodiscard]] std::vector<hsize_t> shape(const std::string& name) const {
    const Handle data = dataset(name);
    const Handle all(H5Dget_space(data), H5Sclose, "read " + path_);
    std::vector<hsize_t> shape(
        static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(all), "read " + path_)));
    H5Sget_simple_extent_dims(all, shape.data(), nullptr);
    return shape;
  }

  /// A row of a dataset: of numbers of this type, all that its first index leaves.
  template <class T>
  [[nodiscard]] std::vector<T> row(const std::string& name, hsize_t row) const {
    const Handle data = dataset(name);
    std::vector<hsize_t> count = shape(name), start(count.size(), 0);
    if (row >= count[0]) {
      throw std::runtime_error(path_ + " has no row " + std::to_string(row) + " of " + name);
    }
    start[0] = row;
    count[0] = 1;
    std::size_t size = 1;
    for (const hsize_t n : count) size *= n;
    const Handle all(H5Dget_space(data), H5Sclose, "read " + path_);
    const Handle one = space(count);
    checked(H5Sselect_hyperslab(all, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
            "read " + path_);
    std::vector<T> values(size);
    if (H5Dread(data, type_of(number_of<T>()), one, all, H5P_DEFAULT, values.data()) < 0) {
      for (const auto& [part, names] : joined()) ReadFile(part).require_undamaged(name);
      throw std::runtime_error("HDF5 cannot read " + name + " of " + path_);
    }
    return values;
  }

  [[nodiscard]] std::string attribute(const std::string& name) const {
    const Handle attribute(H5Aopen(file_, name.c_str(), H5P_DEFAULT), H5Aclose,
                           "find the attribute " + name + " of " + path_);
    const Handle type(H5Aget_type(attribute), H5Tclose, "read " + path_);
    char* words = nullptr;
    checked(H5Aread(attribute, type, static_cast<void*>(&words)), "read " + path_);
    std::string text(words == nullptr ? "" : words);  // HDF5 has none for an empty text
    H5free_memory(words);
    return text;
  }

 private:
  static Handle open(const std::string& path) {
    return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "open " + path};
  }
  /// The files that the datasets are joined from, and the datasets that each is to have.
  [[nodiscard]] std::map<std::string, std::vector<std::string>> joined() const {
    std::map<std::string, std::vector<std::string>> all;
    H5G_info_t group{};
    checked(H5Gget_info(file_, &group), "read " + path_);
    for (hsize_t i = 0; i < group.nlinks; ++i) {
      const std::string name = text([&](char* to, std::size_t size) {
        return H5Lget_name_by_idx(file_, ".", H5_INDEX_NAME, H5_ITER_INC, i, to, size, H5P_DEFAULT);
      });
      const Handle object(H5Oopen(file_, name.c_str(), H5P_DEFAULT), H5Oclose, "open " + name);
      if (H5Iget_type(object) != H5I_DATASET) continue;
      const Handle made(H5Dget_create_plist(object), H5Pclose, "read " + path_);
      std::size_t count = 0;
      if (H5Pget_layout(made) != H5D_VIRTUAL) continue;
      checked(H5Pget_virtual_count(made, &count), "read " + path_);
      for (std::size_t k = 0; k < count; ++k) {
        const std::string part = text(
            [&](char* to, std::size_t size) { return H5Pget_virtual_filename(made, k, to, size); });
        all[beside(part)].push_back(name);
      }
    }
    return all;
  }
  /// Where HDF5 looks for a part, in whose name % stands twice: beside the file, or what it is a
  /// link to.
  [[nodiscard]] std::string beside(std::string part) const {
    for (std::size_t i = 0; (i = part.find("%%", i)) != std::string::npos; ++i) part.erase(i, 1);
    const auto here = std::filesystem::path(path_).parent_path() / part;
    if (std::filesystem::exists(here)) return here.string();
    return (std::filesystem::canonical(path_).parent_path() / part).string();
  }
  /// A text by a function of HDF5's that tells its length when it is given no room.
  template <class Read>
  [[nodiscard]] std::string text(const Read& read) const {
    std::string words(static_cast<std::size_t>(checked(read(nullptr, 0), "read " + path_)), 0);
    checked(read(words.data(), words.size() + 1), "read " + path_);
    return words;
  }

  [[nodiscard]] Handle dataset(const std::string& name) const {
    return {H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose, "find " + name + " in " + path_};
  }

  std::string path_;
  Handle file_;
};

}  // namespace hdf5
