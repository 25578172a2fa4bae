#ifndef RAYGRID_EXCHANGE_CAMERA_KEYS_H
#define RAYGRID_EXCHANGE_CAMERA_KEYS_H

#include <yaml-cpp/yaml.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "exchange/lens_form.h"

namespace raygrid {

/// Sorts of camera models that words of files name.
enum class LensFamily { kPinhole, kFisheye, kOmni, kOther };

/// The family of "plumb_bob", "KannalaBrandt8", "MEI" and the like; nothing for
/// words that name none, as those of makers do.
std::optional<LensFamily> ParseLensFamily(const std::string& word);

/// "a pinhole", "a fisheye", ...
const char* ToText(LensFamily family);

/// The keys of a camera in another program's file, which knows which of them a
/// reader has read. Readers look values up through it and nothing else, so
/// that no key is left out without a word.
class CameraKeys {
 public:
  /// name is the camera's in messages; "" if the file has one alone. Throws
  /// InputError if the node is no map.
  explicit CameraKeys(const YAML::Node& map, std::string name = "");

  /// The value at a key, or at keys of maps in each other with '/' between:
  /// "calib_dimension/w". Undefined if there is none. It counts as read.
  YAML::Node operator[](const std::string& path) const;

  /// Whether there is such a value. It does not count as read.
  bool Has(const std::string& path) const;

  /// Whether a key has one of these parts, in small letters.
  bool HasKeyWith(const std::vector<std::string>& parts) const;

  /// Whether the value is a list that is not one of maps, or a map with the key
  /// 'data', as matrices are.
  bool IsMatrix(const std::string& path) const;

  /// The word at a key, without counting it as read; "" if there is none.
  std::string Word(const std::string& path) const;

  /// Counts keys as read that say nothing of the lens. "IMU.*" are those that
  /// begin so.
  void Skip(const std::vector<std::string>& keys) const;

  /// Keys that Finish() names and does not judge: they mean something else
  /// here than in formats where they are numbers of a lens.
  void NameOnly(const std::vector<std::string>& keys) const;

  /// Ends the reading of a lens of this form. Of the keys that were not read,
  /// throws InputError for one that in some format selects another model, or is
  /// a parameter of one, unless its value says the same or nothing; the lens's
  /// own values may be repeated. The others become one remark that names them.
  void Finish(const LensForm& form, std::vector<std::string>* warnings,
              const std::vector<double>& values = {}) const;

 private:
  YAML::Node Find(const std::string& path) const;
  void FindUnread(
      const YAML::Node& map, const std::string& prefix,
      std::vector<std::pair<std::string, YAML::Node>>* unread) const;

  YAML::Node map_;
  std::string name_;
  mutable std::set<std::string> read_, named_only_;
  mutable std::vector<std::string> skipped_prefixes_;
};

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_CAMERA_KEYS_H
