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

/// Remap tables as rg_blob_write() takes them.
class RemapSections {
 public:
  /// Fits the requested tables, and records them in packed: of the first
  /// camera, and with equal layout of the others. lines: NULL for a central
  /// camera; the first one is always central. trusted: restricts what they
  /// show, or NULL.
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
  // Says what the last table cannot reach, or follow.
  void WarnAboutReach(PackedCamera* packed) const;
  // Adds tables of each camera.
  PackedRemap Add(std::vector<RemapTable> tables,
                  const std::optional<SensorMode>& mode = std::nullopt);
  // Returns the mode's place in the section of modes, counted from 1.
  uint8_t NumberOfMode(const SensorMode& mode);

  std::vector<std::vector<RemapTable>> tables_;  // of a request, of each camera
  std::vector<rg_mode_section> modes_;
  std::vector<std::string> mode_names_;
  std::vector<std::vector<rg_remap_contents>> contents_;  // of each camera
};

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_SECTIONS_H
