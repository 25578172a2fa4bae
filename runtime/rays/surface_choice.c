#include "rays/surface_choice.h"

#include "kernel_name.h"

rg_status rg_select_ray_kernels(rg_camera* camera, const char* name) {
  uint16_t surface = rg_select_surface();
  if (name && rg_is_name(name, "portable"))
    surface = RG_SURFACE_PORTABLE;
  else if (name &&
           (surface == RG_SURFACE_PORTABLE || !rg_is_name(name, "avx2")))
    return RG_ERR_ARGUMENT;
  camera->surface = surface;
  return RG_OK;
}
