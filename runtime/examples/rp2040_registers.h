/* Registers of the RP2040 that rp2040_pio.c uses, named as in its data sheet.
 */
#ifndef RAYGRID_RP2040_REGISTERS_H
#define RAYGRID_RP2040_REGISTERS_H

#include "processor.h"

typedef struct resets_registers {
  volatile uint32_t RESET, WDSEL, RESET_DONE;
} resets_registers;

typedef struct io_bank_registers {
  struct {
    volatile uint32_t STATUS, CTRL;
  } GPIO[30];
} io_bank_registers;

typedef struct pio_registers {
  volatile uint32_t CTRL, FSTAT, FDEBUG, FLEVEL, TXF[4], RXF[4], IRQ, IRQ_FORCE;
  volatile uint32_t INPUT_SYNC_BYPASS, DBG_PADOUT, DBG_PADOE, DBG_CFGINFO;
  volatile uint32_t INSTR_MEM[32];
  struct {
    volatile uint32_t CLKDIV, EXECCTRL, SHIFTCTRL, ADDR, INSTR, PINCTRL;
  } SM[4];
} pio_registers;

typedef struct dma_channel_registers {
  volatile uint32_t READ_ADDR, WRITE_ADDR, TRANS_COUNT, CTRL_TRIG;
  volatile uint32_t AL1_CTRL; /* alias of the register, without trigger */
  volatile uint32_t others[11];
} dma_channel_registers;

typedef struct dma_registers {
  dma_channel_registers CH[12];
  volatile uint32_t unused[64];
  volatile uint32_t INTR, INTE0, INTF0, INTS0; /* 0x400 */
  volatile uint32_t others[13];
  volatile uint32_t CHAN_ABORT; /* 0x444 */
} dma_registers;

typedef struct spi_registers {
  volatile uint32_t SSPCR0, SSPCR1, SSPDR, SSPSR, SSPCPSR, SSPIMSC, SSPRIS;
  volatile uint32_t SSPMIS, SSPICR, SSPDMACR;
} spi_registers;

typedef struct nvic_registers {
  volatile uint32_t ISER[1];
} nvic_registers;

#define RESETS REGISTERS(resets_registers, 0x4000c000u)
#define RESETS_CLEAR REGISTERS(resets_registers, 0x4000f000u) /* bits to 0 */
#define IO_BANK0 REGISTERS(io_bank_registers, 0x40014000u)
#define PIO0 REGISTERS(pio_registers, 0x50200000u)
#define DMA REGISTERS(dma_registers, 0x50000000u)
#define SPI0 REGISTERS(spi_registers, 0x4003c000u)
#define NVIC REGISTERS(nvic_registers, 0xe000e100u)

#define RESETS_DMA (1u << 2)
#define RESETS_IO_BANK0 (1u << 5)
#define RESETS_PADS_BANK0 (1u << 8)
#define RESETS_PIO0 (1u << 10)
#define RESETS_SPI0 (1u << 16)

#define FUNCSEL_SPI 1u
#define FUNCSEL_PIO0 6u

#define PIO_CTRL_SM0_ENABLE (1u << 0)
#define PIO_CTRL_SM0_RESTART (1u << 4)
#define PIO_EXECCTRL_WRAP(bottom, top) ((bottom) << 7 | (top) << 12)
#define PIO_SHIFTCTRL_AUTOPUSH (1u << 16)
#define PIO_SHIFTCTRL_IN_RIGHT (1u << 18)
#define PIO_SHIFTCTRL_FJOIN_RX (1u << 31)

/* PIO instructions. */
#define PIO_WAIT_GPIO(level, pin) (0x2000u | (level) << 7 | (pin))
#define PIO_IN_PINS(bits) (0x4000u | (bits))
#define PIO_JMP(address) (address)

#define DMA_CTRL_EN (1u << 0)
#define DMA_CTRL_WORDS (2u << 2)
#define DMA_CTRL_INCR_READ (1u << 4)
#define DMA_CTRL_INCR_WRITE (1u << 5)
#define DMA_CTRL_CHAIN_TO(channel) ((uint32_t)(channel) << 11)
#define DMA_CTRL_TREQ(request) ((uint32_t)(request) << 15)
#define DMA_CTRL_BUSY (1u << 24)
#define DMA_CTRL_ERRORS (7u << 29) /* bus errors of reads and writes */
#define DREQ_PIO0_RX0 4u
#define DREQ_SPI0_TX 16u

#define SPI_CR0_8_BITS 7u
#define SPI_CR1_SSE (1u << 1)
#define SPI_DMACR_TXDMAE (1u << 1)

#define DMA_IRQ_0 11u

#endif /* RAYGRID_RP2040_REGISTERS_H */
