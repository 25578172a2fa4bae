/* The example runtime/examples/stm32h7_dcmi.c on a mock of the DCMI, its DMA
 * and the data cache. */
#include "mock_board.h"

static void mock_write_fifo(volatile uint32_t* fifo, uint32_t value);

#define main example_main
#include "stm32h7_dcmi.c"
#undef main

/* The frame as the host undistorts it. */
#define BOARD_CRC 0xd1ca2ddfu
#define BOARD_HAS_CACHE 1

const uint8_t camera_blob[] = {0};
const uint32_t camera_blob_bytes = 0;
static uint32_t fail_at_band = UINT32_MAX, lose_at_band = UINT32_MAX;
static uint32_t first_slots[2];

static void start_registers(void) {}

/* The frame ends the capture; SPI1 takes what it was given. */
static void mock_poll(void) {
  dma_stream_registers* const dma = &DMA1->S[1];
  if (mock_camera.band % mock_camera.num_bands == 0)
    DCMI->CR &= ~DCMI_CR_CAPTURE;
  if (!(dma->CR & DMA_CR_EN)) return;
  assert_int_equal(dma->PAR, address_of(&SPI1->TXDR));
  assert_true(SPI1->CR1 & SPI_CR1_CSTART);
  mock_dma_read(dma->M0AR, mock_send(2 * dma->NDTR), 2 * dma->NDTR);
  dma->CR &= ~DMA_CR_EN;
}

static void mock_write_fifo(volatile uint32_t* fifo, uint32_t value) {
  if (fifo == &CACHE->DCIMVAC)
    mock_invalidate_line(value);
  else if (fifo == &CACHE->DCCMVAC)
    mock_clean_line(value);
  else
    fail();
}

static void mock_bring_band(const uint8_t* band) {
  dma_stream_registers* const dma = &DMA1->S[0];
  assert_true(DCMI->CR & DCMI_CR_CAPTURE && DCMI->CR & DCMI_CR_ENABLE);
  assert_true(dma->CR & DMA_CR_EN && dma->CR & DMA_CR_DBM);
  assert_int_equal(dma->NDTR * 4, BAND_BYTES);
  assert_int_equal(DMAMUX1->CCR[0], 75);
  assert_int_equal(dma->PAR, address_of(&DCMI->DR));
  const uint32_t is_second = (dma->CR & DMA_CR_CT) != 0;
  const uint32_t number = mock_camera.band - 1;
  if (number < 2) first_slots[number] = is_second ? dma->M1AR : dma->M0AR;
  mock_dma_write(mock_camera.never_gives_slots ? first_slots[is_second]
                 : is_second                   ? dma->M1AR
                                               : dma->M0AR,
                 band, BAND_BYTES);
  dma->CR ^= DMA_CR_CT;
  if (number == lose_at_band) return;
  DMA1->LISR = DMA_LISR_TCIF0;
  if (number == fail_at_band && number & 1) DCMI_IRQHandler();
  if (number == fail_at_band && !(number & 1)) DMA1->LISR |= DMA_LISR_TEIF0;
  DMA1_Stream0_IRQHandler();
  assert_int_equal(DMA1->LIFCR, DMA1->LISR);
}

#include "board_frames.h"

int main(void) { return test_board(); }
