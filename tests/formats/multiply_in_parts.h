/* wide_multiply.h as a core without a 64-bit multiplication compiles it. */
#ifndef RAYGRID_MULTIPLY_IN_PARTS_H
#define RAYGRID_MULTIPLY_IN_PARTS_H

#include <stdint.h>

uint32_t multiply_unsigned_in_parts(uint32_t a, uint32_t b, uint32_t* low);
int32_t multiply_signed_in_parts(int32_t a, int32_t b, uint32_t* low);

#endif /* RAYGRID_MULTIPLY_IN_PARTS_H */
