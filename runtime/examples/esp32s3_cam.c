/* ESP32-S3: a sensor on the camera port with 320 x 240 YUYV frames, which are
 * undistorted while they are received, and sent to UART0. A component of
 * ESP-IDF, which calls app_main().
 *
 * The GDMA uses a circular list of descriptors, one per slot, and interrupts
 * after each.
 *
 * The task occupies its core permanently, so the watchdog must not monitor the
 * core's idle task (CONFIG_ESP_TASK_WDT_CHECK_IDLE_TASK_CPU0). No driver of
 * ESP-IDF may use channel 0 of the GDMA.
 *
 * To be configured before: the sensor via its control bus, its clock, UART0's
 * baud rate. Buffers are in internal memory, which is not cached; with ring or
 * out in PSRAM, board_invalidate() and board_clean() must call
 * esp_cache_msync(). */
#include "dma_stream.h"
#include "esp32s3_registers.h"

#define WIDTH 320u
#define HEIGHT 240u
#define BAND_ROWS_LOG2 2u /* 4 rows: a descriptor holds at most 4095 bytes */
#define NUM_SLOTS_LOG2 4u /* 64 rows of the sensor: 40,960 bytes */
#define NUM_SLOTS (1u << NUM_SLOTS_LOG2)
#define BAND_BYTES ((WIDTH * 2u) << BAND_ROWS_LOG2)
#define OUT_ROWS 2u

static uint8_t ring[BAND_BYTES << NUM_SLOTS_LOG2] __attribute__((aligned(4)));
static uint8_t out[2][OUT_ROWS * WIDTH * 2u] __attribute__((aligned(4)));
static gdma_descriptor descriptors[NUM_SLOTS];

