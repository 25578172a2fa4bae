/// COLMAP's files of cameras and rigs, as text and binary, without what the
/// numbers mean.
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
  std::string name, serial;  ///< comments of raygrid's; "" in binary files
  std::string warning;       ///< written as a comment
};

/// A camera of a rig; COLMAP's rigs have other sensors, too, which are left
/// out.
struct ColmapSensor {
  uint32_t camera = 0;
  std::optional<Pose> sensor_from_rig;  ///< the identity of the first one
};
using ColmapRig = std::vector<ColmapSensor>;

/// An image whose place is known; what was seen in it is left out.
struct ColmapImage {
  uint32_t id = 0, camera = 0;
  std::string name;
  Pose camera_from_world;
};

/// Images that the cameras of the one rig took at one time.
struct ColmapFrame {
  Pose rig_from_world;
  std::vector<std::pair<uint32_t, uint32_t>> images;  ///< camera, image
};

/// COLMAP's models by their numbers in binary files.
const std::vector<std::string>& ColmapModelNames();

/// How many parameters a model of these has.
int NumColmapParameters(const std::string& model);

/// Whether a text, or bytes, may be cameras.txt or cameras.bin, even of a model
/// that is not known.
bool IsColmapText(const std::string& text);
bool IsColmapBinary(const std::string& bytes);

/// cameras.txt, rigs.txt and images.txt; the path is used in errors. They throw
/// InputError.
std::vector<ColmapCamera> ParseColmapCameras(const std::string& path,
                                             const std::string& text);
std::vector<ColmapRig> ParseColmapRigs(const std::string& path,
                                       const std::string& text);
std::vector<ColmapImage> ParseColmapImages(const std::string& path,
                                           const std::string& text);
std::string FormatColmapCameras(const std::vector<ColmapCamera>& cameras);
std::string FormatColmapRig(const ColmapRig& rig);
/// Throws InputError for a name with a space, which COLMAP reads no farther
/// than that.
std::string FormatColmapImages(const std::vector<ColmapImage>& images);
std::string FormatColmapFrames(const std::vector<ColmapFrame>& frames);
/// points3D.txt without any point: COLMAP reads no model that lacks it.
std::string FormatNoColmapPoints();

/// Bytes of these files.
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
