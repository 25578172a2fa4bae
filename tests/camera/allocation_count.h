#ifndef RAYGRID_TEST_ALLOCATION_COUNT_H
#define RAYGRID_TEST_ALLOCATION_COUNT_H

#include <cstdint>

/// Allocations by all threads so far; -1 where they cannot be counted.
int64_t CountAllocations();

#endif  // RAYGRID_TEST_ALLOCATION_COUNT_H
