/* Little-endian loads and stores. Every blob field is aligned to its size, so
 * on little-endian machines a load or store is one instruction. */
#ifndef RAYGRID_BYTES_H
#define RAYGRID_BYTES_H

#include <stddef.h>
#include <stdint.h>
/* The only library functions that may be called; declared only in hosted
 * environments. */
#if __STDC_HOSTED__
#include <string.h>
#elif defined(__cplusplus)
extern "C" void* memcpy(void* to, const void* from, size_t num_bytes);
#else
void* memcpy(void* to, const void* from, size_t num_bytes);
#endif

#if defined(__GNUC__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__

typedef uint16_t __attribute__((may_alias)) rg_half_word;
typedef uint32_t __attribute__((may_alias)) rg_word;

/* Loads a u16; p must be a multiple of 2. */
static inline uint16_t rg_load_u16(const uint8_t* p) {
  return *(const rg_half_word*)(const void*)p;
}

/* Loads a u32; p must be a multiple of 4. */
static inline uint32_t rg_load_u32(const uint8_t* p) {
  return *(const rg_word*)(const void*)p;
}

/* Stores; the same alignment is required. */
static inline void rg_store_u16(uint8_t* p, uint16_t value) {
  *(rg_half_word*)(void*)p = value;
}

static inline void rg_store_u32(uint8_t* p, uint32_t value) {
  *(rg_word*)(void*)p = value;
}

#else

static inline uint16_t rg_load_u16(const uint8_t* p) {
  return (uint16_t)(p[0] | (p[1] << 8));
}

static inline uint32_t rg_load_u32(const uint8_t* p) {
  return p[0] | ((uint32_t)p[1] << 8) | ((uint32_t)p[2] << 16) |
         ((uint32_t)p[3] << 24);
}

static inline void rg_store_u16(uint8_t* p, uint16_t value) {
  p[0] = (uint8_t)value;
  p[1] = (uint8_t)(value >> 8);
}

static inline void rg_store_u32(uint8_t* p, uint32_t value) {
  rg_store_u16(p, (uint16_t)value);
  rg_store_u16(p + 2, (uint16_t)(value >> 16));
}

#endif

static inline int16_t rg_load_i16(const uint8_t* p) {
  return (int16_t)rg_load_u16(p);
}

static inline int32_t rg_load_i32(const uint8_t* p) {
  return (int32_t)rg_load_u32(p);
}

/* Loads the i32 at p, and the next one into *second. */
static inline int32_t rg_load_i32_pair(const uint8_t* p, int32_t* second) {
  int32_t a = rg_load_i32(p), b = rg_load_i32(p + 4);
#if defined(__GNUC__) && !defined(__x86_64__)
  /* Keeps the loads adjacent, so that compilers can merge them. */
  __asm__("" : "+r"(a), "+r"(b));
#endif
  *second = b;
  return a;
}

static inline void rg_store_i32(uint8_t* p, int32_t value) {
  rg_store_u32(p, (uint32_t)value);
}

#endif /* RAYGRID_BYTES_H */
