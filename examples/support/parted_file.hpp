#pragma once

#include <isa-l.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "durable_file.hpp"
#include "gelight/core/wide.hpp"
#include "hdf5.hpp"

// A large HDF5 file that many processes make, part by part, and go on with after being killed:
//
//     out.h5.parts/description      what it is made of: a run of something else is refused
//     out.h5.parts/lock             kept by the run that goes on: a second one is refused
//     out.h5.parts/000000-*.h5 ...  rows 0 to n - 1 and so on: each is whole or not there
//     out.h5                        at the end: one virtual dataset a column, over all parts
//
// Where a part is taken away, HDF5 reads NaN, or -1 and the largest number of whole ones. A part's
// name has the hash of what it is made of, and how many rows it has: so a file that was renamed or
// copied never takes the parts of another for its own, and a file that joins other parts stays
// valid until one that joins more rows has taken its place. All numbers have checksums.

/// One dataset of the file: an array for each row.
struct Column {
  std::string name;
  hdf5::Number number;
  std::vector<hsize_t> shape = {};  ///< of a row
  bool is_compressed = false;       ///< a chunk a row, by shuffle and deflate; else several
  hsize_t planes = 1;               ///< of the row's last index, in a chunk each

  [[nodiscard]] std::size_t row_bytes() const {
    std::size_t bytes = hdf5::bytes_of(number);
    for (const hsize_t n : shape) bytes *= n;
    return bytes;
  }
  [[nodiscard]] std::vector<hsize_t> shape_of(hsize_t rows) const {
    std::vector<hsize_t> all{rows};
    all.insert(all.end(), shape.begin(), shape.end());
    return all;
  }
};

