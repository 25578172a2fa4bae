#ifndef RAYGRID_PACKING_REMAP_SECTIONS_H
#define RAYGRID_PACKING_REMAP_SECTIONS_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "camera/noncentral_generic.h"
#include "packing/pack.h"
#include "packing/remap_fitting.h"
#include "rg_blob.h"

namespace raygrid {

/// Remap tables in the form required by rg_blob_write().
class RemapSections {
 public:
  /// Fits the requested tables for all cameras, with equal layout, and records
  /// the first camera's tables in `packed`. lines: the non-central camera that
  /// the first, central one approximates, or NULL. valid_region: limits the
  /// displayed pixels, or NULL.
  void Fit(const std::vector<const CameraModel*>& cameras,
           const NonCentralGeneric* lines, const PackOptions& options,
           const ValidityMask* valid_region, int num_threads,
           const std::function<void()>& go_on, PackedCamera* packed);

  /// Adds the first camera's tables to contents, which point to memory owned by
  /// this object.
  void AddTo(rg_blob_contents* contents);

  /// Returns the tables of a camera, after AddTo(); NULL if there are none.
  const rg_remap_contents* contents(size_t camera) const {
    return contents_.empty() ? nullptr : contents_[camera].data();
  }

 private:
  // Warns about blocks of the last table that are out of range or inaccurate.
  void WarnAboutOutOfRange(PackedCamera* packed) const;
  // Adds tables of each camera.
  PackedRemap Add(std::vector<RemapTable> tables,
                  const std::optional<SensorMode>& mode = std::nullopt);
  // Returns the index of the mode in the section of modes, counted from 1.
  uint8_t GetModeNumber(const SensorMode& mode);

  std::vector<std::vector<RemapTable>> tables_;  // by request, then camera
  std::vector<rg_mode_section> modes_;
  std::vector<std::string> mode_names_;
  std::vector<std::vector<rg_remap_contents>> contents_;  // one list per camera
};

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_SECTIONS_H
