#ifndef RAYGRID_EXCHANGE_FILE_STORAGE_H
#define RAYGRID_EXCHANGE_FILE_STORAGE_H

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace raygrid {

/// Parses OpenCV's FileStorage, in YAML, XML or JSON, to a tree. A matrix is a
/// mapping of rows, cols, dt and data. Throws InputError and exceptions of
/// yaml-cpp; path is used in errors.
YAML::Node ParseFileStorage(const std::string& path, const std::string& text);

/// Returns whether a text contains a FileStorage matrix of 2 or more
/// dimensions.
bool IsFileStorage(const std::string& text);

/// A matrix of one or several channels, row by row.
struct StoredMatrix {
  int rows = 0, columns = 0;
  std::vector<double> data;
};

/// Parses a FileStorage matrix, or nested lists as written by Python. Throws
/// InputError with the name, also if the number of channels differs.
StoredMatrix ParseStoredMatrix(const YAML::Node& node, const std::string& name,
                               int num_channels = 1);

/// Parses 2D points, one image per row: a matrix of two channels, or an array
/// of more dimensions, such as nested lists from numpy. Throws InputError with
/// the name.
StoredMatrix ParseStoredPoints(const YAML::Node& node, const std::string& name);

/// Formats text that FileStorage can read.
class FileStorageText {
 public:
  enum class Kind { kYaml, kXml, kJson };
  /// Returns the kind for a file name's extension; YAML by default.
  static Kind KindOf(const std::string& path);

  explicit FileStorageText(Kind kind);

  void Add(const std::string& key, int number);
  void Add(const std::string& key, double number);
  void Add(const std::string& key, const std::string& text);
  void Add(const std::string& key, const StoredMatrix& matrix);
  void Add(const std::string& key, const std::vector<std::string>& texts);
  void BeginMap(const std::string& key);
  void EndMap();
  std::string Finish();

 private:
  void AddPlain(const std::string& key, const std::string& value);
  std::string Indentation() const;

  Kind kind_;
  std::string text_;
  std::vector<std::string> open_;  // keys of open mappings
};

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_FILE_STORAGE_H