/// The rows of one part, as the HDF5 file that they make, in memory: compressed where they shall
/// be.
class Part {
 public:
  Part(const std::vector<Column>& columns, hsize_t rows, const std::string& name)
      : columns_(columns), plain_(columns.size()), tables_(ISAL_DEF_LVL1_DEFAULT) {
    const auto guard = hdf5::lock();
    file_.emplace();
    file_->mark_as_part(name);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      data_.push_back(new_dataset(columns[c], rows));
      if (!columns[c].is_compressed) plain_[c].resize(rows * columns[c].row_bytes());
    }
  }
  ~Part() {
    const auto guard = hdf5::lock();
    data_.clear();
    file_.reset();
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  /// Sets one row of a column.
  template <class T>
  void put(std::size_t column, hsize_t row, std::span<const T> values) {
    const Column& of = columns_[column];
    if (hdf5::number_of<T>() != of.number || values.size_bytes() != of.row_bytes()) {
      throw std::logic_error("what is put into " + of.name + " is not a row of it");
    }
    const auto bytes = std::as_bytes(values);
    if (of.is_compressed) {
      for (hsize_t plane = 0; plane < of.planes; ++plane) {
        const auto packed = compressed(shuffled(bytes, sizeof(T), of.planes, plane));
        std::vector<hsize_t> offset(of.shape.size() + 1, 0);
        if (of.planes > 1) offset.back() = plane;
        offset[0] = row;
        const auto guard = hdf5::lock();
        hdf5::checked(H5Dwrite_chunk(data_[column], H5P_DEFAULT, 0, offset.data(), packed.size(),
                                     packed.data()),
                      "write " + of.name);
      }
    } else {
      std::copy(bytes.begin(), bytes.end(),
                plain_[column].begin() + static_cast<std::ptrdiff_t>(row * of.row_bytes()));
    }
  }

  /// The file, whose rows are all set.
  [[nodiscard]] std::span<const std::byte> file() {
    const auto guard = hdf5::lock();
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].is_compressed) continue;
      hdf5::checked(H5Dwrite(data_[c], hdf5::type_of(columns_[c].number), H5S_ALL, H5S_ALL,
                             H5P_DEFAULT, plain_[c].data()),
                    "write " + columns_[c].name);
    }
    data_.clear();
    return file_->bytes();
  }

 private:
  static constexpr int level = 1;  // more takes longer than rendering, and saves little

  /// The numbers of one plane, the first bytes of all of them first, as HDF5's filter has them.
  std::span<const std::byte> shuffled(std::span<const std::byte> bytes, std::size_t number,
                                      std::size_t planes, std::size_t plane) {
    if (number * planes == 1) return bytes;
    const std::size_t count = bytes.size() / (number * planes);
    shuffled_.resize(count * number);
    for (std::size_t b = 0; b < number; ++b) {
      std::byte* const to = shuffled_.data() + b * count;
      const std::byte* const from = bytes.data() + plane * number + b;
      if (number * planes == 3) {  // as of colours: a step that is known takes wide registers
        gelight::detail::vectorised([&] { pick(to, from, count, 3); });
      } else {
        pick(to, from, count, number * planes);
      }
    }
    return shuffled_;
  }

  /// The first byte of each step.
  static void pick(std::byte* __restrict to, const std::byte* __restrict from, std::size_t count,
                   std::size_t step) {
    for (std::size_t i = 0; i < count; ++i) to[i] = from[step * i];
  }

  /// What HDF5's deflate and fletcher32 make of them, but by ISA-L in less than half of zlib's
  /// time.
  std::span<const std::byte> compressed(std::span<const std::byte> bytes) {
    packed_.resize(bytes.size() + bytes.size() / 16 + 1024);  // more than what cannot be compressed
    isal_zstream stream{};
    isal_deflate_stateless_init(&stream);
    stream.gzip_flag = IGZIP_ZLIB;
    stream.level = level;
    stream.level_buf = tables_.data();
    stream.level_buf_size = static_cast<std::uint32_t>(tables_.size());
    stream.end_of_stream = 1;
    // (ISA-L only reads what it takes as not constant.)
    stream.next_in = reinterpret_cast<std::uint8_t*>(const_cast<std::byte*>(bytes.data()));
    stream.avail_in = static_cast<std::uint32_t>(bytes.size());
    stream.next_out = reinterpret_cast<std::uint8_t*>(packed_.data());
    stream.avail_out = static_cast<std::uint32_t>(packed_.size());
    if (isal_deflate_stateless(&stream) != COMP_OK) throw std::logic_error("ISA-L fails");
    const auto packed = std::span(packed_).first(stream.total_out);
    std::ranges::copy(hdf5::checksum(packed), packed.end());
    return std::span(packed_).first(packed.size() + 4);
  }

  [[nodiscard]] hdf5::Handle new_dataset(const Column& column, hsize_t rows) const {
    const auto properties = hdf5::dataset_properties();
    const hsize_t rows_a_chunk = std::max<hsize_t>(1, (hsize_t{1} << 20) / column.row_bytes());
    std::vector<hsize_t> chunk =
        column.shape_of(column.is_compressed ? 1 : std::min(rows, rows_a_chunk));
    if (column.is_compressed && column.planes > 1) chunk.back() = 1;
    hdf5::checked(H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data()),
                  "choose chunks");
    if (column.is_compressed) {
      if (hdf5::bytes_of(column.number) > 1) hdf5::checked(H5Pset_shuffle(properties), "shuffle");
      hdf5::checked(H5Pset_deflate(properties, level), "deflate");
    }
    hdf5::checked(H5Pset_fletcher32(properties), "add checksums");
    return hdf5::new_dataset(*file_, column.name, column.number, column.shape_of(rows), properties);
  }

  std::span<const Column> columns_;
  std::optional<hdf5::MemoryFile> file_;
  std::vector<hdf5::Handle> data_;             // of each column
  std::vector<std::vector<std::byte>> plain_;  // of each column that is not compressed
  std::vector<std::uint8_t> tables_;           // that ISA-L works with
  std::vector<std::byte> shuffled_, packed_;
};