static dma_stream stream = {.format = RG_FORMAT_YUYV,
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

/* GPIOs of D0 to D7, pixel clock, line valid and frame valid. */
static const uint8_t kPins[] = {11, 9, 8, 10, 12, 18, 17, 16, 13, 7, 6};
static const uint8_t kSignals[] = {
    CAM_DATA_IN0_IDX,      CAM_DATA_IN0_IDX + 1u, CAM_DATA_IN0_IDX + 2u,
    CAM_DATA_IN0_IDX + 3u, CAM_DATA_IN0_IDX + 4u, CAM_DATA_IN0_IDX + 5u,
    CAM_DATA_IN0_IDX + 6u, CAM_DATA_IN0_IDX + 7u, CAM_PCLK_IDX,
    CAM_H_ENABLE_IDX,      CAM_V_SYNC_IDX};

static void gdma_done(void* argument);

rg_status camera_init(void) {
  SYSTEM->PERIP_CLK_EN1 |= SYSTEM_DMA | SYSTEM_LCD_CAM;
  SYSTEM->PERIP_RST_EN1 &= ~(SYSTEM_DMA | SYSTEM_LCD_CAM);
  for (uint32_t k = 0; k < sizeof(kPins); ++k) {
    IO_MUX->PIN[kPins[k]] = IO_MUX_FUN_IE | IO_MUX_MCU_SEL_GPIO;
    GPIO->FUNC_IN_SEL_CFG[kSignals[k]] = GPIO_SIG_IN_SEL | kPins[k];
  }
  /* 8 bits per clock; frames are delimited by VSYNC. */
  LCD_CAM->CAM_CTRL =
      CAM_CTRL_CLK_SEL_160M | CAM_CTRL_CLKM_DIV_NUM(8) | CAM_CTRL_VS_EOF_EN;
  LCD_CAM->CAM_CTRL1 = CAM_CTRL1_VSYNC_FILTER_EN;
  LCD_CAM->CAM_RGB_YUV = 0;

  for (uint32_t k = 0; k < NUM_SLOTS; ++k) {
    descriptors[k].buffer = address_of(dma_stream_slot(&stream, k));
    descriptors[k].next = address_of(&descriptors[(k + 1u) % NUM_SLOTS]);
  }
  GDMA_IN0->CONF1 = 0; /* no owner check: the ring runs indefinitely */
  GDMA_IN0->PERI_SEL = GDMA_PERI_LCD_CAM;
  GDMA_IN0->INT_CLR = GDMA_IN_DONE | GDMA_IN_ERRORS;
  GDMA_IN0->INT_ENA = GDMA_IN_DONE | GDMA_IN_ERRORS;
  return esp_intr_alloc(ETS_DMA_IN_CH0_INTR_SOURCE, ESP_INTR_FLAG_LEVEL3,
                        gdma_done, 0, 0) == 0
             ? RG_OK
             : RG_ERR_ARGUMENT;
}

/* ---- A frame ------------------------------------------------------------ */

static void start_frame(void) {
  LCD_CAM->CAM_CTRL1 &= ~CAM_CTRL1_START;
  GDMA_IN0->LINK = GDMA_INLINK_STOP;
  GDMA_IN0->CONF0 |= GDMA_IN_RST;
  GDMA_IN0->CONF0 &= ~GDMA_IN_RST;
  GDMA_IN0->INT_CLR = GDMA_IN_DONE | GDMA_IN_ERRORS;
  dma_stream_begin(&stream);
  for (uint32_t k = 0; k < NUM_SLOTS; ++k)
    descriptors[k].DW0 = GDMA_DW0_OWNER_DMA | BAND_BYTES;
  wait_for_memory();
  GDMA_IN0->LINK = (address_of(descriptors) & 0xfffffu) | GDMA_INLINK_START;
  LCD_CAM->CAM_CTRL1 |= CAM_CTRL1_RESET | CAM_CTRL1_AFIFO_RESET;
  LCD_CAM->CAM_CTRL1 &= ~(CAM_CTRL1_RESET | CAM_CTRL1_AFIFO_RESET);
  LCD_CAM->CAM_CTRL |= CAM_CTRL_UPDATE;
  LCD_CAM->LC_DMA_INT_CLR = CAM_VSYNC_INT;
  while (!(LCD_CAM->LC_DMA_INT_RAW & CAM_VSYNC_INT)) POLL();
  LCD_CAM->CAM_CTRL1 |= CAM_CTRL1_START; /* before the frame's first line */
}

static void gdma_done(void* argument) {
  (void)argument;
  const uint32_t flags = GDMA_IN0->INT_ST;
  GDMA_IN0->INT_CLR = flags;
  if (flags & GDMA_IN_ERRORS) dma_stream_fail(&stream);
  if (!(flags & GDMA_IN_DONE)) return;
  /* The GDMA passes a full descriptor to the processor, which returns it. If
   * the next one is also full, the interrupt was too late. */
  const uint32_t slot = stream.num_filled % NUM_SLOTS;
  if (descriptors[slot].DW0 & GDMA_DW0_OWNER_DMA) dma_stream_fail(&stream);
  if (!(descriptors[(slot + 1u) % NUM_SLOTS].DW0 & GDMA_DW0_OWNER_DMA))
    dma_stream_fail(&stream);
  descriptors[slot].DW0 = GDMA_DW0_OWNER_DMA | BAND_BYTES;
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

void board_invalidate(const void* begin, uint32_t num_bytes) {
  (void)begin, (void)num_bytes;
  wait_for_memory();
}

void board_clean(const void* begin, uint32_t num_bytes) {
  (void)begin, (void)num_bytes;
  wait_for_memory();
}

/* Sent by the processor: returns when the last bytes are in the FIFO. */
void board_send(const uint8_t* bytes, uint32_t num_bytes) {
  for (uint32_t k = 0; k < num_bytes; ++k) {
    while (UART_TXFIFO_CNT(UART0->STATUS) >= UART_TXFIFO_SIZE) POLL();
    WRITE_FIFO(UART0->FIFO, bytes[k]);
  }
}

/* ---- The program -------------------------------------------------------- */

/* The array written by raygrid export front.raygrid --to c -o front.h, and its
 * size. */
extern const uint8_t camera_blob[];
extern const uint32_t camera_blob_bytes;

void app_main(void);
void app_main(void) {
  rg_camera camera;
  rg_status status = rg_camera_open(&camera, camera_blob, camera_blob_bytes);
  if (status == RG_OK) status = rg_select_remap(&camera, 0);
  if (status == RG_OK) status = dma_stream_check(&stream, &camera);
  if (status == RG_OK) status = camera_init();
  while (status == RG_OK) camera_frame(&camera); /* may be truncated */
}
