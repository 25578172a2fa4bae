#include "multiply_in_parts.h"

#define RG_MULTIPLY_IN_PARTS 1
#include "wide_multiply.h"

uint32_t multiply_unsigned_in_parts(uint32_t a, uint32_t b, uint32_t* low) {
  return rg_multiply_unsigned(a, b, low);
}

int32_t multiply_signed_in_parts(int32_t a, int32_t b, uint32_t* low) {
  return rg_multiply_signed(a, b, low);
}
