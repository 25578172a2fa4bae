#include "crc32.h"

#if defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)

/* One entry per nibble: 64 bytes of flash instead of 1024, at the cost of two
 * look-ups per byte. */
static const uint32_t kHalfByteTable[16] = {
    0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu,
    0x76dc4190u, 0x6b6b51f4u, 0x4db26158u, 0x5005713cu,
    0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu,
    0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu};

static inline uint32_t add_byte(uint32_t crc, uint8_t byte) {
  crc ^= byte;
  crc = (crc >> 4) ^ kHalfByteTable[crc & 15u];
  return (crc >> 4) ^ kHalfByteTable[crc & 15u];
}

#else

/* Adds a byte bit by bit: no table, at a third of the speed. */
static inline uint32_t add_byte(uint32_t crc, uint8_t byte) {
  crc ^= byte;
  for (int bit = 0; bit < 8; ++bit)
    crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  return crc;
}

#endif

uint32_t rg_crc32(uint32_t crc, const uint8_t* bytes, uint32_t num_bytes) {
  crc = ~crc;
  for (uint32_t i = 0; i < num_bytes; ++i) crc = add_byte(crc, bytes[i]);
  return ~crc;
}
