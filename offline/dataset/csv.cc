#include "dataset/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

std::string_view Trim(std::string_view text) {
  const char* spaces = " \t\r";
  const size_t first = text.find_first_not_of(spaces);
  if (first == std::string_view::npos) return "";
  return text.substr(first, text.find_last_not_of(spaces) - first + 1);
}

// Reads the records of a CSV text sequentially.
class RecordReader {
 public:
  RecordReader(const std::string& name, const std::string& text)
      : name_(name), text_(text) {}

  // Reads the next record that is neither empty nor a comment; returns false at
  // the end.
  bool Read(std::vector<std::string>* fields) {
    while (place_ < text_.size()) {
      const size_t end = std::min(text_.find('\n', place_), text_.size());
      record_line_ = line_;
      if (text_[place_] != '#' &&
          !Trim(std::string_view(text_).substr(place_, end - place_)).empty()) {
        ReadFields(fields);
        return true;
      }
      Skip(end);
    }
    return false;
  }

  // Reads the next record, even if empty or a comment; returns false if it is
  // not the last one.
  bool ReadLast(std::vector<std::string>* fields) {
    ReadFields(fields);
    return place_ >= text_.size();
  }

  // Returns the line where the most recent record starts.
  int record_line() const { return record_line_; }

 private:
  static constexpr size_t kMaxFields = 1000;

  void ReadFields(std::vector<std::string>* fields) {
    fields->clear();
    for (;;) {
      place_ = std::min(text_.find_first_not_of(" \t", place_), text_.size());
      if (fields->size() == kMaxFields) Fail("more than 1000 fields");
      fields->push_back(CurrentCharacter() == '"' ? QuotedField()
                                                  : PlainField());
      if (CurrentCharacter() != ',') break;
      ++place_;
    }
    Skip(place_);
  }

  std::string PlainField() {
    const size_t end =
        std::min(text_.find_first_of(",\n\"", place_), text_.size());
    const std::string field(
        Trim(std::string_view(text_).substr(place_, end - place_)));
    place_ = end;
    if (CurrentCharacter() == '"')
      Fail(
          "quote within an unquoted field; quote the field and double the "
          "quotes in it");
    return field;
  }

  std::string QuotedField() {
    std::string field;
    for (++place_;; ++place_) {
      const size_t quote = text_.find('"', place_);
      if (quote == std::string::npos) Fail("unterminated quote");
      field.append(text_, place_, quote - place_);
      line_ += static_cast<int>(std::count(
          text_.begin() + Offset(place_), text_.begin() + Offset(quote), '\n'));
      place_ = quote + 1;
      if (CurrentCharacter() != '"') break;
      field += '"';
    }
    place_ = std::min(text_.find_first_not_of(" \t\r", place_), text_.size());
    if (place_ < text_.size() && CurrentCharacter() != ',' &&
        CurrentCharacter() != '\n')
      Fail("text after a closing quote; double quotes within a field");
    return field;
  }

  // Continues at the line after the given line break.
  void Skip(size_t end_of_line) {
    place_ = end_of_line + 1;
    ++line_;
  }

  char CurrentCharacter() const {
    return place_ < text_.size() ? text_[place_] : '\n';
  }

  static std::ptrdiff_t Offset(size_t place) {
    return static_cast<std::ptrdiff_t>(place);
  }

  [[noreturn]] void Fail(const char* what) const {
    throw InputError(fmt::format("{}, line {}: {}", name_, record_line_, what));
  }

  const std::string& name_;
  const std::string& text_;
  size_t place_ = 0;
  int line_ = 1, record_line_ = 1;
};

template <typename T>
bool ParseNumber(const std::string& text, T* value) {
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, *value);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace

class CsvReader::Records : public RecordReader {
 public:
  using RecordReader::RecordReader;
};

CsvReader::CsvReader(const std::string& name, const std::string& text,
                     const std::vector<std::string>& required_columns)
    : name_(name), records_(std::make_unique<Records>(name, text)) {
  RequireTextFile(name, text);
  records_->Read(&header_);
  for (const std::string& column : required_columns)
    if (!HasColumn(column))
      throw InputError(
          fmt::format("{}: missing column '{}' in the header; expected {}",
                      name_, column, fmt::join(required_columns, ",")));
  for (const std::string& column : header_)
    if (!column.empty() &&
        std::count(header_.begin(), header_.end(), column) > 1)
      throw InputError(fmt::format("{}: duplicate column '{}' in the header",
                                   name_, column));
}

CsvReader::CsvReader(CsvReader&&) noexcept = default;
CsvReader::~CsvReader() = default;

bool CsvReader::Next() {
  if (!records_->Read(&fields_)) return false;
  if (fields_.size() != header_.size())
    throw InputError(
        fmt::format("{}: {} fields, but the header has {}; fix the line, or "
                    "quote names that contain commas",
                    Place(), fields_.size(), header_.size()));
  if (++num_rows_ > max_rows_)
    throw InputError(
        fmt::format("{}: exceeds the limit of {} rows; split the file", Place(),
                    max_rows_));
  return true;
}

int CsvReader::ColumnIndex(const std::string& column) const {
  const auto found = std::find(header_.begin(), header_.end(), column);
  return found == header_.end() ? -1
                                : static_cast<int>(found - header_.begin());
}

bool CsvReader::HasColumn(const std::string& column) const {
  return ColumnIndex(column) >= 0;
}

const std::string& CsvReader::Text(const std::string& column) const {
  return fields_[ColumnIndex(column)];
}

double CsvReader::Number(const std::string& column) const {
  double value;
  if (!ParseNumber(Text(column), &value) || !std::isfinite(value))
    throw InputError(fmt::format(
        "{}, column {}: '{}' is not a finite number; fix or remove the line",
        Place(), column, Text(column)));
  return value;
}

int CsvReader::Integer(const std::string& column) const {
  int value;
  if (!ParseNumber(Text(column), &value))
    throw InputError(fmt::format(
        "{}, column {}: '{}' is not an integer; fix or remove the line",
        Place(), column, Text(column)));
  return value;
}

std::string CsvReader::Place() const {
  return fmt::format("{}, line {}", name_, records_->record_line());
}

std::vector<std::string> ParseCsvRecord(const std::string& name,
                                        const std::string& text) {
  RecordReader reader(name, text);
  std::vector<std::string> fields;
  if (!reader.ReadLast(&fields))
    throw InputError(
        name + ": more than one line; quote names that contain line breaks");
  return fields;
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos &&
      text == Trim(text) && text.compare(0, 1, "#") != 0)
    return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? "\"\"" : std::string(1, c);
  return field + "\"";
}

}  // namespace raygrid
