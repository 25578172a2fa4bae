/* Pseudo-random numbers, and the image that the golden CRCs were made with. */
#ifndef RAYGRID_TEST_FRAME_H
#define RAYGRID_TEST_FRAME_H

#include <stdint.h>

#include "golden_blobs.h"

static inline uint32_t next_random(uint32_t* state) {
  *state = *state * 1664525u + 1013904223u;
  return *state;
}

/* Leaves the bytes between the rows alone. */
static inline void make_test_frame(uint8_t* data, uint32_t stride,
                                   uint32_t width, uint32_t height) {
  uint32_t state = GOLDEN_FRAME_SEED;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      data[y * stride + x] = (uint8_t)(2 * x + y + (next_random(&state) >> 27));
}

#endif /* RAYGRID_TEST_FRAME_H */
