// Values as a row of bytes, to send them to another process of the same program.
#pragma once

#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "types.hpp"
#include "voile/errors.hpp"

namespace voile {

class ByteWriter {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof value); }
  void put(const std::string& text) {
    put(text.size());
    bytes_ += text;
  }
  void put(const Vec2& x) { put(x[0]), put(x[1]); }
  void put(const Vec3& x) { put(x[0]), put(x[1]), put(x[2]); }
  template <class T, std::size_t n>
  void put(const std::array<T, n>& items) {
    for (const T& item : items) put(item);
  }
  template <class T>
  void put(const std::vector<T>& items) {
    put(items.size());
    for (const T& item : items) put(item);
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads in the order of writing. Throws InternalError if the bytes end too early.
class ByteReader {
 public:
  explicit ByteReader(std::string bytes) : bytes_(std::move(bytes)) {}
  template <class T>
  requires std::is_arithmetic_v<T>
  void get(T& value) {
    need(sizeof value);
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
  }
  void get(std::string& text) {
    std::size_t size = 0;
    get(size);
    need(size);
    text = bytes_.substr(at_, size);
    at_ += size;
  }
  void get(Vec2& x) { get(x[0]), get(x[1]); }
  void get(Vec3& x) { get(x[0]), get(x[1]), get(x[2]); }
  template <class T, std::size_t n>
  void get(std::array<T, n>& items) {
    for (T& item : items) get(item);
  }
  template <class T>
  void get(std::vector<T>& items) {
    std::size_t size = 0;
    get(size);
    need(size);  // an item has at least one byte
    items.resize(size);
    for (T& item : items) get(item);
  }

 private:
  void need(std::size_t count) const {
    if (count > bytes_.size() - at_) throw InternalError("data of another process end too early");
  }
  std::string bytes_;
  std::size_t at_ = 0;
};

}  // namespace voile