/// The file that the parts make. Any rank may write any part; the rest is for one of them.
class PartedFile {
 public:
  PartedFile(std::string path, std::string description, std::vector<Column> columns,
             std::uint64_t rows, std::uint64_t rows_a_part)
      : path_(std::move(path)),
        folder_(path_ + ".parts"),
        description_(std::move(description)),
        columns_(std::move(columns)),
        rows_(rows),
        asked_a_part_(rows_a_part),
        rows_a_part_(std::min(rows_a_part, rows)) {}

  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }
  [[nodiscard]] std::uint64_t rows() const { return rows_; }
  [[nodiscard]] int part_count() const {
    return static_cast<int>((rows_ + rows_a_part_ - 1) / rows_a_part_);
  }
  [[nodiscard]] std::uint64_t first_row(int part) const {
    return static_cast<std::uint64_t>(part) * rows_a_part_;
  }
  [[nodiscard]] std::uint64_t rows_of(int part) const {
    return std::min(rows_a_part_, rows_ - first_row(part));
  }
  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (int part = 0; part < part_count(); ++part) {
      sum += std::filesystem::file_size(part_path(part));
    }
    return sum;
  }

  /// How much memory a part takes at most.
  [[nodiscard]] double part_bytes() const {
    double bytes = 0;
    for (const Column& column : columns_) bytes += static_cast<double>(column.row_bytes());
    return bytes * static_cast<double>(rows_a_part_);
  }

  /// Makes the folder, or finds what a run before this one has left there, and returns the parts
  /// that are missing: that run may have been of fewer rows. All parts are read, and `told` gets a
  /// line for each that is damaged and so is missing. Throws std::runtime_error where it was
  /// of another description or of more rows, or still goes on, and where there is something else in
  /// the file's place.
  [[nodiscard]] std::vector<int> begin(const std::function<void(const std::string&)>& told) {
    if (part_bytes() > 8e9) {
      throw std::runtime_error("a part of " + std::to_string(rows_a_part_) + " rows can take " +
                               std::to_string(part_bytes() / 1e9) +
                               " GB of memory: make it smaller");
    }
    if (!std::filesystem::path(path_).has_filename()) {
      throw std::runtime_error("\"" + path_ + "\" names no file");
    }
    const auto parent = durable_detail::folder_of(path_);
    if (!std::filesystem::is_directory(parent)) {
      throw std::runtime_error("there is no folder " + parent.string() + " for " + path_);
    }
    const std::string note = folder_ + "/description";
    if (std::filesystem::exists(path_) &&
        (std::filesystem::is_directory(path_) || !std::filesystem::exists(note))) {
      throw std::runtime_error(path_ + " is there, and was not made here; write elsewhere");
    }
    std::filesystem::create_directory(folder_);
    alone_.emplace(folder_ + "/lock");
    const std::string text = description_of(rows_);
    std::ifstream file(note);
    const std::string found{std::istreambuf_iterator<char>(file), {}};
    if (found != text) {
      if (has_parts()) {
        const std::uint64_t before = rows_described(found);
        if (before == 0 || before > rows_) {
          throw std::runtime_error(
              folder_ + " was begun with " +
              (before == 0 ? "another description, see " + note
                           : std::to_string(before) + " rows, more than " + std::to_string(rows_)) +
              "; remove the folder or write elsewhere");
        }
      }
      write_durably(note, std::as_bytes(std::span(text)));
    }
    std::vector<int> missing;
    for (int part = 0; part < part_count(); ++part) {
      const std::string damage = damage_of(part);
      if (!damage.empty()) told(part_path(part) + " is made again: " + damage);
      if (!damage.empty() || !std::filesystem::exists(part_path(part))) missing.push_back(part);
    }
    return missing;
  }

  /// What the rows of a part are put into.
  [[nodiscard]] Part new_part(int part) const {
    return Part(columns_, rows_of(part), part_name(part));
  }
  void write(int part, Part& rows) const { write_durably(part_path(part), rows.file()); }

  /// Joins the parts, all of which are there, to one file, with notes as attributes; removes what
  /// killed processes have left half written, and then parts that no longer belong to it.
  void finish(const std::vector<std::pair<std::string, std::string>>& notes) const {
    remove_from_folder([](const auto& path) { return path.extension() == ".tmp"; });
    remove_half_written(path_);
    join(notes);
    std::set<std::string> names;
    for (int part = 0; part < part_count(); ++part) names.insert(part_name(part));
    remove_from_folder([&](const auto& path) {
      return path.extension() == ".h5" && !names.contains(path.filename().string());
    });
  }

 private:
  void join(const std::vector<std::pair<std::string, std::string>>& notes) const {
    const auto guard = hdf5::lock();
    const hdf5::MemoryFile file;
    for (const auto& [name, text] : notes) file.attribute(name, text);
    for (const Column& column : columns_) {
      const auto properties = hdf5::dataset_properties();
      hdf5::fill_with_ones(properties, column.number);
      const auto all = hdf5::space(column.shape_of(rows_));
      for (int part = 0; part < part_count(); ++part) map(properties, all, column, part);
      const auto data =
          hdf5::new_dataset(file, column.name, column.number, column.shape_of(rows_), properties);
    }
    write_durably(path_, file.bytes());
  }

  void remove_from_folder(const std::function<bool(const std::filesystem::path&)>& which) const {
    std::vector<std::filesystem::path> all;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      if (entry.is_regular_file() && which(entry.path())) all.push_back(entry.path());
    }
    for (const auto& path : all) std::filesystem::remove(path);
  }

  [[nodiscard]] std::string description_of(std::uint64_t rows) const {
    return description_ + "\n" + std::to_string(rows) + " rows, " + std::to_string(asked_a_part_) +
           " a part\n";
  }
  /// For how many rows this is the note, or 0 where it is of another description.
  [[nodiscard]] std::uint64_t rows_described(const std::string& note) const {
    if (!note.starts_with(description_ + "\n")) return 0;
    const char* const number = note.data() + description_.size() + 1;
    std::uint64_t rows = 0;
    std::from_chars(number, note.data() + note.size(), rows);
    return note == description_of(rows) ? rows : 0;
  }
  [[nodiscard]] std::string part_path(int part) const { return folder_ + "/" + part_name(part); }
  /// Of the description and what this part has of it, whatever the rows in all.
  [[nodiscard]] std::string part_name(int part) const {
    std::uint64_t hash = 14695981039346656037U;
    for (const char c : description_of(rows_of(part))) {
      hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
    }
    char name[64];
    std::snprintf(name, sizeof name, "%06d-%016llx.h5", part,
                  static_cast<unsigned long long>(hash));
    return name;
  }

  [[nodiscard]] bool has_parts() const {
    const std::filesystem::directory_iterator entries(folder_);
    return std::any_of(std::filesystem::begin(entries), std::filesystem::end(entries),
                       [](const auto& entry) { return entry.path().extension() == ".h5"; });
  }

  /// What a damaged disk has left of a part; nothing where it is whole or not there.
  [[nodiscard]] std::string damage_of(int part) const {
    if (!std::filesystem::exists(part_path(part))) return "";
    const auto guard = hdf5::lock();
    try {
      const hdf5::ReadFile file(part_path(part));
      file.require_part({});
      for (const Column& column : columns_) {
        if (file.shape(column.name) != column.shape_of(rows_of(part))) {
          return column.name + " has another shape";
        }
        file.require_undamaged(column.name);
      }
      return "";
    } catch (const std::runtime_error& why) {
      return why.what();
    }
  }

  /// Lays a part's rows into a column of all, by a path from where the joined file lies.
  void map(hid_t properties, hid_t all, const Column& column, int part) const {
    std::vector<hsize_t> start(column.shape.size() + 1, 0);
    start[0] = first_row(part);
    const std::vector<hsize_t> count = column.shape_of(rows_of(part));
    hdf5::checked(
        H5Sselect_hyperslab(all, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
        "choose the rows of a part");
    std::string from;  // in which % stands for itself
    for (const char c :
         std::filesystem::path(folder_).filename().string() + "/" + part_name(part)) {
      from += c == '%' ? "%%" : std::string(1, c);
    }
    hdf5::checked(
        H5Pset_virtual(properties, all, from.c_str(), column.name.c_str(), hdf5::space(count)),
        "join " + column.name);
  }

  std::string path_, folder_, description_;
  std::vector<Column> columns_;
  std::uint64_t rows_, asked_a_part_, rows_a_part_;
  std::optional<OneProcess> alone_;  // since `begin`
};
