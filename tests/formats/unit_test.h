/* CMocka and the headers that it wants in front of it. */
#ifndef RAYGRID_UNIT_TEST_H
#define RAYGRID_UNIT_TEST_H

/* clang-format off */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
/* clang-format on */

#endif /* RAYGRID_UNIT_TEST_H */
