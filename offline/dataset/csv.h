#ifndef RAYGRID_DATASET_CSV_H
#define RAYGRID_DATASET_CSV_H

#include <string>
#include <vector>

namespace raygrid {

/// A CSV text with a header line, as RFC 4180 has it: a field in quotes holds
/// commas, line ends and, written twice, quotes. Beyond it, lines that begin
/// with '#' and empty lines are skipped, and spaces around fields are no part
/// of them. Numbers are read without regard to the locale.
class CsvTable {
 public:
  /// name is used in errors. Throws InputError if the text is not UTF-8, a
  /// required column is missing, a column is there twice, or a line has another
  /// number of fields than the header, or more than 1000.
  CsvTable(const std::string& name, const std::string& text,
           const std::vector<std::string>& required_columns);

  size_t num_rows() const { return rows_.size(); }
  bool HasColumn(const std::string& column) const;
  const std::string& Text(size_t row, const std::string& column) const;

  /// Finite number or integer; throws InputError naming file, line and column.
  double Number(size_t row, const std::string& column) const;
  int Integer(size_t row, const std::string& column) const;

  /// "file, line 7": for further errors about a row.
  std::string Place(size_t row) const;

 private:
  struct Row {
    int line;
    std::vector<std::string> fields;
  };
  int ColumnIndex(const std::string& column) const;

  std::string name_;
  std::vector<std::string> header_;
  std::vector<Row> rows_;
};

/// The fields of a text of one record, as CsvTable has them, but with no
/// comments; name is used in errors. Throws InputError.
std::vector<std::string> ParseCsvRecord(const std::string& name,
                                        const std::string& text);

/// Text as a field, in quotes if it needs them.
std::string CsvField(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CSV_H
