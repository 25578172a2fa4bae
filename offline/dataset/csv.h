#ifndef RAYGRID_DATASET_CSV_H
#define RAYGRID_DATASET_CSV_H

#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace raygrid {

/// Reads a CSV text with a header line row by row, as RFC 4180 has it: a field
/// in quotes holds commas, line ends and, written twice, quotes. Beyond it,
/// lines that begin with '#' and empty lines are skipped, and spaces around
/// fields are no part of them. Numbers are read without regard to the locale.
/// It keeps no row but the current one, so memory is that of the text.
class CsvReader {
 public:
  /// name is used in errors; name and text must outlive the reader. Throws
  /// InputError if the text is not UTF-8, or its header lacks a required column
  /// or has one twice.
  CsvReader(const std::string& name, const std::string& text,
            const std::vector<std::string>& required_columns);
  CsvReader(CsvReader&&) noexcept;
  ~CsvReader();

  bool HasColumn(const std::string& column) const;

  /// Goes to the next row; false behind the last one. Throws InputError for a
  /// row with another number of fields than the header, or more than 1000, and
  /// for more than max_rows.
  bool Next();

  /// Throws InputError, naming the limit, in Next() of a longer file.
  void LimitRows(size_t max_rows) { max_rows_ = max_rows; }

  /// A field of the current row.
  const std::string& Text(const std::string& column) const;
  /// Finite number or integer; throws InputError naming file, line and column.
  double Number(const std::string& column) const;
  int Integer(const std::string& column) const;

  /// "file, line 7": for further errors about the current row.
  std::string Place() const;

 private:
  class Records;
  int ColumnIndex(const std::string& column) const;

  const std::string& name_;
  std::unique_ptr<Records> records_;
  std::vector<std::string> header_, fields_;
  size_t num_rows_ = 0, max_rows_ = std::numeric_limits<size_t>::max();
};

/// The fields of a text of one record, as CsvReader has them, but with no
/// comments; name is used in errors. Throws InputError.
std::vector<std::string> ParseCsvRecord(const std::string& name,
                                        const std::string& text);

/// Text as a field, in quotes if it needs them.
std::string CsvField(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CSV_H
