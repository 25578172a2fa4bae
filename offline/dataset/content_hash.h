#ifndef RAYGRID_DATASET_CONTENT_HASH_H
#define RAYGRID_DATASET_CONTENT_HASH_H

#include <fmt/format.h>

#include <cstdint>
#include <string>

namespace raygrid {

__extension__ using Uint128 = unsigned __int128;

/// 128-bit FNV-1a hash of contents; not cryptographic. Inputs are delimited:
/// "ab", "c" differs from "a", "bc".
class ContentHash {
 public:
  void Add(const std::string& part) {
    AddBytes(part);
    AddBytes(fmt::format(" {} ", part.size()));
  }
  std::string Text() const {
    return fmt::format("{:016x}{:016x}", static_cast<uint64_t>(state_ >> 64),
                       static_cast<uint64_t>(state_));
  }

 private:
  void AddBytes(const std::string& bytes) {
    constexpr Uint128 kPrime = (Uint128{1} << 88) + 0x13b;
    for (const unsigned char byte : bytes) state_ = (state_ ^ byte) * kPrime;
  }
  Uint128 state_ = (Uint128{0x6c62272e07bb0142} << 64) + 0x62b821756295c58d;
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CONTENT_HASH_H
