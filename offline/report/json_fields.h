/// Writes and reads structs as JSON objects, from one list of their fields:
/// VisitFields(io, value), which calls io(key, member) for each in the order of
/// the file.
#ifndef RAYGRID_REPORT_JSON_FIELDS_H
#define RAYGRID_REPORT_JSON_FIELDS_H

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace raygrid {

class FieldWriter {
 public:
  static constexpr bool kReads = false;
  explicit FieldWriter(nlohmann::ordered_json* json) : json_(*json) {}

  template <class T>
  void operator()(const char* key, const T& value) {
    json_[key] = value;
  }
  void operator()(const char* key, const Eigen::Vector2d& value) {
    json_[key] = {value.x(), value.y()};
  }
  /// Omitted if nullopt.
  template <class T>
  void operator()(const char* key, const std::optional<T>& value) {
    if (value) (*this)(key, *value);
  }
  /// Omitted unless the condition holds.
  template <class T>
  void When(bool condition, const char* key, const T& value) {
    if (condition) (*this)(key, value);
  }
  template <class T>
  void NonEmpty(const char* key, const T& value) {
    When(!value.empty(), key, value);
  }
  /// A boolean stored as one of two strings.
  void Choice(const char* key, bool value, const char* yes, const char* no) {
    json_[key] = value ? yes : no;
  }
  /// An object with the fields that visit(io) visits.
  template <class Visit>
  void Object(const char* key, bool condition, const Visit& visit) {
    if (!condition) return;
    FieldWriter fields(&json_[key]);
    visit(fields);
  }
  /// An array of objects: visit(io, k) visits the fields of the k-th.
  template <class Visit>
  void Array(const char* key, size_t count, const Visit& visit) {
    for (size_t k = 0; k < count; ++k) {
      FieldWriter fields(&json_[key][k]);
      visit(fields, k);
    }
  }
  /// Adds keys that readers ignore: add(&json).
  template <class Add>
  void Computed(const Add& add) {
    add(&json_);
  }

 private:
  nlohmann::ordered_json& json_;
};

/// Throws nlohmann::json::exception for missing keys and other types.
class FieldReader {
 public:
  static constexpr bool kReads = true;
  explicit FieldReader(const nlohmann::ordered_json& json) : json_(json) {}

  bool Has(const char* key) const { return json_.contains(key); }
  template <class T>
  void operator()(const char* key, T& value) const {
    value = json_.at(key).get<T>();
  }
  void operator()(const char* key, Eigen::Vector2d& value) const {
    for (int k = 0; k < 2; ++k) value[k] = json_.at(key).at(k).get<double>();
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& value) const {
    if (Has(key)) (*this)(key, value.emplace());
  }
  template <class T>
  void When(bool, const char* key, T& value) const {
    if (Has(key)) (*this)(key, value);
  }
  template <class T>
  void NonEmpty(const char* key, T& value) const {
    When(true, key, value);
  }
  void Choice(const char* key, bool& value, const char* yes,
              const char* /*no*/) const {
    value = json_.at(key).get<std::string>() == yes;
  }
  template <class Visit>
  void Object(const char* key, bool, const Visit& visit) const {
    if (!Has(key)) return;
    FieldReader fields(json_.at(key));
    visit(fields);
  }
  template <class Visit>
  void Array(const char* key, size_t count, const Visit& visit) const {
    for (size_t k = 0; k < count; ++k) {
      FieldReader fields(json_.at(key).at(k));
      visit(fields, k);
    }
  }
  template <class Add>
  void Computed(const Add&) const {}

 private:
  const nlohmann::ordered_json& json_;
};

/// Adds the fields to an object.
template <class T>
void WriteFields(const T& value, nlohmann::ordered_json* json) {
  FieldWriter fields(json);
  VisitFields(fields, const_cast<T&>(value));  // a writer only reads it
}

/// The conversions of nlohmann's library for each struct with VisitFields().
template <class T>
auto to_json(nlohmann::ordered_json& json, const T& value)
    -> decltype(VisitFields(std::declval<FieldWriter&>(), std::declval<T&>())) {
  json = nlohmann::ordered_json::object();
  WriteFields(value, &json);
}
template <class T>
auto from_json(const nlohmann::ordered_json& json, T& value)
    -> decltype(VisitFields(std::declval<FieldReader&>(), value)) {
  FieldReader fields(json);
  VisitFields(fields, value);
}

}  // namespace raygrid

#endif  // RAYGRID_REPORT_JSON_FIELDS_H
