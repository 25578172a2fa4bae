/* RP2040: a grey sensor with 8 parallel pins, such as the HM01B0, with 320 x
 * 240 frames, which are undistorted while they are received, and sent to SPI0.
 *
 * A state machine of PIO0 reads a byte at each pixel clock. Two chained DMA
 * channels transfer bands alternately. The interrupt handler sets the address
 * of the completed channel to the slot after the next.
 *
 * Pins: D0 to D7 at GPIO 0 to 7, pixel clock 8, line valid 9, frame valid 10;
 * SPI0 at 18 (clock) and 19 (data). The system clock must be at least eight
 * times the pixel clock. To be configured before: clocks, and the sensor via
 * its control bus. The RP2040's memory is not cached. */
#include "dma_stream.h"
#include "rp2040_registers.h"

#define WIDTH 320u
#define HEIGHT 240u
#define BAND_ROWS_LOG2 2u /* 4 rows */
#define NUM_SLOTS_LOG2 4u /* 64 rows of the sensor: 20,480 bytes */
#define BAND_BYTES (WIDTH << BAND_ROWS_LOG2)
#define OUT_ROWS 2u
#define PIN_CLOCK 8u
#define PIN_LINE 9u
#define PIN_FRAME 10u

/* DMA channels. */
#define EVEN_BANDS 0u
#define ODD_BANDS 1u
#define OUTPUT 2u

static uint8_t ring[BAND_BYTES << NUM_SLOTS_LOG2] __attribute__((aligned(4)));
static uint8_t out[2][OUT_ROWS * WIDTH] __attribute__((aligned(4)));

static dma_stream stream = {.format = RG_FORMAT_GREY8,
                            .width = WIDTH,
                            .height = HEIGHT,
                            .pixel_bytes = 1,
                            .band_rows_log2 = BAND_ROWS_LOG2,
                            .num_slots_log2 = NUM_SLOTS_LOG2,
                            .out_rows = OUT_ROWS,
                            .ring = ring,
                            .out = {out[0], out[1]}};

static uint32_t address_of(const volatile void* object) {
  return (uint32_t)(uintptr_t)object;
}

/* ---- Pins and peripherals ----------------------------------------------- */

/* Waits for the start of a frame, then reads 8 pins at each pixel clock of a
 * line. */
#define FIRST_OF_LOOP 2u
static const uint16_t kProgram[] = {PIO_WAIT_GPIO(0u, PIN_FRAME),
                                    PIO_WAIT_GPIO(1u, PIN_FRAME),
                                    PIO_WAIT_GPIO(1u, PIN_LINE),
                                    PIO_WAIT_GPIO(1u, PIN_CLOCK),
                                    PIO_IN_PINS(8u),
                                    PIO_WAIT_GPIO(0u, PIN_CLOCK)};
#define PROGRAM_LENGTH (sizeof(kProgram) / sizeof(kProgram[0]))

void camera_init(void) {
  const uint32_t used = RESETS_DMA | RESETS_IO_BANK0 | RESETS_PADS_BANK0 |
                        RESETS_PIO0 | RESETS_SPI0;
  RESETS_CLEAR->RESET = used;
  while ((RESETS->RESET_DONE & used) != used) POLL();
  for (uint32_t pin = 0; pin <= PIN_FRAME; ++pin)
    IO_BANK0->GPIO[pin].CTRL = FUNCSEL_PIO0;
  IO_BANK0->GPIO[18].CTRL = FUNCSEL_SPI;
  IO_BANK0->GPIO[19].CTRL = FUNCSEL_SPI;

  /* Words of four pixels, the first in the low byte; the first pin is GPIO 0.
   */
  for (uint32_t k = 0; k < PROGRAM_LENGTH; ++k)
    PIO0->INSTR_MEM[k] = kProgram[k];
  PIO0->SM[0].CLKDIV = 1u << 16;
  PIO0->SM[0].EXECCTRL = PIO_EXECCTRL_WRAP(FIRST_OF_LOOP, PROGRAM_LENGTH - 1u);
  PIO0->SM[0].SHIFTCTRL =
      PIO_SHIFTCTRL_AUTOPUSH | PIO_SHIFTCTRL_IN_RIGHT | PIO_SHIFTCTRL_FJOIN_RX;
  PIO0->SM[0].PINCTRL = 0;

  SPI0->SSPCPSR = 2;
  SPI0->SSPCR0 = SPI_CR0_8_BITS;
  SPI0->SSPDMACR = SPI_DMACR_TXDMAE;
  SPI0->SSPCR1 = SPI_CR1_SSE;

  DMA->INTE0 = 1u << EVEN_BANDS | 1u << ODD_BANDS;
  NVIC->ISER[0] = 1u << DMA_IRQ_0;
}

/* ---- A frame ------------------------------------------------------------ */

static uint32_t band_control(uint32_t next_channel) {
  return DMA_CTRL_EN | DMA_CTRL_WORDS | DMA_CTRL_INCR_WRITE |
         DMA_CTRL_CHAIN_TO(next_channel) | DMA_CTRL_TREQ(DREQ_PIO0_RX0);
}

