/* Which kernels run. */
#ifndef RAYGRID_REMAP_DISPATCH_H
#define RAYGRID_REMAP_DISPATCH_H

#include "kernels/remap_kernels.h"

/* Those of a board: known when it is compiled, and without need of spare rows.
 */
#if RG_ALL_BUILT_IN && RG_HAVE_HELIUM
#define RG_BUILT_IN(channels) rg_blend_##channels##_helium
#elif RG_ALL_BUILT_IN
#define RG_BUILT_IN(channels) rg_blend_##channels##_rvv
#else
#define RG_BUILT_IN(channels) rg_blend_##channels
#endif

/* Whether kernels that were chosen may run: is_roomy where the spare rows are
 * there, which those beside built-in ones do not need either. */
#define RG_MAY_RUN(is_roomy) (RG_ALL_BUILT_IN || (is_roomy))

/* wanted, or the fastest; NULL, which is the built-in ones, where rows are too
 * short for others. */
static inline const rg_kernels* rg_choose_kernels(const rg_kernels* wanted,
                                                  uint32_t stride) {
#if RG_CHOOSE_KERNELS
  if (!RG_MAY_RUN(stride >= RG_MIN_STRIDE)) return 0;
  return wanted ? wanted : rg_find_kernels(0);
#else
  (void)wanted;
  (void)stride;
  return 0;
#endif
}

static inline void rg_dispatch_grey(const rg_kernels* kernels,
                                    const rg_run* run, int is_roomy) {
  if (RG_CHOOSE_KERNELS && kernels && RG_MAY_RUN(is_roomy))
    kernels->blend[0](run);
  else
    RG_BUILT_IN(1)(run);
}

/* Channels of 8 bits that fill the plane; 0 of other lattices. */
static inline uint32_t rg_interleaved(const rg_lattice* lattice) {
  const uint32_t channels = lattice->num_channels;
  return lattice->kind == RG_SAMPLE_8 && lattice->sample_step == channels
             ? channels
             : 0;
}

/* By those that every program has; 0 if there are none for so many channels. */
static inline int rg_blend_built_in(const rg_run* run, uint32_t channels) {
  if (channels == 1)
    RG_BUILT_IN(1)(run);
  else if (RG_ALL_BUILT_IN && channels == 2)
    RG_BUILT_IN(2)(run);
  else if (RG_ALL_BUILT_IN && channels == 3)
    RG_BUILT_IN(3)(run);
  else if (RG_ALL_BUILT_IN && channels == 4)
    RG_BUILT_IN(4)(run);
  else
    return 0;
  return 1;
}

static inline void rg_dispatch(const rg_kernels* kernels, const rg_run* run,
                               const rg_lattice* lattice, int is_roomy) {
  const uint32_t channels = rg_interleaved(lattice);
  if (RG_CHOOSE_KERNELS && kernels && RG_MAY_RUN(is_roomy) && channels != 0) {
    kernels->blend[channels - 1](run);
    return;
  }
  if (!rg_blend_built_in(run, channels)) rg_blend_lattice(run, lattice);
}

#endif /* RAYGRID_REMAP_DISPATCH_H */
