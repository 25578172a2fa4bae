/* Functions that GCC calls for arithmetic the core has no instruction for.
 * Debian's libgcc leaves them out, since the ESP8266 has them in its ROM. The
 * tests call them; the runtime calls none. */
#include <stdint.h>

typedef struct quotient {
  uint64_t whole, rest;
} quotient;

static quotient divide(uint64_t a, uint64_t b) {
  quotient result = {0, 0};
  for (int bit = 63; bit >= 0; --bit) {
    result.rest = result.rest << 1 | (a >> bit & 1);
    if (result.rest >= b) {
      result.rest -= b;
      result.whole |= UINT64_C(1) << bit;
    }
  }
  return result;
}

static uint32_t divide_words(uint32_t a, uint32_t b, uint32_t* rest) {
  uint32_t whole = 0, left = 0;
  for (int bit = 31; bit >= 0; --bit) {
    const uint32_t carry = left >> 31;
    left = left << 1 | (a >> bit & 1);
    if (carry || left >= b) {
      left -= b;
      whole |= UINT32_C(1) << bit;
    }
  }
  *rest = left;
  return whole;
}

uint32_t __udivsi3(uint32_t a, uint32_t b);
uint32_t __umodsi3(uint32_t a, uint32_t b);
int32_t __divsi3(int32_t a, int32_t b);
uint64_t __udivdi3(uint64_t a, uint64_t b);
uint64_t __umoddi3(uint64_t a, uint64_t b);
int64_t __divdi3(int64_t a, int64_t b);
int64_t __moddi3(int64_t a, int64_t b);
uint64_t __muldi3(uint64_t a, uint64_t b);

uint32_t __udivsi3(uint32_t a, uint32_t b) {
  uint32_t rest;
  return divide_words(a, b, &rest);
}

uint32_t __umodsi3(uint32_t a, uint32_t b) {
  uint32_t rest;
  divide_words(a, b, &rest);
  return rest;
}

int32_t __divsi3(int32_t a, int32_t b) {
  const uint32_t whole = __udivsi3(a < 0 ? 0 - (uint32_t)a : (uint32_t)a,
                                   b < 0 ? 0 - (uint32_t)b : (uint32_t)b);
  return (int32_t)((a < 0) != (b < 0) ? 0 - whole : whole);
}

uint64_t __udivdi3(uint64_t a, uint64_t b) { return divide(a, b).whole; }

uint64_t __umoddi3(uint64_t a, uint64_t b) { return divide(a, b).rest; }

int64_t __divdi3(int64_t a, int64_t b) {
  const uint64_t whole = __udivdi3(a < 0 ? 0 - (uint64_t)a : (uint64_t)a,
                                   b < 0 ? 0 - (uint64_t)b : (uint64_t)b);
  return (int64_t)((a < 0) != (b < 0) ? 0 - whole : whole);
}

int64_t __moddi3(int64_t a, int64_t b) {
  const uint64_t rest = __umoddi3(a < 0 ? 0 - (uint64_t)a : (uint64_t)a,
                                  b < 0 ? 0 - (uint64_t)b : (uint64_t)b);
  return (int64_t)(a < 0 ? 0 - rest : rest);
}

uint64_t __muldi3(uint64_t a, uint64_t b) {
  const uint32_t a0 = (uint32_t)a & 0xffff, a1 = (uint32_t)a >> 16;
  const uint32_t b0 = (uint32_t)b & 0xffff, b1 = (uint32_t)b >> 16;
  const uint32_t low = a0 * b0;
  const uint32_t middle = a1 * b0 + (low >> 16); /* <= 2^32 - 2^16 */
  const uint32_t carry = a0 * b1 + (middle & 0xffff);
  const uint32_t high = a1 * b1 + (middle >> 16) + (carry >> 16) +
                        (uint32_t)(a >> 32) * (uint32_t)b +
                        (uint32_t)a * (uint32_t)(b >> 32);
  return (uint64_t)high << 32 | (carry << 16 | (low & 0xffff));
}

/* ---- Doubles: zero and normal numbers, which is all that the tests have ---
 */

