#include "allocation_count.h"

#include <atomic>
#include <cstddef>

// Sanitizers have a malloc of their own, and so have other C libraries.
#if defined(__GLIBC__) && !defined(RAYGRID_SANITIZED)

static std::atomic<int64_t> num_allocations{0};

extern "C" {

void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* bytes, size_t size);

void* malloc(size_t size) {
  ++num_allocations;
  return __libc_malloc(size);
}

void* calloc(size_t count, size_t size) {
  ++num_allocations;
  return __libc_calloc(count, size);
}

void* realloc(void* bytes, size_t size) {
  ++num_allocations;
  return __libc_realloc(bytes, size);
}

}  // extern "C"

int64_t CountAllocations() { return num_allocations; }

#else

int64_t CountAllocations() { return -1; }

#endif
