/* The loader as Frama-C's EVA analyses it: it loads a golden blob of which all
 * but the layout may be anything. Known are the header, where sections lie, and
 * how large remap tables are; fields, values, texts and CRCs are not.
 *
 *   -DBLOB=kWideBlob, ...: the golden blob */
#include <__fc_builtin.h>

#include "golden_blobs.h"
#include "raygrid.h"
#include "rg_blob.h"

#define HEADER_BEFORE_CRC 28u
#define ENTRY_BEFORE_CRC 12u

static uint32_t words[sizeof(BLOB) / 4];

static void know(uint32_t offset, uint32_t num_bytes) {
  uint8_t* const bytes = (uint8_t*)words;
  //@ loop unroll 80;
  for (uint32_t i = 0; i < num_bytes; ++i) bytes[offset + i] = BLOB[offset + i];
}

/* Sizes, shifts of blocks and parts, and where the vertices begin. */
static void know_remap_layout(uint32_t section) {
  know(section, 9);
  know(section + 10, 1);
  know(section + 76, 4);
}

int main(void) {
  Frama_C_make_unknown((char*)words, sizeof words);
  know(0, HEADER_BEFORE_CRC);
  //@ loop unroll 16;
  for (uint32_t k = 0; k < BLOB[16]; ++k) {
    const uint32_t entry = RG_HEADER_SIZE + k * RG_SECTION_ENTRY_SIZE;
    know(entry, ENTRY_BEFORE_CRC);
    if (BLOB[entry] == RG_SECTION_REMAP)
      know_remap_layout(BLOB[entry + 4] | (uint32_t)BLOB[entry + 5] << 8);
  }
  rg_camera camera;
  if (rg_camera_open(&camera, words, sizeof words) != RG_OK) return 0;
  //@ loop unroll 3;
  for (uint32_t index = 0; index < 3; ++index)
    (void)rg_select_remap(&camera, index);
  return 0;
}
