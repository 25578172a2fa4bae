#ifndef RAYGRID_EXCHANGE_CAMERA_KEYS_H
#define RAYGRID_EXCHANGE_CAMERA_KEYS_H

#include <yaml-cpp/yaml.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "exchange/external_model.h"

namespace raygrid {

/// Families of camera models that names in files denote.
enum class ModelFamily { kPinhole, kFisheye, kOmni, kOther };

/// Returns the family of "plumb_bob", "KannalaBrandt8", "MEI" and similar
/// names; nullopt for unknown names, such as vendors' own.
std::optional<ModelFamily> ParseModelFamily(const std::string& word);

/// Returns "a pinhole", "a fisheye", ...
const char* ToString(ModelFamily family);

/// The keys of a camera in another program's file. Records which of them were
/// read, so that Finish() reports the remaining ones; hence readers look up all
/// values through this class.
class CameraKeys {
 public:
  /// name: the camera's name in messages, or "" for the only camera of a file.
  /// Throws InputError if the node is not a mapping.
  explicit CameraKeys(const YAML::Node& map, std::string name = "");

  /// Returns the value at a key, or at keys of nested mappings separated by
  /// '/': "calib_dimension/w". Undefined if it is missing. Marks it as read.
  YAML::Node operator[](const std::string& path) const;

  /// Returns whether a value exists, without marking it as read.
  bool Has(const std::string& path) const;

  /// Returns whether a key contains one of these lower-case substrings.
  bool HasKeyWith(const std::vector<std::string>& parts) const;

  /// Returns whether the value is a list other than of mappings, or a mapping
  /// with the key 'data', as matrices are.
  bool IsMatrix(const std::string& path) const;

  /// Returns whether the value is an empty string, which Boost writes for an
  /// empty list.
  bool IsEmptyText(const std::string& path) const;

  /// Returns the text at a key, without marking it as read; "" if missing.
  std::string Word(const std::string& path) const;

  /// Marks keys that do not describe the camera model as read. "IMU.*" matches
  /// keys with this prefix.
  void Skip(const std::vector<std::string>& keys) const;

  /// Marks keys that Finish() lists without an error although their names are
  /// parameters of camera models in other formats.
  void NameOnly(const std::vector<std::string>& keys) const;

  /// Finishes reading a camera with this model. Throws InputError for an unread
  /// key that in some format selects another model or is a parameter, unless
  /// its value is equivalent or empty, or one of the camera's own `values`. One
  /// warning lists the remaining unread keys.
  void Finish(const ExternalModel& external_model,
              std::vector<std::string>* warnings,
              const std::vector<double>& values = {}) const;

 private:
  YAML::Node Find(const std::string& path) const;
  void CollectUnread(
      const YAML::Node& map, const std::string& prefix,
      std::vector<std::pair<std::string, YAML::Node>>* unread) const;

  YAML::Node map_;
  std::string name_;
  mutable std::set<std::string> read_, named_only_;
  mutable std::vector<std::string> skipped_prefixes_;
};

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_CAMERA_KEYS_H
