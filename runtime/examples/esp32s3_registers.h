/* Registers of the ESP32-S3 that esp32s3_cam.c uses, named as in its technical
 * reference manual, and functions of ESP-IDF. */
#ifndef RAYGRID_ESP32S3_REGISTERS_H
#define RAYGRID_ESP32S3_REGISTERS_H

#include "processor.h"

typedef struct system_registers {
  volatile uint32_t others[7];
  volatile uint32_t PERIP_CLK_EN1; /* 0x1c */
  volatile uint32_t PERIP_RST_EN0;
  volatile uint32_t PERIP_RST_EN1; /* 0x24 */
} system_registers;

typedef struct gpio_registers {
  volatile uint32_t others[85];
  volatile uint32_t FUNC_IN_SEL_CFG[256]; /* one per signal, from 0x154 */
  volatile uint32_t FUNC_OUT_SEL_CFG[49]; /* one per pin, from 0x554 */
} gpio_registers;

typedef struct io_mux_registers {
  volatile uint32_t PIN_CTRL, PIN[49];
} io_mux_registers;

typedef struct lcd_cam_registers {
  volatile uint32_t LCD_CLOCK, CAM_CTRL, CAM_CTRL1, CAM_RGB_YUV, others[21];
  volatile uint32_t LC_DMA_INT_ENA, LC_DMA_INT_RAW, LC_DMA_INT_ST; /* 0x64 */
  volatile uint32_t LC_DMA_INT_CLR;
} lcd_cam_registers;

typedef struct gdma_in_registers {
  volatile uint32_t CONF0, CONF1, INT_RAW, INT_ST, INT_ENA, INT_CLR;
  volatile uint32_t FIFO_STATUS, POP, LINK, STATE, SUC_EOF_DES, ERR_EOF_DES;
  volatile uint32_t DSCR, DSCR_BF0, DSCR_BF1, WEIGHT, reserved, PRI, PERI_SEL;
} gdma_in_registers;

typedef struct uart_registers {
  volatile uint32_t FIFO, INT_RAW, INT_ST, INT_ENA, INT_CLR, CLKDIV, RX_FILT;
  volatile uint32_t STATUS;
} uart_registers;

/* A GDMA descriptor. */
typedef struct gdma_descriptor {
  volatile uint32_t DW0;
  uint32_t buffer, next; /* addresses */
} gdma_descriptor;

#define SYSTEM REGISTERS(system_registers, 0x600c0000u)
#define GPIO REGISTERS(gpio_registers, 0x60004000u)
#define IO_MUX REGISTERS(io_mux_registers, 0x60009000u)
#define LCD_CAM REGISTERS(lcd_cam_registers, 0x60041000u)
#define GDMA_IN0 REGISTERS(gdma_in_registers, 0x6003f000u)
#define UART0 REGISTERS(uart_registers, 0x60000000u)

#define SYSTEM_DMA (1u << 6) /* bit of PERIP_CLK_EN1, PERIP_RST_EN1 */
#define SYSTEM_LCD_CAM (1u << 8)

#define GPIO_SIG_IN_SEL (1u << 7) /* input through the matrix */
#define IO_MUX_FUN_IE (1u << 9)
#define IO_MUX_MCU_SEL_GPIO (1u << 12)
#define CAM_DATA_IN0_IDX 133u
#define CAM_PCLK_IDX 149u
#define CAM_H_ENABLE_IDX 150u
#define CAM_V_SYNC_IDX 152u

#define CAM_CTRL_UPDATE (1u << 4)
#define CAM_CTRL_VS_EOF_EN (1u << 8)
#define CAM_CTRL_CLKM_DIV_NUM(n) ((uint32_t)(n) << 9)
#define CAM_CTRL_CLK_SEL_160M (3u << 29)
#define CAM_CTRL1_VSYNC_FILTER_EN (1u << 23)
#define CAM_CTRL1_START (1u << 29)
#define CAM_CTRL1_RESET (1u << 30)
#define CAM_CTRL1_AFIFO_RESET (1u << 31)

#define CAM_VSYNC_INT (1u << 2) /* bit of LC_DMA_INT_.. */

#define GDMA_IN_RST (1u << 0)    /* bit of CONF0 */
#define GDMA_IN_DONE (1u << 0)   /* bit of INT_..: a descriptor is full */
#define GDMA_IN_ERRORS (7u << 2) /* EOF, descriptor, list end */
#define GDMA_INLINK_STOP (1u << 21)
#define GDMA_INLINK_START (1u << 22)
#define GDMA_PERI_LCD_CAM 5u
#define GDMA_DW0_OWNER_DMA (1u << 31)

#define UART_TXFIFO_CNT(status) ((status) >> 16 & 0x3ffu)
#define UART_TXFIFO_SIZE 128u

/* From ESP-IDF's esp_intr_alloc.h, which declares the handle as a pointer. */
#define ETS_DMA_IN_CH0_INTR_SOURCE 66
#define ESP_INTR_FLAG_LEVEL3 (1 << 3)
int esp_intr_alloc(int source, int flags, void (*handler)(void*),
                   void* argument, void** handle);

#endif /* RAYGRID_ESP32S3_REGISTERS_H */
