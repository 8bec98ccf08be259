// HDF5 files that appear complete or not at all; private to src/io.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hdf5_handle.hpp"
#include "voile/errors.hpp"

namespace voile::results {

[[noreturn]] inline void fail_writing(const std::filesystem::path& file) {
  throw UserError(fmt::format("{}: writing failed; is the disk full or the folder write-protected?", file.string()));
}

/// Owns one HDF5 identifier of a file being written.
class Id : public Hdf5Handle {
 public:
  Id(hid_t id, Closer closer, const std::filesystem::path& file) : Hdf5Handle(id, closer), file_(file) {
    if (id < 0) fail_writing(file_);
  }
  /// Only if closing succeeds is the data in the file.
  void close() {
    if (!Hdf5Handle::close()) fail_writing(file_);
  }

 private:
  const std::filesystem::path& file_;
};

/// What a file in memory consists of once HDF5 has closed it.
class Image {
 public:
  Image() = default;
  ~Image() { std::free(closed_); }
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;
  /// Makes files of this access property list live in memory and end here.
  void catch_file(hid_t access) {
    H5Pset_fapl_core(access, 1 << 20, false);
    H5FD_file_image_callbacks_t calls{get, nullptr, resize, release, fraction, leave, this};
    H5Pset_file_image_callbacks(access, &calls);
  }
  /// Memory grows in larger pieces; where the file ends is at byte 28 of the superblock of format 1.8.
  [[nodiscard]] std::string_view bytes() const {
    std::uint64_t end = 0;
    if (size_ >= 36) std::memcpy(&end, static_cast<const char*>(closed_) + 28, sizeof end);
    return {static_cast<const char*>(closed_), std::min<std::size_t>(size_, end)};
  }

 private:
  static void* get(std::size_t size, H5FD_file_image_op_t, void* self) {
    static_cast<Image*>(self)->size_ = size;
    return std::calloc(1, size);
  }
  static void* resize(void* memory, std::size_t size, H5FD_file_image_op_t, void* self) {
    static_cast<Image*>(self)->size_ = size;
    return std::realloc(memory, size);
  }
  static herr_t release(void* memory, H5FD_file_image_op_t when, void* self) {
    if (when == H5FD_FILE_IMAGE_OP_FILE_CLOSE)
      std::free(std::exchange(static_cast<Image*>(self)->closed_, memory));
    else
      std::free(memory);
    return 0;
  }
  static void* fraction(void* self) { return self; }
  static herr_t leave(void*) { return 0; }

  void* closed_ = nullptr;
  std::size_t size_ = 0;
};

/// Writes groups, datasets and attributes into an open file. Groups on the way to an object are made.
class FileContent {
 public:
  FileContent(const FileContent&) = delete;
  FileContent& operator=(const FileContent&) = delete;

  void group(const std::string& name) {
    Id(H5Gcreate2(*file_, name.c_str(), parents(), H5P_DEFAULT, H5P_DEFAULT), H5Gclose, temporary_).close();
  }

  /// A link to an object of a file that lies relative to this one.
  void link(const std::string& name, const std::string& target_file, const std::string& target) {
    if (H5Lcreate_external(target_file.c_str(), target.c_str(), *file_, name.c_str(), parents(), H5P_DEFAULT) < 0)
      fail_writing(temporary_);
  }

  /// Copies an object with all that is in it from another file.
  void copy(hid_t from, const std::string& source, const std::string& name) {
    if (H5Ocopy(from, source.c_str(), *file_, name.c_str(), H5P_DEFAULT, parents()) < 0) fail_writing(temporary_);
  }

  void text(const std::string& object, const char* name, const std::string& value) {
    attribute(object, name, Text(value.size(), temporary_), 0, value.c_str());
  }

  /// A text declared as ASCII, which some readers insist on.
  void ascii(const std::string& object, const char* name, const std::string& value) {
    attribute(object, name, Text(value.size(), temporary_, H5T_CSET_ASCII), 0, value.c_str());
  }

  /// A list of texts, each filled up with zeros to the longest.
  void texts(const std::string& name, const std::vector<std::string>& values) {
    std::size_t width = 1;
    for (const std::string& v : values) width = std::max(width, v.size());
    std::string all;
    for (const std::string& v : values) all += v + std::string(width - v.size(), '\0');
    dataset(name, Text(width, temporary_), values.size(), 1, all.data());
  }

  void number(const std::string& object, const char* name, double value) {
    attribute(object, name, H5T_NATIVE_DOUBLE, 0, &value);
  }
  void number(const std::string& object, const char* name, int value) {
    attribute(object, name, H5T_NATIVE_INT, 0, &value);
  }
  void numbers(const std::string& object, const char* name, const std::vector<std::int64_t>& values) {
    attribute(object, name, H5T_NATIVE_INT64, values.size(), values.data());
  }

