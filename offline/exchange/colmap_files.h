/// Parses and formats COLMAP's files of cameras and rigs, text and binary,
/// without interpreting the parameters.
#ifndef RAYGRID_EXCHANGE_COLMAP_FILES_H
#define RAYGRID_EXCHANGE_COLMAP_FILES_H

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "camera/area.h"
#include "camera/pose.h"

namespace raygrid {

struct ColmapCamera {
  uint32_t id = 0;
  std::string model;  ///< "OPENCV"
  ImageSize size;
  std::vector<double> parameters;
  std::string name, serial;  ///< from raygrid's comments; "" in binary files
  std::string warning;       ///< written as a comment
};

/// A camera of a rig. Other sensors, which COLMAP's rigs can have, are omitted.
struct ColmapSensor {
  uint32_t camera = 0;
  std::optional<Pose> sensor_from_rig;  ///< identity for the first
};
using ColmapRig = std::vector<ColmapSensor>;

/// An image with its pose; its features are omitted.
struct ColmapImage {
  uint32_t id = 0, camera = 0;
  std::string name;
  Pose camera_from_world;
};

/// Simultaneous images of the cameras of the only rig.
struct ColmapFrame {
  Pose rig_from_world;
  std::vector<std::pair<uint32_t, uint32_t>> images;  ///< camera and image IDs
};

/// Names of COLMAP's models, indexed by their IDs in binary files.
const std::vector<std::string>& ColmapModelNames();

/// Returns the number of parameters of one of these models.
int NumColmapParameters(const std::string& model);

/// Returns whether a text or binary file may be cameras.txt or cameras.bin,
/// even with an unknown model.
bool IsColmapText(const std::string& text);
bool IsColmapBinary(const std::string& bytes);

/// Parses cameras.txt, rigs.txt or images.txt; path is used in errors. Throws
/// InputError.
std::vector<ColmapCamera> ParseColmapCameras(const std::string& path,
                                             const std::string& text);
std::vector<ColmapRig> ParseColmapRigs(const std::string& path,
                                       const std::string& text);
std::vector<ColmapImage> ParseColmapImages(const std::string& path,
                                           const std::string& text);
std::string FormatColmapCameras(const std::vector<ColmapCamera>& cameras);
std::string FormatColmapRig(const ColmapRig& rig);
/// Throws InputError for names with a space, which COLMAP truncates there.
std::string FormatColmapImages(const std::vector<ColmapImage>& images);
std::string FormatColmapFrames(const std::vector<ColmapFrame>& frames);
/// Returns an empty points3D.txt, without which COLMAP does not read a model.
std::string FormatNoColmapPoints();

/// Binary counterparts of these functions.
std::vector<ColmapCamera> DecodeColmapCameras(const std::string& bytes);
std::vector<ColmapRig> DecodeColmapRigs(const std::string& bytes);
std::vector<ColmapImage> DecodeColmapImages(const std::string& bytes);
std::string EncodeColmapCameras(const std::vector<ColmapCamera>& cameras);
std::string EncodeColmapRig(const ColmapRig& rig);
std::string EncodeColmapImages(const std::vector<ColmapImage>& images);
std::string EncodeColmapFrames(const std::vector<ColmapFrame>& frames);
std::string EncodeNoColmapPoints();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_COLMAP_FILES_H
