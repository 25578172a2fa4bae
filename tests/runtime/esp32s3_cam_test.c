/* The example runtime/examples/esp32s3_cam.c on a mock of the GDMA and its
 * descriptors. */
#include "mock_board.h"

static void mock_write_fifo(volatile uint32_t* fifo, uint32_t value);

#include "esp32s3_cam.c"

/* The frame as the host undistorts it. */
#define BOARD_CRC 0x5829bb30u
#define BOARD_HAS_CACHE 0

const uint8_t camera_blob[] = {0};
const uint32_t camera_blob_bytes = 0;
static uint32_t fail_at_band = UINT32_MAX, lose_at_band = UINT32_MAX;
static void (*handler)(void*);

int esp_intr_alloc(int source, int flags, void (*call)(void*), void* argument,
                   void** handle) {
  assert_int_equal(source, 66);
  assert_true(flags != 0 && !argument && !handle);
  handler = call;
  return 0;
}

static void start_registers(void) { LCD_CAM->LC_DMA_INT_RAW = CAM_VSYNC_INT; }

static void mock_poll(void) {}

static void mock_write_fifo(volatile uint32_t* fifo, uint32_t value) {
  assert_true(fifo == &UART0->FIFO);
  *mock_send(1) = (uint8_t)value;
}

static void mock_bring_band(const uint8_t* band) {
  const uint32_t number = mock_camera.band - 1;
  assert_true(LCD_CAM->CAM_CTRL1 & CAM_CTRL1_START);
  assert_true(GDMA_IN0->LINK & GDMA_INLINK_START);
  assert_int_equal(GDMA_IN0->LINK & 0xfffff, address_of(descriptors) & 0xfffff);
  /* Along the list, from its first descriptor. */
  const gdma_descriptor* at = descriptors;
  uint32_t steps = mock_camera.never_gives_slots ? number & 1 : number;
  while (steps-- > 0)
    at = descriptors + (at->next - address_of(descriptors)) / sizeof(*at);
  gdma_descriptor* const descriptor = descriptors + (at - descriptors);
  assert_int_equal(descriptor->DW0 & 0xfff, BAND_BYTES);
  mock_dma_write(descriptor->buffer, band, BAND_BYTES);
  /* Full, and the processor's, by the position of the band: the mutant's
   * descriptors are the right ones, too. */
  descriptors[number % NUM_SLOTS].DW0 =
      (BAND_BYTES << 12 | BAND_BYTES) & ~GDMA_DW0_OWNER_DMA;
  if (number == lose_at_band) return;
  GDMA_IN0->INT_ST = GDMA_IN_DONE | (number == fail_at_band ? 1u << 3 : 0);
  handler(0);
  assert_int_equal(GDMA_IN0->INT_CLR, GDMA_IN0->INT_ST);
}

#include "board_frames.h"

int main(void) { return test_board(); }
