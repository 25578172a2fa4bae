/* Runs a fuzz target without libFuzzer, on inputs that it makes: settings and
 * the golden blobs, changed at random from a seed.
 *   NAME NUM_INPUTS [SEED]        runs them
 *   NAME --corpus FOLDER          writes the unchanged ones, for libFuzzer */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz_target.h"
#include "golden_blobs.h"
#include "test_frame.h"

#define MAX_INPUT 8192u

static uint32_t state;

static uint32_t below(uint32_t limit) {
  return (next_random(&state) >> 8) % limit;
}

static uint32_t make_input(const golden_blob* blob, uint8_t* input) {
  for (uint32_t i = 0; i < FUZZ_SETTINGS; ++i) input[i] = (uint8_t)below(256);
  memcpy(input + FUZZ_SETTINGS, blob->bytes, blob->size);
  return FUZZ_SETTINGS + blob->size;
}

/* One change, mostly of the first bytes, where the fields are. */
static uint32_t change(uint8_t* input, uint32_t size) {
  static const uint8_t kExtremes[] = {0, 1, 2, 3, 127, 128, 254, 255};
  uint8_t* const blob = input + FUZZ_SETTINGS;
  const uint32_t blob_size = size - FUZZ_SETTINGS;
  if (blob_size == 0) return size;
  const uint32_t reach = below(2) == 0 && blob_size > 480 ? 480 : blob_size;
  const uint32_t at = below(reach);
  switch (below(6)) {
    case 0:
      blob[at] ^= (uint8_t)(1u << below(8));
      break;
    case 1:
      blob[at] = kExtremes[below(sizeof(kExtremes))];
      break;
    case 2:
      blob[at] = (uint8_t)(blob[at] + below(9) - 4);
      break;
    case 3: /* a word */
      for (uint32_t k = at & ~3u; k < (at & ~3u) + 4 && k < blob_size; ++k)
        blob[k] = (uint8_t)below(256);
      break;
    case 4:
      memmove(blob + at, blob + below(blob_size - at) + at, 1);
      break;
    default:
      return below(8) == 0 ? FUZZ_SETTINGS + at : size; /* cut off */
  }
  return size;
}

static int write_corpus(const char* folder) {
  static uint8_t input[MAX_INPUT];
  for (uint32_t k = 0; k < 8 * NUM_GOLDEN_BLOBS; ++k) {
    char path[1024];
    const uint32_t size =
        make_input(&kGoldenBlobs[k % NUM_GOLDEN_BLOBS], input);
    if (snprintf(path, sizeof(path), "%s/%02u", folder, (unsigned)k) >=
        (int)sizeof(path))
      return 1;
    FILE* const file = fopen(path, "wb");
    if (!file) return 1;
    const int is_written = fwrite(input, 1, size, file) == size;
    if (fclose(file) != 0 || !is_written) return 1;
  }
  return 0;
}

/* Each in a block of its size. */
static void run(const uint8_t* input, uint32_t size) {
  uint8_t* const copy = malloc(size);
  if (!copy) return;
  memcpy(copy, input, size);
  LLVMFuzzerTestOneInput(copy, size);
  free(copy);
}

int main(int argc, char** argv) {
  static uint8_t input[MAX_INPUT];
  if (argc == 3 && strcmp(argv[1], "--corpus") == 0)
    return write_corpus(argv[2]);
  const uint32_t num_inputs =
      argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 20000;
  state = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 1;
  for (uint32_t k = 0; k < num_inputs; ++k) {
    uint32_t size = make_input(&kGoldenBlobs[k % NUM_GOLDEN_BLOBS], input);
    for (uint32_t n = k < NUM_GOLDEN_BLOBS ? 0 : below(6); n != 0; --n)
      size = change(input, size);
    run(input, size);
  }
  printf("%u inputs\n", (unsigned)num_inputs);
  return 0;
}