  /// rows x columns values; one column makes a plain list. A checksum (Fletcher 32) shows damage when it is read.
  void dataset(const std::string& name, hid_t type, std::size_t rows, std::size_t columns, const void* values) {
    dataset(name, type, rows, columns, values, columns == 1 ? 1 : 2);
  }
  /// The same with one or two dimensions.
  void dataset(const std::string& name, hid_t type, std::size_t rows, std::size_t columns, const void* values,
               int dimensions) {
    const std::array<hsize_t, 2> size{rows, columns};
    const Id space(H5Screate_simple(dimensions, size.data(), nullptr), H5Sclose, temporary_);
    const Id how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, temporary_);
    if (rows > 0) checked_chunks(how, {std::min(rows, most_rows(columns)), columns}, dimensions);
    Id set(H5Dcreate2(*file_, name.c_str(), type, space, parents(), how, H5P_DEFAULT), H5Dclose, temporary_);
    if (rows > 0 && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) fail_writing(temporary_);
    set.close();
  }

 protected:
  explicit FileContent(const std::filesystem::path& path) : path_(path), temporary_(path.string() + ".part") {}
  ~FileContent() = default;

  [[nodiscard]] static hid_t plane(std::size_t rows, std::size_t columns) {
    const std::array<hsize_t, 2> size{rows, columns};
    return H5Screate_simple(columns == 1 ? 1 : 2, size.data(), nullptr);
  }
  /// Rows of a chunk of some 8 MB at most.
  [[nodiscard]] static std::size_t most_rows(std::size_t columns) {
    return std::max<std::size_t>(1, 1000000 / columns);
  }
  void checked_chunks(hid_t how, const std::array<hsize_t, 2>& chunk, int dimensions) const {
    if (H5Pset_chunk(how, dimensions, chunk.data()) < 0 || H5Pset_fletcher32(how) < 0) fail_writing(temporary_);
  }
  [[nodiscard]] hid_t parents() {
    if (!parents_) {
      parents_.emplace(H5Pcreate(H5P_LINK_CREATE), H5Pclose, temporary_);
      H5Pset_create_intermediate_group(*parents_, 1);
    }
    return *parents_;
  }

  std::filesystem::path path_, temporary_;
  std::optional<Id> file_;

 private:
  /// Type of texts of so many bytes.
  class Text : public Id {
   public:
    Text(std::size_t bytes, const std::filesystem::path& file, H5T_cset_t letters = H5T_CSET_UTF8)
        : Id(H5Tcopy(H5T_C_S1), H5Tclose, file) {
      H5Tset_size(*this, std::max<std::size_t>(1, bytes));
      H5Tset_cset(*this, letters);
      H5Tset_strpad(*this, H5T_STR_NULLPAD);
    }
  };

  /// One value if `count` is 0, else a list.
  void attribute(const std::string& object, const char* name, hid_t type, hsize_t count, const void* value) {
    const Id space(count == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose, temporary_);
    Id a(H5Acreate_by_name(*file_, object.c_str(), name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
         temporary_);
    if (H5Awrite(a, type, value) < 0) fail_writing(temporary_);
    a.close();
  }

  std::optional<Id> parents_;
};

/// Versions of the format: 1.8 for files that older programs shall read too, 1.10 for virtual datasets and for half the
/// overhead of a small file. In both the library checks sums over its own structures.
enum class Format { v1_8, v1_10 };

/// An HDF5 file that appears under its name complete or not at all. It is made in memory and written in one go: over a
/// file that it could not write, on a full disk for one, HDF5 crashes at the end of the process.
class NewFile : public FileContent {
 public:
  explicit NewFile(const std::filesystem::path& path, Format format = Format::v1_10) : FileContent(path) {
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, temporary_);
    image_.catch_file(access);
    const H5F_libver_t version = format == Format::v1_8 ? H5F_LIBVER_V18 : H5F_LIBVER_V110;
    H5Pset_libver_bounds(access, version, version);
    file_.emplace(H5Fcreate(temporary_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, temporary_);
  }
  ~NewFile() { file_.reset(); }  // before its image

  /// Writes the file and gives it its name. Throws UserError if that fails; a file of that name then stays as it was.
  void finish() {
    file_->close();
    std::ofstream out(temporary_, std::ios::binary);
    out << image_.bytes();
    out.close();
    std::error_code error;
    if (out) std::filesystem::rename(temporary_, path_, error);
    if (out && !error) return;
    std::filesystem::remove(temporary_, error);
    fail_writing(path_);
  }
  /// Bytes of a finished file.
  [[nodiscard]] std::size_t size() const { return image_.bytes().size(); }

 private:
  Image image_;
};

}  // namespace voile::results
