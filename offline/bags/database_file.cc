// rosbag2's SQLite files: the tables topics and messages.
#include <fmt/format.h>
#include <sqlite3.h>

#include <filesystem>
#include <map>
#include <mutex>

#include "bags/bag_file.h"
#include "bags/compression.h"
#include "bags/random_access_file.h"
#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const {
    sqlite3_finalize(statement);
  }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;

// A query of a database from an untrusted source.
class Query {
 public:
  Query(sqlite3* database, const std::string& path, const char* sql)
      : database_(database), name_(path) {
    sqlite3_stmt* statement = nullptr;
    Require(sqlite3_prepare_v2(database, sql, -1, &statement, nullptr));
    statement_.reset(statement);
  }
  // Returns false after the last row.
  bool Next() {
    const int result = sqlite3_step(statement_.get());
    if (result != SQLITE_DONE && result != SQLITE_ROW) Require(result);
    return result == SQLITE_ROW;
  }
  void Bind(int64_t value) {
    Require(sqlite3_bind_int64(statement_.get(), 1, value));
  }
  int64_t Integer(int column) {
    return sqlite3_column_int64(statement_.get(), column);
  }
  std::string_view Bytes(int column) {
    const void* const bytes = sqlite3_column_blob(statement_.get(), column);
    const int count = sqlite3_column_bytes(statement_.get(), column);
    return bytes ? std::string_view(static_cast<const char*>(bytes), count)
                 : std::string_view();
  }

 private:
  void Require(int result) const {
    if (result == SQLITE_OK) return;
    throw InputError(fmt::format("{}: not a readable rosbag2 database ({})",
                                 name_, Printable(sqlite3_errmsg(database_))));
  }

  sqlite3* database_;
  const std::string& name_;
  std::unique_ptr<sqlite3_stmt, FinalizeStatement> statement_;
};

// Allows queries of tables only: a recursive view could run forever.
int AllowReading(void*, int action, const char*, const char*, const char*,
                 const char* view) {
  const bool reads = action == SQLITE_SELECT || action == SQLITE_READ;
  return reads && !view ? SQLITE_OK : SQLITE_DENY;
}

std::string UriPath(const std::string& path) {
  std::string uri = "file:";
  for (const unsigned char c : path)
    uri += std::isalnum(c) || c == '/' || c == '.' ? std::string(1, c)
                                                   : fmt::format("%{:02X}", c);
  return uri;
}

class DatabaseFile : public BagFile {
 public:
  DatabaseFile(const std::string& path, const std::string& name) : name_(name) {
    const RandomAccessFile readable(path, name);
    // Read-only folders do not allow the lock files of a database that was not
    // closed.
    if (Open(UriPath(path) + "?mode=ro")) return;
    RequireNoOpenTransaction(path);
    if (Open(UriPath(path) + "?mode=ro&immutable=1")) return;
    Query(database_.get(), name_, "SELECT id FROM messages LIMIT 1").Next();
  }

  void Scan(const BagVisitor& visitor) override;
  std::string Read(const MessagePlace& place) const override;

 private:
  bool Open(const std::string& uri);
  void RequireNoOpenTransaction(const std::string& path) const;
  void ScanMessages(const std::map<int64_t, size_t>& topics,
                    const BagVisitor& visitor);

  std::string name_;
  Database database_;
  mutable std::mutex mutex_;
};

bool DatabaseFile::Open(const std::string& uri) {
  sqlite3* opened = nullptr;
  const int result = sqlite3_open_v2(
      uri.c_str(), &opened,
      SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
  database_.reset(opened);
  if (!opened) throw InputError(name_ + ": cannot be read (out of memory)");
  sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, static_cast<int>(kMaxChunkBytes));
  sqlite3_set_authorizer(opened, AllowReading, nullptr);
  return result == SQLITE_OK &&
         sqlite3_exec(opened, "SELECT id FROM messages LIMIT 1", nullptr,
                      nullptr, nullptr) == SQLITE_OK;
}

// Throws if messages, or what restores the database, are in a second file,
// which immutable databases ignore.
void DatabaseFile::RequireNoOpenTransaction(const std::string& path) const {
  for (const char* ending : {"-wal", "-journal"}) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path + ending, error);
    if (!error && size > 0)
      throw InputError(fmt::format(
          "{0}: was not closed, and is incomplete without {0}{1}; copy both "
          "files to a writable folder, and there run 'sqlite3 FILE \"PRAGMA "
          "quick_check\"'",
          name_, ending));
  }
}

void DatabaseFile::Scan(const BagVisitor& visitor) {
  std::map<int64_t, size_t> topics;
  Query rows(database_.get(), name_,
             "SELECT id, name, type, serialization_format FROM topics");
  while (rows.Next())
    topics[rows.Integer(0)] = visitor.add_topic(std::string(rows.Bytes(1)),
                                                std::string(rows.Bytes(2)),
                                                std::string(rows.Bytes(3)));
  try {
    ScanMessages(topics, visitor);
  } catch (const InputError& error) {
    visitor.remark(fmt::format("{}; it was read up to there", error.what()));
  }
}

void DatabaseFile::ScanMessages(const std::map<int64_t, size_t>& topics,
                                const BagVisitor& visitor) {
  Query last(database_.get(), name_,
             "SELECT id FROM messages ORDER BY id DESC "
             "LIMIT 1");
  const auto num_rows = static_cast<double>(last.Next() ? last.Integer(0) : 1);
  Query rows(database_.get(), name_,
             "SELECT id, topic_id, timestamp, data FROM messages ORDER BY id");
  uint64_t num_unknown = 0;
  while (rows.Next()) {
    const auto topic = topics.find(rows.Integer(1));
    if (topic == topics.end()) {
      ++num_unknown;
      continue;
    }
    BagMessage message;
    message.topic = topic->second;
    message.log_ns = rows.Integer(2);
    message.data = rows.Bytes(3);
    message.place = {0, rows.Integer(0), 0, message.data.size()};
    visitor.visit(message);
    visitor.progress(static_cast<double>(rows.Integer(0)) / num_rows);
  }
  if (num_unknown > 0)
    visitor.remark(
        fmt::format("{}: {} messages of undeclared topics were skipped", name_,
                    num_unknown));
}

std::string DatabaseFile::Read(const MessagePlace& place) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Query row(database_.get(), name_, "SELECT data FROM messages WHERE id = ?");
  row.Bind(place.chunk);
  if (!row.Next()) throw InputError("the file was changed");
  return ExtractMessage(std::string(row.Bytes(0)), place);
}

}  // namespace

std::unique_ptr<BagFile> OpenDatabaseFile(const std::string& path,
                                          const std::string& name) {
  return std::make_unique<DatabaseFile>(path, name);
}

}  // namespace raygrid
