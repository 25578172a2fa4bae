#ifndef RAYGRID_DATASET_FREED_MEMORY_H
#define RAYGRID_DATASET_FREED_MEMORY_H

#include <malloc.h>

namespace raygrid {

/// From here on memory that is freed stays with the process: adjustments ask
/// for as much again in each iteration, and the system clears what it gives.
inline void KeepFreedMemory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the largest that glibc takes
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_TOP_PAD, 64 << 20);
}

}  // namespace raygrid

#endif  // RAYGRID_DATASET_FREED_MEMORY_H
