/* Two slots for a blob in flash: SPEC.md, "Slots". */
#include "blob_layout.h"
#include "bytes.h"
#include "code_size.h"
#include "crc32.h"
#include "raygrid.h"

/* "RGSL", "OTS\0" */
#define MAGIC_0 0x4c534752u
#define MAGIC_1 0x0053544fu
#define MAJOR_AND_SIZE (1u | RG_SLOT_HEADER_SIZE << 16)

/* A slot that is corrupt, erased or partially written is incomplete. */
static int is_whole(const uint8_t* slot, uint32_t slot_size) {
  if (rg_load_u32(slot + RG_SLOT_MAGIC) != MAGIC_0 ||
      rg_load_u32(slot + RG_SLOT_MAGIC + 4) != MAGIC_1 ||
      rg_load_u32(slot + RG_SLOT_MAJOR) != MAJOR_AND_SIZE ||
      rg_load_u32(slot + RG_SLOT_HEADER_CRC) !=
          rg_crc32(0, slot, RG_SLOT_HEADER_CRC))
    return 0;
  const uint32_t blob_size = rg_load_u32(slot + RG_SLOT_BLOB_SIZE);
  return blob_size - 1 < slot_size - RG_SLOT_HEADER_SIZE &&
         rg_load_u32(slot + RG_SLOT_BLOB_CRC) ==
             rg_crc32(0, slot + RG_SLOT_HEADER_SIZE, blob_size);
}

rg_status rg_select_slot(const void* first, const void* second,
                         uint32_t slot_size, rg_slot* newest) {
  const uint8_t* chosen = 0;
  if (((uintptr_t)first | (uintptr_t)second) % 4 != 0) return RG_ERR_MISALIGNED;
  if (!newest || slot_size <= RG_SLOT_HEADER_SIZE) return RG_ERR_ARGUMENT;
  for (uint32_t index = 0; index < 2; ++index) {
    const uint8_t* const slot = (const uint8_t*)(index == 0 ? first : second);
    if (!slot || !is_whole(slot, slot_size)) continue;
    /* Sequence numbers wrap around: the later one is less than 2^31 ahead. */
    if (chosen && rg_load_u32(slot + RG_SLOT_SEQUENCE) -
                          rg_load_u32(chosen + RG_SLOT_SEQUENCE) - 1 >=
                      0x7fffffffu)
      continue;
    chosen = slot;
    newest->index = index;
  }
  if (!chosen) return RG_ERR_NO_SLOT;
  newest->blob = chosen + RG_SLOT_HEADER_SIZE;
  newest->num_bytes = rg_load_u32(chosen + RG_SLOT_BLOB_SIZE);
  newest->sequence = rg_load_u32(chosen + RG_SLOT_SEQUENCE);
  return RG_OK;
}

rg_status rg_make_slot_header(const void* blob, uint32_t num_bytes,
                              uint32_t sequence, uint32_t header[16]) {
  if (!blob || !header || num_bytes == 0) return RG_ERR_ARGUMENT;
  uint8_t* const bytes = (uint8_t*)header;
  for (uint32_t k = 0; k < RG_SLOT_HEADER_SIZE / 4; ++k) {
    RG_IN_REGISTER(k); /* otherwise compilers call memset() */
    header[k] = 0;
  }
  rg_store_u32(bytes + RG_SLOT_MAGIC, MAGIC_0);
  rg_store_u32(bytes + RG_SLOT_MAGIC + 4, MAGIC_1);
  rg_store_u32(bytes + RG_SLOT_MAJOR, MAJOR_AND_SIZE);
  rg_store_u32(bytes + RG_SLOT_SEQUENCE, sequence);
  rg_store_u32(bytes + RG_SLOT_BLOB_SIZE, num_bytes);
  rg_store_u32(bytes + RG_SLOT_BLOB_CRC,
               rg_crc32(0, (const uint8_t*)blob, num_bytes));
  rg_store_u32(bytes + RG_SLOT_HEADER_CRC,
               rg_crc32(0, bytes, RG_SLOT_HEADER_CRC));
  return RG_OK;
}