static void prepare_channel(uint32_t channel) {
  dma_channel_registers* const dma = &DMA->CH[channel];
  dma->READ_ADDR = address_of(&PIO0->RXF[0]);
  dma->WRITE_ADDR = address_of(dma_stream_slot(&stream, channel));
  dma->TRANS_COUNT = BAND_BYTES / 4u; /* of each transfer */
}

static void start_frame(void) {
  const uint32_t both = 1u << EVEN_BANDS | 1u << ODD_BANDS;
  PIO0->CTRL = 0;
  /* Channels are disabled before they are aborted: an abort would otherwise
   * trigger the chained channel. The abort must not cause an interrupt. */
  DMA->INTE0 = 0;
  DMA->CH[EVEN_BANDS].AL1_CTRL = 0;
  DMA->CH[ODD_BANDS].AL1_CTRL = 0;
  DMA->CHAN_ABORT = both;
  while ((DMA->CH[EVEN_BANDS].AL1_CTRL | DMA->CH[ODD_BANDS].AL1_CTRL) &
         DMA_CTRL_BUSY)
    POLL();
  DMA->INTS0 = both;
  DMA->INTE0 = both;
  dma_stream_begin(&stream);
  prepare_channel(EVEN_BANDS);
  prepare_channel(ODD_BANDS);
  DMA->CH[ODD_BANDS].AL1_CTRL = band_control(EVEN_BANDS); /* does not trigger */
  DMA->CH[EVEN_BANDS].CTRL_TRIG = band_control(ODD_BANDS);

  /* Changing the FIFO's join mode clears it; the program restarts at its first
   * instruction. */
  PIO0->SM[0].SHIFTCTRL = PIO_SHIFTCTRL_AUTOPUSH | PIO_SHIFTCTRL_IN_RIGHT;
  PIO0->SM[0].SHIFTCTRL =
      PIO_SHIFTCTRL_AUTOPUSH | PIO_SHIFTCTRL_IN_RIGHT | PIO_SHIFTCTRL_FJOIN_RX;
  PIO0->CTRL = PIO_CTRL_SM0_RESTART;
  PIO0->SM[0].INSTR = PIO_JMP(0u);
  PIO0->CTRL = PIO_CTRL_SM0_ENABLE;
}

/* DMA_IRQ_0, by its name in the SDK's vector table. */
void isr_irq11(void) {
  const uint32_t flags = DMA->INTS0;
  DMA->INTS0 = flags;
  /* Band n is full: the channel of even bands, or that of odd ones, has
   * completed. If both flags are set, the interrupt was too late. */
  const uint32_t channel = stream.num_filled & 1u;
  if (flags != 1u << channel) dma_stream_fail(&stream);
  if (DMA->CH[channel].AL1_CTRL & DMA_CTRL_ERRORS) dma_stream_fail(&stream);
  /* The other channel has already been triggered by this one. */
  DMA->CH[channel].WRITE_ADDR =
      address_of(dma_stream_slot(&stream, stream.num_filled + 2u));
  dma_stream_filled(&stream);
}

rg_status camera_frame(const rg_camera* camera) {
  start_frame();
  return dma_stream_undistort(&stream, camera);
}

/* ---- Functions called by dma_stream.c ------------------------------------ */

uint32_t board_lock(void) { return hold_interrupts(); }
void board_unlock(uint32_t state) { release_interrupts(state); }
void board_sleep(void) { wait_for_interrupt(); }

/* There is no cache, but pending writes must have completed. */
void board_invalidate(const void* begin, uint32_t num_bytes) {
  (void)begin, (void)num_bytes;
  wait_for_memory();
}

void board_clean(const void* begin, uint32_t num_bytes) {
  (void)begin, (void)num_bytes;
  wait_for_memory();
}

void board_send(const uint8_t* bytes, uint32_t num_bytes) {
  dma_channel_registers* const dma = &DMA->CH[OUTPUT];
  while (dma->TRANS_COUNT != 0) POLL(); /* waits for the previous transfer */
  dma->READ_ADDR = address_of(bytes);
  dma->WRITE_ADDR = address_of(&SPI0->SSPDR);
  dma->TRANS_COUNT = num_bytes;
  /* Chaining a channel to itself disables chaining. */
  dma->CTRL_TRIG = DMA_CTRL_EN | DMA_CTRL_INCR_READ |
                   DMA_CTRL_CHAIN_TO(OUTPUT) | DMA_CTRL_TREQ(DREQ_SPI0_TX);
}

/* ---- The program -------------------------------------------------------- */

/* The array written by raygrid export front.raygrid --to c -o front.h, and its
 * size. */
extern const uint8_t camera_blob[];
extern const uint32_t camera_blob_bytes;

int main(void) {
  rg_camera camera;
  rg_status status = rg_camera_open(&camera, camera_blob, camera_blob_bytes);
  if (status == RG_OK) status = rg_select_remap(&camera, 0);
  if (status == RG_OK) status = dma_stream_check(&stream, &camera);
  if (status != RG_OK) return (int)status;
  camera_init();
  for (;;) camera_frame(&camera); /* may be truncated */
}
