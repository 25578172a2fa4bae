/// Reads numbers from untrusted binary files: every read is checked.
#ifndef RAYGRID_DATASET_BYTE_READER_H
#define RAYGRID_DATASET_BYTE_READER_H

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "dataset/error.h"

namespace raygrid {

enum class ByteOrder { kLittle, kBig };

/// Sequential reader of numbers. All functions throw InputError at the end of
/// the data.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <typename Number>
  Number Get(ByteOrder order = ByteOrder::kLittle) {
    constexpr size_t kSize = sizeof(Number);
    Require(1, kSize);
    uint64_t bits = 0;
    for (size_t k = 0; k < kSize; ++k) {
      const size_t position = order == ByteOrder::kLittle ? k : kSize - 1 - k;
      bits |= uint64_t{static_cast<unsigned char>(bytes_[at_ + k])}
              << 8 * position;
    }
    at_ += kSize;
    Number number;
    std::memcpy(&number, &bits, kSize);
    return number;
  }
  /// Reads a finite double or float.
  template <typename Number = double>
  Number GetFinite() {
    const auto number = Get<Number>();
    if (!std::isfinite(number))
      throw InputError(fmt::format("expected a finite number at byte {}",
                                   at_ - sizeof(number)));
    return number;
  }
  /// Reads a null-terminated string.
  std::string GetText() {
    std::string text;
    while (const auto c = Get<uint8_t>()) text.push_back(static_cast<char>(c));
    return text;
  }
  /// Reads `size` bytes.
  std::string GetText(uint64_t size) { return std::string(View(size)); }
  /// Like GetText(), without a copy.
  std::string_view View(uint64_t size) {
    Require(size, 1);
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  void Skip(uint64_t count, size_t size) {
    Require(count, size);
    at_ += count * size;
  }
  /// Requires that `count` elements of `size` bytes remain.
  void Require(uint64_t count, size_t size) const {
    if (count > (bytes_.size() - at_) / size)
      throw InputError(fmt::format("truncated after {} bytes; copy it again",
                                   bytes_.size()));
  }
  /// Number of bytes read so far, and left.
  size_t at() const { return at_; }
  size_t remaining() const { return bytes_.size() - at_; }
  void RequireEnd() const {
    if (at_ != bytes_.size())
      throw InputError(
          fmt::format("has {} after its end",
                      bytes_.size() - at_ == 1
                          ? "1 byte"
                          : std::to_string(bytes_.size() - at_) + " bytes"));
  }

 private:
  std::string_view bytes_;
  size_t at_ = 0;
};

template <typename Number>
void Append(Number number, std::string* bytes,
            ByteOrder order = ByteOrder::kLittle) {
  constexpr size_t kSize = sizeof(Number);
  uint64_t bits = 0;
  std::memcpy(&bits, &number, kSize);
  for (size_t k = 0; k < kSize; ++k) {
    const size_t position = order == ByteOrder::kLittle ? k : kSize - 1 - k;
    bytes->push_back(static_cast<char>(bits >> 8 * position & 0xff));
  }
}

}  // namespace raygrid

#endif  // RAYGRID_DATASET_BYTE_READER_H
