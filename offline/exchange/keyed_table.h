/// The table of formats that are keys and numbers and no more.
#ifndef RAYGRID_EXCHANGE_KEYED_TABLE_H
#define RAYGRID_EXCHANGE_KEYED_TABLE_H

#include <string>
#include <utility>
#include <vector>

#include "exchange/lens_form.h"

namespace raygrid {

/// A camera model, and where its parameters stand. Texts are words with spaces
/// between. '@' in a key stands for the camera's word, and a key with '?'
/// behind it may be missing.
struct KeyedModel {
  LensForm form;
  /// "KEY=WORD|WORD": what the file says of this model, at "KEY|KEY" the first
  /// that is there; the first word is written.
  const char* says;
  /// "KEY=PARAMETER,PARAMETER": a number or a list, at "KEY|KEY" the first
  /// that is there. "KEY=K" is the camera matrix, "KEY=P" a projection matrix
  /// of 3 x 4 with the pose of a rectified camera, "KEY~=" a list that may be
  /// shorter. Longer ones end with 0.
  const char* values;
  /// Its principal point is fixed, or programs know it by another model: an
  /// export takes none of these.
  bool is_read_only = false;
};

/// Kinds of poses.
enum class PoseKind {
  kCameraFromRig,  ///< a matrix
  kRigFromCamera,
  kVectors,     ///< "KEY KEY": rotation vector and translation, camera_from_rig
  kBaselineMm,  ///< how far it stands to the right, not turned
  kRAndT        ///< "KEY KEY": rotation matrix and translation, likewise
};

struct KeyedPose {
  const char* keys;
  PoseKind kind;
  /// The word of the camera that has it; the first then is the rig.
  const char* word = "";
};

/// How keys and values are written.
enum class KeyedSyntax {
  kYaml,     ///< YAML
  kStorage,  ///< YAML of OpenCV's FileStorage
  kJson,
  kToml,
  kLines,        ///< "KEY: NUMBER NUMBER ..."
  kAssignments,  ///< "KEY = [NUMBER NUMBER; ...];" as MATLAB has it, only read
  kNumbers       ///< a line of numbers
};

struct KeyedFormat {
  const char *name, *holds;
  KeyedSyntax syntax;
  bool (*recognizes)(const std::string& text);
  /// The place of cameras: "" is the file itself, "*" its maps by their names,
  /// else the key of a list or a map of them.
  const char* place;
  std::vector<const char*> words;  ///< for '@', one for each camera of a map
  std::vector<KeyedModel> models;
  const char* size;  ///< "KEY" of a list, "KEY KEY", or "" if there is none
  std::vector<KeyedPose> poses;
  const char* camera_name;  ///< its key
  const char* ones;    ///< keys whose value must be 1: scales that are not read
  bool is_normalized;  ///< lengths are parts of the longer side of the image
  std::vector<std::string> others;  ///< keys that say nothing of the lens

  /// The ending of files that are written; a format without one is only read.
  const char* ending = "";
  /// Keys and texts that an export writes beyond the lens.
  std::vector<std::pair<const char*, const char*>> written = {};
  const char* fit_key = "";  ///< of a text that says the error of a fit

  /// Whether a file has the cameras of a rig, with their poses.
  bool SupportsRigs() const {
    return HasProjections() ||
           (!poses.empty() && (place[0] != 0 || !words.empty()) &&
            poses.front().word[0] == 0);
  }
  /// Whether cameras are projection matrices, which have the poses of cameras
  /// that are not turned against each other.
  bool HasProjections() const {
    return std::string(models.front().values).find("=P") != std::string::npos;
  }
};

const std::vector<KeyedFormat>& ListKeyedFormats();

/// Words of a text, or its parts at another character.
std::vector<std::string> SplitText(const std::string& text, char space = ' ');

/// The one line of a text beside comments and empty lines; a text that is no
/// number if there are several.
std::string FindNumberLine(const std::string& text);

/// "KEY?=WORDS" as "KEY" and "WORDS", and whether the mark stands there; '@' in
/// the key becomes the camera's word.
struct KeyedWord {
  std::string key, words;
  bool has_mark = false;
};
KeyedWord SplitAtMark(const std::string& text, char mark,
                      const std::string& word);

/// A key with the camera's word in it.
std::string SubstituteWord(std::string key, const std::string& word);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_KEYED_TABLE_H
