#ifndef RAYGRID_DATASET_MEMORY_RETENTION_H
#define RAYGRID_DATASET_MEMORY_RETENTION_H

#include <malloc.h>

namespace raygrid {

/// Keeps freed memory in the process: each iteration of an optimization
/// allocates the same amount again, and the system would have to clear it.
inline void RetainFreedMemory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the largest value that glibc accepts
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_TOP_PAD, 64 << 20);
}

}  // namespace raygrid

#endif  // RAYGRID_DATASET_MEMORY_RETENTION_H
