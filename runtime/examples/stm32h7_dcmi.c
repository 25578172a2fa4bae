/* STM32H743: a sensor on the DCMI with 320 x 240 RGB565 frames, which are
 * undistorted while they are received, and sent to a display on SPI1.
 *
 * The DCMI's DMA is in double-buffer mode. Each interrupt sets the address of
 * the completed buffer to the slot after the next, so that the two buffers
 * advance through the ring without copying.
 *
 * To be configured before: clocks, the data cache (enabled), the sensor via its
 * control bus and the display by its commands. DMA1 cannot access the DTCM: the
 * linker script must place ring and out in AXI SRAM (0x24000000), which is
 * cached. */
#include "dma_stream.h"
#include "stm32h7_registers.h"

#define WIDTH 320u
#define HEIGHT 240u
#define BAND_ROWS_LOG2 3u /* 8 rows: 1280 words; the DMA's limit is 65535 */
#define NUM_SLOTS_LOG2 3u /* 64 rows of the sensor: 40,960 bytes */
#define BAND_BYTES ((WIDTH * 2u) << BAND_ROWS_LOG2)
#define OUT_ROWS 2u
#define CACHE_LINE 32u

/* Aligned to whole cache lines: otherwise, the processor would write back stale
 * data over DMA data that shares a line with its own variables. */
static uint8_t ring[BAND_BYTES << NUM_SLOTS_LOG2]
    __attribute__((aligned(CACHE_LINE)));
static uint8_t out[2][OUT_ROWS * WIDTH * 2u]
    __attribute__((aligned(CACHE_LINE)));

static dma_stream stream = {.format = RG_FORMAT_RGB565,
                            .width = WIDTH,
                            .height = HEIGHT,
                            .pixel_bytes = 2,
                            .band_rows_log2 = BAND_ROWS_LOG2,
                            .num_slots_log2 = NUM_SLOTS_LOG2,
                            .out_rows = OUT_ROWS,
                            .ring = ring,
                            .out = {out[0], out[1]}};

static uint32_t address_of(const volatile void* object) {
  return (uint32_t)(uintptr_t)object;
}

/* ---- Pins and peripherals ----------------------------------------------- */

typedef struct pin {
  uint8_t port, number, function;
} pin;

static const pin kPins[] = {
    {0, 4, 13},                         /* PA4  DCMI_HSYNC */
    {0, 6, 13},                         /* PA6  DCMI_PIXCLK */
    {1, 7, 13},                         /* PB7  DCMI_VSYNC */
    {2, 6, 13}, {2, 7, 13},             /* PC6, PC7  D0, D1 */
    {4, 0, 13}, {4, 1, 13}, {4, 4, 13}, /* PE0, PE1, PE4  D2 to D4 */
    {3, 3, 13}, {4, 5, 13}, {4, 6, 13}, /* PD3, PE5, PE6  D5 to D7 */
    {1, 3, 5},  {1, 5, 5}};             /* PB3, PB5  SPI1_SCK, SPI1_MOSI */

static void set_pin(const pin* p) {
  gpio_registers* const gpio = GPIO(p->port);
  const uint32_t shift = 4u * (p->number & 7u);
  volatile uint32_t* const function = &gpio->AFR[p->number >> 3];
  *function = (*function & ~(15u << shift)) | (uint32_t)p->function << shift;
  gpio->OSPEEDR |= 3u << (2u * p->number);
  gpio->MODER = (gpio->MODER & ~(3u << (2u * p->number))) |
                2u << (2u * p->number); /* alternate function mode */
}

void camera_init(void) {
  RCC->AHB1ENR |= RCC_AHB1ENR_DMA1EN;
  RCC->AHB2ENR |= RCC_AHB2ENR_DCMIEN;
  RCC->AHB4ENR |= 31u; /* GPIOA to GPIOE */
  RCC->APB2ENR |= RCC_APB2ENR_SPI1EN;
  for (uint32_t k = 0; k < sizeof(kPins) / sizeof(kPins[0]); ++k)
    set_pin(&kPins[k]);

  /* Stream 0 transfers words from the DCMI, stream 1 pixels to SPI1. */
  DMAMUX1->CCR[0] = DMAMUX_DCMI;
  DMAMUX1->CCR[1] = DMAMUX_SPI1_TX;
  DMA1->S[0].PAR = address_of(&DCMI->DR);
  DMA1->S[0].FCR = DMA_FCR_DMDIS | DMA_FCR_FTH_FULL;
  DMA1->S[1].PAR = address_of(&SPI1->TXDR);

  /* Snapshot mode. Pixels are sampled at the clock's rising edge; HSYNC and
   * VSYNC are low during blanking. Otherwise, set DCMI_CR_HSPOL and
   * DCMI_CR_VSPOL. */
  DCMI->IER = DCMI_OVR;
  DCMI->CR = DCMI_CR_CM | DCMI_CR_PCKPOL | DCMI_CR_ENABLE;
  NVIC->ISER[DMA1_STREAM0_IRQ / 32u] = 1u << DMA1_STREAM0_IRQ % 32u;
  NVIC->ISER[DCMI_IRQ / 32u] = 1u << DCMI_IRQ % 32u;

  /* 16-bit frames, most significant bit first, without a transfer size. */
  SPI1->CFG1 = SPI_CFG1_DSIZE_16 | SPI_CFG1_TXDMAEN | SPI_CFG1_MBR_4;
  SPI1->CFG2 =
      SPI_CFG2_COMM_TX | SPI_CFG2_MASTER | SPI_CFG2_SSM | SPI_CFG2_AFCNTR;
  SPI1->CR1 = SPI_CR1_SSI;
  SPI1->CR1 = SPI_CR1_SSI | SPI_CR1_SPE;
  SPI1->CR1 = SPI_CR1_SSI | SPI_CR1_SPE | SPI_CR1_CSTART;
}

