/// The table of formats that consist of keys and numbers (keyed_formats.inc).
#ifndef RAYGRID_EXCHANGE_KEYED_TABLE_H
#define RAYGRID_EXCHANGE_KEYED_TABLE_H

#include <string>
#include <utility>
#include <vector>

#include "exchange/external_model.h"

namespace raygrid {

/// A camera model and the keys of its parameters. Strings are lists separated
/// by spaces. '@' in a key is replaced by the camera's token (such as "left"),
/// '%' by the token's first letter; a key followed by '?' is optional.
struct KeyedModel {
  ExternalModel external_model;
  /// "KEY=VALUE|VALUE": values that identify this model, at the first existing
  /// key of "KEY|KEY"; the first value is written. "KEY": the key exists.
  std::string model_selector;
  /// "KEY=PARAMETER,PARAMETER": a number or list, at the first existing key of
  /// "KEY|KEY". "KEY=K" is the camera matrix, "KEY=P" a 3 x 4 projection matrix
  /// with the pose of a rectified camera, "KEY~=" a list that may be shorter,
  /// or longer with trailing zeros. In addition to the model's parameters there
  /// are "width" and "height", "skew" of the camera matrix, "f_mm" and
  /// "sensor_width_mm", and "0", which must be 0.
  std::string values;
  /// Not used for exports, because its principal point is fixed or because the
  /// program has a better model for the camera.
  bool is_read_only = false;
};

/// Representations of poses.
enum class PoseKind {
  kCameraFromRig,  ///< matrix
  kRigFromCamera,
  kVectors,     ///< "KEY KEY": rotation vector and translation, camera_from_rig
  kBaselineMm,  ///< baseline to the right, no rotation
  /// "KEY KEY": rotation matrix and translation, camera_from_rig. The
  /// translation may have a key for each coordinate.
  kRAndT,
  kInverseRAndT  ///< as kRAndT, but rig_from_camera
};

/// Unit of lengths in the image.
enum class LengthUnit {
  kPixel,
  kLongerSide,  ///< longer side of the image
  kImageSides   ///< image width for x, height for y
};

struct KeyedPose {
  std::string keys;
  PoseKind kind;
  /// The '@' token of the camera to which this pose belongs (a pose relative to
  /// the first camera); "": a pose of every camera.
  std::string word;
};

/// Syntax of keys and values.
enum class KeyedSyntax {
  kYaml,     ///< YAML
  kStorage,  ///< YAML of OpenCV's FileStorage
  kJson,
  kToml,
  kLines,        ///< "KEY: NUMBER NUMBER ..."
  kAssignments,  ///< MATLAB, read-only
  kNumbers,      ///< line of numbers
  kBlocks        ///< numbers in blocks between empty lines: keys "0", "1", ...
};

struct KeyedFormat {
  std::string name, holds;
  KeyedSyntax syntax = KeyedSyntax::kYaml;
  /// Words of recognized texts: all of one alternative.
  std::vector<std::vector<std::string>> alternatives;
  /// Location of cameras: "" is the root, "*" all mappings in it, otherwise the
  /// key, or "KEY/KEY", of a list or mapping of cameras. "KEY|*": at the key if
  /// it exists.
  std::string place;
  std::vector<std::string> words;  ///< '@' tokens: one per camera in a
                                   ///< mapping
  std::vector<KeyedModel> models;
  /// Key of the image size as a list, or keys of width and height; "": no size.
  /// "SUFFIX=WxH SUFFIX=WxH": sizes by the suffix of the camera's token.
  std::string size;
  std::vector<KeyedPose> poses;
  std::string camera_name;  ///< key of the name
  std::string ones;         ///< keys (unsupported scales) that must be 1
  LengthUnit unit = LengthUnit::kPixel;
  std::vector<std::string> others;  ///< keys irrelevant to the model

  /// Extension of written files; "": the format is read-only.
  std::string ending;
  /// Additional keys and values of an export.
  std::vector<std::pair<std::string, std::string>> written;
  std::string fit_key;  ///< key of a text with the fit error
  /// JSON keys with possibly millions of values, such as images and points,
  /// which are dropped before the file is parsed.
  std::vector<std::string> bulk;

  bool Recognizes(const std::string& text) const;
  /// Returns whether files have all cameras of a rig, with poses.
  bool SupportsRigs() const {
    return HasProjections() ||
           (!poses.empty() && (!place.empty() || !words.empty()) &&
            poses.front().word.empty());
  }
  /// Returns whether cameras are projection matrices, which include the poses
  /// of cameras without relative rotation.
  bool HasProjections() const {
    return models.front().values.find("=P") != std::string::npos;
  }
};

const std::vector<KeyedFormat>& ListKeyedFormats();

/// Splits a text at spaces, or at another character.
std::vector<std::string> SplitText(const std::string& text, char space = ' ');

/// Returns the only line that is neither empty nor a comment; if there are
/// several, a text that is not a number.
std::string FindNumberLine(const std::string& text);

/// An entry "KEY?=VALUES" split into "KEY" and "VALUES", and whether '?' is
/// present; '@' in the key is replaced by the camera's token.
struct KeyWithMark {
  std::string key, words;
  bool has_mark = false;
};
KeyWithMark SplitAtMark(const std::string& text, char mark,
                        const std::string& word);

/// Replaces '@' in a key by the camera's token, and '%' by its first letter.
std::string SubstituteCameraName(std::string key, const std::string& word);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KEYED_TABLE_H
