#ifndef RAYGRID_DATASET_CSV_H
#define RAYGRID_DATASET_CSV_H

#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace raygrid {

/// Reads a CSV text with a header line row by row, as in RFC 4180: quoted
/// fields can contain commas, line ends and doubled quotes. In addition, lines
/// that begin with '#' and empty lines are skipped, and spaces around fields
/// are ignored. Numbers do not depend on the locale. Only the current row is
/// stored in addition to the text.
class CsvReader {
 public:
  /// name is used in errors; name and text must outlive the reader. Throws
  /// InputError if the text is not UTF-8, or its header lacks a required column
  /// or repeats one.
  CsvReader(const std::string& name, const std::string& text,
            const std::vector<std::string>& required_columns);
  CsvReader(CsvReader&&) noexcept;
  ~CsvReader();

  bool HasColumn(const std::string& column) const;
  /// Returns the columns in the order of the header.
  const std::vector<std::string>& columns() const { return header_; }

  /// Advances to the next row; returns false after the last one. Throws
  /// InputError if the number of fields differs from the header's or exceeds
  /// 1000, and for more than max_rows rows.
  bool Next();

  /// Makes Next() throw InputError, with the limit, for longer files.
  void LimitRows(size_t max_rows) { max_rows_ = max_rows; }

  /// Returns a field of the current row.
  const std::string& Text(const std::string& column) const;
  /// Returns a finite number or an integer. Throws InputError with file, line
  /// and column.
  double Number(const std::string& column) const;
  int Integer(const std::string& column) const;

  /// Returns "file, line 7", for further errors about the current row.
  std::string Place() const;

 private:
  class Records;
  int ColumnIndex(const std::string& column) const;

  const std::string& name_;
  std::unique_ptr<Records> records_;
  std::vector<std::string> header_, fields_;
  size_t num_rows_ = 0, max_rows_ = std::numeric_limits<size_t>::max();
};

/// Parses the fields of a single record, as CsvReader does, but without
/// comments; name is used in errors. Throws InputError.
std::vector<std::string> ParseCsvRecord(const std::string& name,
                                        const std::string& text);

/// Formats text as a field, quoted if necessary.
std::string CsvField(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CSV_H
