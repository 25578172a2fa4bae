/* Names of kernels. */
#ifndef RAYGRID_KERNEL_NAME_H
#define RAYGRID_KERNEL_NAME_H

/* Whether two names are equal. */
static inline int rg_is_name(const char* a, const char* b) {
  while (*a && *a == *b) ++a, ++b;
  return *a == *b;
}

#endif /* RAYGRID_KERNEL_NAME_H */