uint64_t __adddf3(uint64_t a, uint64_t b);
uint64_t __subdf3(uint64_t a, uint64_t b);
uint64_t __muldf3(uint64_t a, uint64_t b);
uint64_t __divdf3(uint64_t a, uint64_t b);
uint64_t __floatsidf(int32_t value);
uint64_t __floatunsidf(uint32_t value);
int32_t __fixdfsi(uint64_t a);
uint32_t __fixunsdfsi(uint64_t a);

static const uint64_t kSign = UINT64_C(1) << 63;

static int exponent_of(uint64_t a) { return (int)(a >> 52 & 0x7ff); }

/* The mantissa's 53 bits, with 10 below them and 1 above; 0 for zero. */
static uint64_t mantissa_of(uint64_t a) {
  const uint64_t bits = a & ((UINT64_C(1) << 52) - 1);
  return exponent_of(a) == 0 ? 0 : (bits | UINT64_C(1) << 52) << 10;
}

/* mantissa 2^(exponent - 1023 - 62), rounded half up. */
static uint64_t make_double(uint64_t sign, int exponent, uint64_t mantissa) {
  if (mantissa == 0) return 0;
  while (mantissa < UINT64_C(1) << 62) {
    mantissa <<= 1;
    --exponent;
  }
  if (mantissa < UINT64_MAX - 0x200) mantissa += 0x200;
  if (mantissa >> 63 != 0) {
    mantissa >>= 1;
    ++exponent;
  }
  if (exponent <= 0) return 0;
  return sign | (((uint64_t)exponent << 52) +
                 ((mantissa >> 10) & ((UINT64_C(1) << 52) - 1)));
}

uint64_t __adddf3(uint64_t a, uint64_t b) {
  if ((a & ~kSign) < (b & ~kSign)) {
    const uint64_t larger = b;
    b = a;
    a = larger;
  }
  const int shift = exponent_of(a) - exponent_of(b);
  const uint64_t smaller = shift < 64 ? mantissa_of(b) >> shift : 0;
  const uint64_t sum = ((a ^ b) & kSign) != 0 ? mantissa_of(a) - smaller
                                              : mantissa_of(a) + smaller;
  return make_double(a & kSign, exponent_of(a), sum);
}

uint64_t __subdf3(uint64_t a, uint64_t b) { return __adddf3(a, b ^ kSign); }

uint64_t __muldf3(uint64_t a, uint64_t b) {
  const uint64_t x = mantissa_of(a), y = mantissa_of(b);
  const uint64_t x0 = (uint32_t)x, x1 = x >> 32;
  const uint64_t y0 = (uint32_t)y, y1 = y >> 32;
  const uint64_t middle = x1 * y0 + (x0 * y0 >> 32);
  const uint64_t carry = x0 * y1 + (uint32_t)middle;
  const uint64_t high = x1 * y1 + (middle >> 32) + (carry >> 32);
  /* 2^62 times itself is 2^60 here. */
  return make_double((a ^ b) & kSign, exponent_of(a) + exponent_of(b) - 1021,
                     high);
}

uint64_t __floatsidf(int32_t value) {
  const uint32_t magnitude = value < 0 ? 0 - (uint32_t)value : (uint32_t)value;
  return make_double(value < 0 ? kSign : 0, 1023 + 62, magnitude);
}

uint64_t __divdf3(uint64_t a, uint64_t b) {
  const uint64_t divisor = mantissa_of(b);
  uint64_t rest = mantissa_of(a), whole = 0;
  if (divisor == 0) __builtin_trap();
  for (int bit = 0; bit < 63; ++bit) { /* rest < 2 divisor */
    whole <<= 1;
    if (rest >= divisor) {
      rest -= divisor;
      whole |= 1;
    }
    rest <<= 1;
  }
  return make_double((a ^ b) & kSign, exponent_of(a) - exponent_of(b) + 1023,
                     whole);
}

uint64_t __floatunsidf(uint32_t value) {
  return make_double(0, 1023 + 62, value);
}

/* Towards zero. */
uint32_t __fixunsdfsi(uint64_t a) {
  const int shift = 1023 + 62 - exponent_of(a);
  return shift < 64 ? (uint32_t)(mantissa_of(a) >> shift) : 0;
}

int32_t __fixdfsi(uint64_t a) {
  const uint32_t magnitude = __fixunsdfsi(a);
  return (int32_t)((a & kSign) != 0 ? 0 - magnitude : magnitude);
}
