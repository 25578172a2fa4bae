/* A fuzz target: libFuzzer calls it, and so does fuzz_driver.c. */
#ifndef RAYGRID_FUZZ_TARGET_H
#define RAYGRID_FUZZ_TARGET_H

#include <stddef.h>
#include <stdint.h>

/* An input begins with so many bytes of settings; the rest is a blob. */
#define FUZZ_SETTINGS 64u

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

/* Takes the settings and a copy of the blob, with or without CRCs that hold, in
 * a block of exactly its size; the caller frees it. NULL: nothing to do. */
uint8_t* take_blob(const uint8_t* data, size_t size, uint32_t* blob_size);

/* Little-endian, of the settings. */
static inline uint32_t setting(const uint8_t* data, uint32_t offset) {
  return data[offset] | (uint32_t)data[offset + 1] << 8 |
         (uint32_t)data[offset + 2] << 16 | (uint32_t)data[offset + 3] << 24;
}

/* A condition, mostly in the range of the golden blob with a stack. */
static inline int32_t near_condition(const uint8_t* data) {
  const uint32_t value = setting(data, 52);
  return (int32_t)(data[56] % 8 == 0 ? value : value % (8u << 16)) - (1 << 16);
}

/* Stops the program where a promise of the library is not kept. */
void require(int is_true, const char* promise);

#endif /* RAYGRID_FUZZ_TARGET_H */
