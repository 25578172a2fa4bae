/* Access of the examples to the processor: registers at their addresses,
 * masking of interrupts, and cache lines. A test substitutes memory and
 * functions of its own. */
#ifndef RAYGRID_EXAMPLES_PROCESSOR_H
#define RAYGRID_EXAMPLES_PROCESSOR_H

#include <stdint.h>

#if !defined(BOARD_IS_MOCK)

/* Registers of a peripheral as a struct at a fixed address. */
#define REGISTERS(type, address) ((type*)(address))

/* Called in loops that wait for a register. */
#define POLL() ((void)0)

/* Writes to a FIFO register. */
#define WRITE_FIFO(fifo, value) ((fifo) = (value))

#if defined(__arm__)

static inline uint32_t hold_interrupts(void) {
  uint32_t state;
  __asm__ volatile("mrs %0, primask\n\tcpsid i" : "=r"(state) : : "memory");
  return state;
}

static inline void release_interrupts(uint32_t state) {
  __asm__ volatile("msr primask, %0\n\tisb" : : "r"(state) : "memory");
}

/* Returns also if a masked interrupt is pending. */
static inline void wait_for_interrupt(void) {
  __asm__ volatile("dsb\n\twfi" : : : "memory");
}

static inline void wait_for_memory(void) {
  __asm__ volatile("dsb" : : : "memory");
}

#elif defined(__XTENSA__)

static inline uint32_t hold_interrupts(void) {
  uint32_t state;
  __asm__ volatile("rsil %0, 3" : "=r"(state) : : "memory");
  return state;
}

static inline void release_interrupts(uint32_t state) {
  __asm__ volatile("wsr %0, ps\n\trsync" : : "r"(state) : "memory");
}

/* Enables interrupts while waiting. */
static inline void wait_for_interrupt(void) {
  __asm__ volatile("waiti 0" : : : "memory");
}

static inline void wait_for_memory(void) {
  __asm__ volatile("memw" : : : "memory");
}

#endif
#endif /* BOARD_IS_MOCK */

#endif /* RAYGRID_EXAMPLES_PROCESSOR_H */
