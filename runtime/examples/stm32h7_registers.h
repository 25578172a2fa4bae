/* Registers of the STM32H743 and of its Cortex-M7 that stm32h7_dcmi.c uses,
 * named as in the manuals RM0433 and PM0253. */
#ifndef RAYGRID_STM32H7_REGISTERS_H
#define RAYGRID_STM32H7_REGISTERS_H

#include "processor.h"

typedef struct rcc_registers {
  volatile uint32_t other[54];
  volatile uint32_t AHB1ENR, AHB2ENR, AHB4ENR; /* 0xd8 */
  volatile uint32_t APB3ENR, APB1LENR, APB1HENR, APB2ENR;
} rcc_registers;

typedef struct gpio_registers {
  volatile uint32_t MODER, OTYPER, OSPEEDR, PUPDR, IDR, ODR, BSRR, LCKR, AFR[2];
} gpio_registers;

typedef struct dcmi_registers {
  volatile uint32_t CR, SR, RIS, IER, MIS, ICR, ESCR, ESUR, CWSTRT, CWSIZE, DR;
} dcmi_registers;

typedef struct dma_stream_registers {
  volatile uint32_t CR, NDTR, PAR, M0AR, M1AR, FCR;
} dma_stream_registers;

typedef struct dma_registers {
  volatile uint32_t LISR, HISR, LIFCR, HIFCR;
  dma_stream_registers S[8];
} dma_registers;

typedef struct dmamux_registers {
  volatile uint32_t CCR[16];
} dmamux_registers;

typedef struct spi_registers {
  volatile uint32_t CR1, CR2, CFG1, CFG2, IER, SR, IFCR, AUTOCR, TXDR;
} spi_registers;

typedef struct nvic_registers {
  volatile uint32_t ISER[8];
} nvic_registers;

/* Cache maintenance by address: invalidates or cleans a line. */
typedef struct cache_registers {
  volatile uint32_t ICIALLU, reserved, ICIMVAU, DCIMVAC, DCISW, DCCMVAU,
      DCCMVAC;
} cache_registers;

#define RCC REGISTERS(rcc_registers, 0x58024400u)
#define GPIO(port) REGISTERS(gpio_registers, 0x58020000u + 0x400u * (port))
#define DCMI REGISTERS(dcmi_registers, 0x48020000u)
#define DMA1 REGISTERS(dma_registers, 0x40020000u)
#define DMAMUX1 REGISTERS(dmamux_registers, 0x40020800u)
#define SPI1 REGISTERS(spi_registers, 0x40013000u)
#define NVIC REGISTERS(nvic_registers, 0xe000e100u)
#define CACHE REGISTERS(cache_registers, 0xe000ef50u)

#define RCC_AHB1ENR_DMA1EN (1u << 0)
#define RCC_AHB2ENR_DCMIEN (1u << 0)
#define RCC_APB2ENR_SPI1EN (1u << 12)

#define DCMI_CR_CAPTURE (1u << 0)
#define DCMI_CR_CM (1u << 1) /* single frame */
#define DCMI_CR_PCKPOL (1u << 5)
#define DCMI_CR_HSPOL (1u << 6)
#define DCMI_CR_VSPOL (1u << 7)
#define DCMI_CR_ENABLE (1u << 14)
#define DCMI_OVR (1u << 1) /* bit of RIS, IER, MIS and ICR */

#define DMA_CR_EN (1u << 0)
#define DMA_CR_TEIE (1u << 2)
#define DMA_CR_TCIE (1u << 4)
#define DMA_CR_DIR_TO_PERIPHERAL (1u << 6)
#define DMA_CR_CIRC (1u << 8)
#define DMA_CR_MINC (1u << 10)
#define DMA_CR_PSIZE_16 (1u << 11)
#define DMA_CR_PSIZE_32 (2u << 11)
#define DMA_CR_MSIZE_16 (1u << 13)
#define DMA_CR_MSIZE_32 (2u << 13)
#define DMA_CR_PL_HIGHEST (3u << 16)
#define DMA_CR_DBM (1u << 18) /* double buffer mode */
#define DMA_CR_CT (1u << 19)  /* buffer in use: M0AR or M1AR */
#define DMA_FCR_DMDIS (1u << 2)
#define DMA_FCR_FTH_FULL (3u << 0)
#define DMA_LISR_STREAM0 0x3du /* flags of stream 0, the lowest bits */
#define DMA_LISR_TEIF0 (1u << 3)
#define DMA_LISR_TCIF0 (1u << 5)
#define DMA_LISR_STREAM1 (0x3du << 6)
#define DMAMUX_SPI1_TX 38u
#define DMAMUX_DCMI 75u

#define SPI_CR1_SPE (1u << 0)
#define SPI_CR1_CSTART (1u << 9)
#define SPI_CR1_SSI (1u << 12)
#define SPI_CFG1_DSIZE_16 15u
#define SPI_CFG1_TXDMAEN (1u << 15)
#define SPI_CFG1_MBR_4 (1u << 28) /* a quarter of the kernel clock */
#define SPI_CFG2_COMM_TX (1u << 17)
#define SPI_CFG2_MASTER (1u << 22)
#define SPI_CFG2_SSM (1u << 26)
#define SPI_CFG2_AFCNTR (1u << 31)

#define DMA1_STREAM0_IRQ 11u
#define DCMI_IRQ 78u

#endif /* RAYGRID_STM32H7_REGISTERS_H */
