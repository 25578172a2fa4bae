/* A board for the examples: memory in place of registers, a DMA and a camera
 * that go on where a processor would sleep or wait, and a cache. The program
 * of a test includes this first, then the example. */
#ifndef RAYGRID_MOCK_BOARD_H
#define RAYGRID_MOCK_BOARD_H

#include <stdint.h>
#include <string.h>

#include "unit_test.h"

#define BOARD_IS_MOCK
#define REGISTERS(type, address) ((type*)(void*)mock_registers(address))
#define POLL() mock_poll()
/* Declared where there is such a register. */
#define WRITE_FIFO(fifo, value) mock_write_fifo(&(fifo), value)

/* ---- Registers ---------------------------------------------------------- */

static struct {
  uint32_t address;
  uint32_t words[1024];
} mock_blocks[12];

/* The block of 4 KiB that has the address, and the place in it. */
static inline uint32_t* mock_registers(uint32_t address) {
  uint32_t k = 0;
  while (mock_blocks[k].address != (address & ~0xfffu) &&
         mock_blocks[k].address != 0) {
    ++k;
    assert_true(k < sizeof(mock_blocks) / sizeof(mock_blocks[0]));
  }
  mock_blocks[k].address = address & ~0xfffu;
  return &mock_blocks[k].words[(address & 0xfffu) / 4];
}

/* Each board has one: the event that a loop waits for happens. */
static void mock_poll(void);

/* ---- Memory and cache --------------------------------------------------- */

/* The cache holds every line: what the processor reads and writes is not in
 * memory, which the DMA reads and writes, until a line is cleaned or becomes
 * invalid. Without a cache both are one. */
#define LINE 32u
#define MOCK_MEMORY 49152u

typedef struct mock_region {
  uint8_t* cached; /* a buffer of the example */
  uint32_t num_bytes;
  uint8_t memory[MOCK_MEMORY];
  uint8_t is_dirty[MOCK_MEMORY / LINE];
} mock_region;

static struct {
  int has_cache;
  int ignores_invalidate, ignores_first_invalidate, ignores_clean;
  mock_region ring, out;
} mock_memory;

/* Start-up code has written zeros, which are still in the cache. */
static inline void mock_start_memory(int has_cache, uint8_t* ring,
                                     uint32_t ring_bytes, uint8_t* out,
                                     uint32_t out_bytes) {
  memset(&mock_memory, 0, sizeof(mock_memory));
  mock_memory.has_cache = has_cache;
  mock_memory.ring.cached = ring;
  mock_memory.ring.num_bytes = ring_bytes;
  mock_memory.out.cached = out;
  mock_memory.out.num_bytes = out_bytes;
  assert_true(ring_bytes <= MOCK_MEMORY && out_bytes <= MOCK_MEMORY);
  memset(mock_memory.ring.is_dirty, 1, sizeof(mock_memory.ring.is_dirty));
  memset(ring, 0, ring_bytes);
  memset(out, 0, out_bytes);
}

/* The place in a region of an address that a register has. */
static inline uint32_t mock_offset(const mock_region* region, uint32_t address,
                                   uint32_t num_bytes) {
  const uint32_t offset = address - (uint32_t)(uintptr_t)region->cached;
  assert_true(offset <= region->num_bytes &&
              num_bytes <= region->num_bytes - offset);
  return offset;
}

/* A dirty line is written back over what the DMA has brought. */
static inline void mock_dma_write(uint32_t address, const uint8_t* bytes,
                                  uint32_t num_bytes) {
  mock_region* const ring = &mock_memory.ring;
  const uint32_t offset = mock_offset(ring, address, num_bytes);
  if (!mock_memory.has_cache) {
    memcpy(ring->cached + offset, bytes, num_bytes);
    return;
  }
  memcpy(ring->memory + offset, bytes, num_bytes);
  for (uint32_t k = offset; k < offset + num_bytes; k += LINE)
    if (ring->is_dirty[k / LINE])
      memcpy(ring->memory + k, ring->cached + k, LINE);
}

static inline void mock_dma_read(uint32_t address, uint8_t* bytes,
                                 uint32_t num_bytes) {
  const mock_region* const out = &mock_memory.out;
  const uint32_t offset = mock_offset(out, address, num_bytes);
  memcpy(bytes, (mock_memory.has_cache ? out->memory : out->cached) + offset,
         num_bytes);
}

static inline void mock_invalidate_line(uint32_t address) {
  mock_region* const ring = &mock_memory.ring;
  const uint32_t offset = mock_offset(ring, address, LINE);
  assert_int_equal(offset % LINE, 0);
  if (mock_memory.ignores_invalidate) return;
  if (mock_memory.ignores_first_invalidate &&
      ring->is_dirty[offset / LINE] == 1) {
    ring->is_dirty[offset / LINE] = 2;
    return;
  }
  ring->is_dirty[offset / LINE] = 0;
  memcpy(ring->cached + offset, ring->memory + offset, LINE);
}

static inline void mock_clean_line(uint32_t address) {
  mock_region* const out = &mock_memory.out;
  const uint32_t offset = mock_offset(out, address, LINE);
  assert_int_equal(offset % LINE, 0);
  if (mock_memory.ignores_clean) return;
  memcpy(out->memory + offset, out->cached + offset, LINE);
}

/* ---- Camera and interrupts ---------------------------------------------- */

static struct {
  const uint8_t* frame;
  uint32_t band_bytes, num_bands;
  uint32_t band;          /* the DMA's next one */
  uint32_t num_at_once;   /* bands for each sleep */
  int never_gives_slots;  /* the DMA stays with its first addresses */
  int is_held, has_slept; /* interrupts; the processor */
} mock_camera;

/* Each board has one: brings a band, and calls the interrupt's handler. */
static void mock_bring_band(const uint8_t* band);

static inline uint32_t hold_interrupts(void) {
  assert_false(mock_camera.is_held);
  mock_camera.is_held = 1;
  return 0;
}

/* Asleep for ever where no band is left. */
static inline void wait_for_interrupt(void) {
  assert_true(mock_camera.is_held);
  assert_true(mock_camera.band < mock_camera.num_bands);
  mock_camera.has_slept = 1;
}

static inline void release_interrupts(uint32_t state) {
  assert_true(mock_camera.is_held && state == 0);
  mock_camera.is_held = 0;
  if (!mock_camera.has_slept) return;
  mock_camera.has_slept = 0;
  for (uint32_t k = 0;
       k < mock_camera.num_at_once && mock_camera.band < mock_camera.num_bands;
       ++k) {
    const uint32_t band = mock_camera.band++;
    mock_bring_band(mock_camera.frame + band * mock_camera.band_bytes);
  }
}

static inline void wait_for_memory(void) {}

/* ---- What was sent ------------------------------------------------------ */

static struct {
  uint32_t num_bytes;
  uint8_t bytes[8192];
} mock_sent;

static inline uint8_t* mock_send(uint32_t num_bytes) {
  uint8_t* const bytes = mock_sent.bytes + mock_sent.num_bytes;
  mock_sent.num_bytes += num_bytes;
  assert_true(mock_sent.num_bytes <= sizeof(mock_sent.bytes));
  return bytes;
}

#endif /* RAYGRID_MOCK_BOARD_H */
