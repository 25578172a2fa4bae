#include "fuzz_target.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "blob_edit.h"

uint8_t* take_blob(const uint8_t* data, size_t size, uint32_t* blob_size) {
  if (size < FUZZ_SETTINGS) return NULL;
  *blob_size = (uint32_t)(size - FUZZ_SETTINGS);
  uint8_t* const blob = malloc(*blob_size != 0 ? *blob_size : 1);
  if (!blob) return NULL;
  memcpy(blob, data + FUZZ_SETTINGS, *blob_size);
  /* Without this no change would get past the CRCs. */
  if (data[0] % 8 != 0 && *blob_size >= RG_HEADER_SIZE)
    repair_crcs(blob, *blob_size);
  return blob;
}

void require(int is_true, const char* promise) {
  if (is_true) return;
  fprintf(stderr, "fuzzing: not kept: %s\n", promise);
  abort();
}