/* ---- A frame ------------------------------------------------------------ */

static void start_frame(void) {
  dma_stream_registers* const dma = &DMA1->S[0];
  /* The rest of an aborted frame may still arrive. */
  DCMI->CR &= ~DCMI_CR_CAPTURE;
  while (DCMI->CR & DCMI_CR_CAPTURE) POLL();
  dma->CR &= ~DMA_CR_EN;
  while (dma->CR & DMA_CR_EN) POLL();
  DMA1->LIFCR = DMA_LISR_STREAM0; /* disabling the stream also sets a flag */
  dma_stream_begin(&stream);
  dma->NDTR = BAND_BYTES / 4u;
  dma->M0AR = address_of(dma_stream_slot(&stream, 0));
  dma->M1AR = address_of(dma_stream_slot(&stream, 1));
  dma->CR = DMA_CR_PL_HIGHEST | DMA_CR_DBM | DMA_CR_CIRC | DMA_CR_MINC |
            DMA_CR_PSIZE_32 | DMA_CR_MSIZE_32 | DMA_CR_TCIE | DMA_CR_TEIE;
  dma->CR |= DMA_CR_EN;
  DCMI->ICR = DCMI_OVR;
  DCMI->CR |= DCMI_CR_CAPTURE; /* starts at the next VSYNC */
}

void DMA1_Stream0_IRQHandler(void) {
  const uint32_t flags = DMA1->LISR;
  DMA1->LIFCR = flags & DMA_LISR_STREAM0;
  if (flags & DMA_LISR_TEIF0) dma_stream_fail(&stream);
  if (!(flags & DMA_LISR_TCIF0)) return;
  /* Band n is full, and n + 1 is being written, to M1AR if odd. Otherwise, the
   * interrupt was too late. */
  const uint32_t filling = stream.num_filled + 1;
  const uint32_t is_second = (DMA1->S[0].CR & DMA_CR_CT) != 0;
  if (is_second != (filling & 1u)) dma_stream_fail(&stream);
  /* Only the address of the inactive buffer may be written. */
  const uint32_t slot = address_of(dma_stream_slot(&stream, filling + 1));
  if (is_second)
    DMA1->S[0].M0AR = slot;
  else
    DMA1->S[0].M1AR = slot;
  dma_stream_filled(&stream);
}

/* Overrun: the DMA was slower than the sensor. */
void DCMI_IRQHandler(void) {
  DCMI->ICR = DCMI_OVR;
  dma_stream_fail(&stream);
}

rg_status camera_frame(const rg_camera* camera) {
  start_frame();
  return dma_stream_undistort(&stream, camera);
}

/* ---- Functions called by dma_stream.c ------------------------------------ */

uint32_t board_lock(void) { return hold_interrupts(); }
void board_unlock(uint32_t state) { release_interrupts(state); }
void board_sleep(void) { wait_for_interrupt(); }

/* Line by line. Buffers consist of whole cache lines, so that invalidation does
 * not discard other data. */
void board_invalidate(const void* begin, uint32_t num_bytes) {
  const uint32_t address = address_of(begin);
  wait_for_memory();
  for (uint32_t k = 0; k < num_bytes; k += CACHE_LINE)
    WRITE_FIFO(CACHE->DCIMVAC, address + k);
  wait_for_memory();
}

void board_clean(const void* begin, uint32_t num_bytes) {
  const uint32_t address = address_of(begin);
  wait_for_memory();
  for (uint32_t k = 0; k < num_bytes; k += CACHE_LINE)
    WRITE_FIFO(CACHE->DCCMVAC, address + k);
  wait_for_memory();
}

void board_send(const uint8_t* bytes, uint32_t num_bytes) {
  dma_stream_registers* const dma = &DMA1->S[1];
  while (dma->CR & DMA_CR_EN) POLL(); /* cleared by hardware at the end */
  DMA1->LIFCR = DMA_LISR_STREAM1;
  dma->NDTR = num_bytes / 2u;
  dma->M0AR = address_of(bytes);
  dma->CR = DMA_CR_DIR_TO_PERIPHERAL | DMA_CR_MINC | DMA_CR_PSIZE_16 |
            DMA_CR_MSIZE_16;
  dma->CR |= DMA_CR_EN;
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
