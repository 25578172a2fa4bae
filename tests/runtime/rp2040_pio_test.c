/* The example runtime/examples/rp2040_pio.c on a mock of the DMA's channels,
 * with the program of its state machine run on pins. */
#include "mock_board.h"
#define main example_main
#include "rp2040_pio.c"
#undef main

/* The frame as the host undistorts it. */
#define BOARD_CRC 0x9ec25062u
#define BOARD_HAS_CACHE 0

const uint8_t camera_blob[] = {0};
const uint32_t camera_blob_bytes = 0;
static uint32_t fail_at_band = UINT32_MAX, lose_at_band = UINT32_MAX;
static uint32_t first_slots[2];

static void start_registers(void) { RESETS->RESET_DONE = UINT32_MAX; }

/* SPI0 takes what it was given. */
static void mock_poll(void) {
  dma_channel_registers* const dma = &DMA->CH[OUTPUT];
  if (dma->TRANS_COUNT == 0) return;
  assert_true(dma->CTRL_TRIG & DMA_CTRL_EN);
  assert_int_equal(dma->WRITE_ADDR, address_of(&SPI0->SSPDR));
  mock_dma_read(dma->READ_ADDR, mock_send(dma->TRANS_COUNT), dma->TRANS_COUNT);
  dma->TRANS_COUNT = 0;
}

static void mock_bring_band(const uint8_t* band) {
  const uint32_t number = mock_camera.band - 1, channel = number & 1;
  dma_channel_registers* const dma = &DMA->CH[channel];
  assert_true(PIO0->CTRL & PIO_CTRL_SM0_ENABLE);
  assert_int_equal(dma->READ_ADDR, address_of(&PIO0->RXF[0]));
  assert_int_equal(dma->TRANS_COUNT * 4, BAND_BYTES);
  /* The channel starts the other one. */
  const uint32_t control = number == 0 ? dma->CTRL_TRIG : dma->AL1_CTRL;
  assert_true(control & DMA_CTRL_EN);
  assert_int_equal(control >> 11 & 15, channel ^ 1);
  dma->AL1_CTRL = control;
  if (number < 2) first_slots[channel] = dma->WRITE_ADDR;
  mock_dma_write(
      mock_camera.never_gives_slots ? first_slots[channel] : dma->WRITE_ADDR,
      band, BAND_BYTES);
  dma->WRITE_ADDR += BAND_BYTES; /* it has counted up */
  if (number == lose_at_band) return;
  if (number == fail_at_band) dma->AL1_CTRL |= 1u << 30;
  DMA->INTS0 = 1u << channel;
  isr_irq11();
}

#include "board_frames.h"

/* ---- The state machine -------------------------------------------------- */

/* One instruction; 1 if it took the pins. */
static int step(uint32_t pins, uint32_t* counter) {
  const uint32_t instruction = PIO0->INSTR_MEM[*counter];
  const uint32_t top = PIO0->SM[0].EXECCTRL >> 12 & 31;
  const uint32_t bottom = PIO0->SM[0].EXECCTRL >> 7 & 31;
  const int takes = instruction >> 13 == 2; /* IN */
  if (takes)
    assert_int_equal(instruction & 0xff, 8); /* of pins */
  else
    assert_int_equal(instruction >> 13, 1); /* WAIT */
  if (!takes && (instruction >> 7 & 1) != (pins >> (instruction & 31) & 1))
    return 0;
  *counter = *counter == top ? bottom : *counter + 1;
  return takes;
}

/* Eight instructions for each level of the clock. */
static uint32_t run_levels(uint32_t pins, uint32_t* counter, uint32_t* taken) {
  uint32_t num_taken = 0;
  for (int k = 0; k < 8; ++k)
    if (step(pins, counter)) {
      *taken = pins & 0xff;
      ++num_taken;
    }
  return num_taken;
}

static void program_takes_each_pixel_once(void** state) {
  (void)state;
  uint32_t counter = 0, taken = 0, num_taken = 0;
  /* In the middle of a frame: nothing. */
  for (uint32_t k = 0; k < 50; ++k)
    num_taken +=
        run_levels(1u << 10 | 1u << 9 | (k & 1) << 8, &counter, &taken);
  num_taken += run_levels(0, &counter, &taken);
  assert_int_equal(num_taken, 0);
  for (uint32_t line = 0; line < 3; ++line) {
    num_taken = run_levels(1u << 10, &counter, &taken);
    for (uint32_t x = 0; x < 20; ++x) {
      const uint32_t pins = 1u << 10 | 1u << 9 | (7 * x + line);
      num_taken += run_levels(pins, &counter, &taken);
      num_taken += run_levels(pins | 1u << 8, &counter, &taken);
      assert_int_equal(num_taken, x + 1);
      assert_int_equal(taken, 7 * x + line);
    }
    run_levels(1u << 10, &counter, &taken); /* the clock goes low, too */
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup(program_takes_each_pixel_once, start_board)};
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  return test_board() + failed;
}
