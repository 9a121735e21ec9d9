#include "bridges/mqtt/alert_store.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>

#include "bridges/support/log.hpp"

namespace slipd::mqtt {
namespace {

// The file is no database, or its content contradicts itself.
class Damaged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[noreturn]] void throw_error_of(sqlite3* database) {
  const int code = sqlite3_errcode(database);
  if (code == SQLITE_CORRUPT || code == SQLITE_NOTADB) throw Damaged(sqlite3_errmsg(database));
  throw std::runtime_error(sqlite3_errmsg(database));
}

// One statement. Throws std::runtime_error with SQLite's text.
class Statement {
 public:
  Statement(sqlite3* database, const char* sql) : database_(database) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(int at, std::int64_t value) {
    if (sqlite3_bind_int64(statement_, at, value) != SQLITE_OK) fail();
    return *this;
  }
  Statement& bind(int at, const std::string& value) {
    if (sqlite3_bind_text(statement_, at, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT) !=
        SQLITE_OK)
      fail();
    return *this;
  }
  // False: there is no further row.
  bool step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail();
    return code == SQLITE_ROW;
  }
  std::int64_t number(int column) { return sqlite3_column_int64(statement_, column); }
  std::string text(int column) {
    const auto* const bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
    return {bytes == nullptr ? "" : bytes,
            static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
  }

 private:
  [[noreturn]] void fail() const { throw_error_of(database_); }
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

// What a database needs to be usable, in one transaction each.
constexpr const char* kSetUp =
    "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA cache_size = -256;"
    "PRAGMA journal_size_limit = 1048576;"
    "CREATE TABLE IF NOT EXISTS alerts (number INTEGER PRIMARY KEY AUTOINCREMENT, topic TEXT NOT NULL,"
    " payload TEXT NOT NULL);"
    "CREATE TABLE IF NOT EXISTS facts (one INTEGER PRIMARY KEY CHECK (one = 1), series TEXT NOT NULL,"
    " dropped INTEGER NOT NULL);"
    "INSERT OR IGNORE INTO facts VALUES (1, lower(hex(randomblob(16))), 0);"
    "CREATE TABLE IF NOT EXISTS begun (time_ns INTEGER NOT NULL);"
    "CREATE INDEX IF NOT EXISTS begun_time ON begun (time_ns);"
    "CREATE TABLE IF NOT EXISTS standing (topic TEXT PRIMARY KEY, stands INTEGER NOT NULL);";

constexpr std::int64_t kHourNs = std::int64_t{3600} * 1'000'000'000;

}  // namespace

void AlertStore::Close::operator()(sqlite3* database) const noexcept {
  sqlite3_close_v2(database);
}

AlertStore::AlertStore(std::filesystem::path file, std::int64_t max_alerts)
    : file_(std::move(file)), max_alerts_(max_alerts) {
  try {
    open();
  } catch (const Damaged& error) {
    database_.reset();
    std::filesystem::rename(file_, file_.string() + ".damaged");
    for (const char* beside : {"-wal", "-shm"}) {
      std::error_code ignored;
      std::filesystem::remove(file_.string() + beside, ignored);
    }
    bridges::log(bridges::LogLevel::error, file_.string() + ": " + error.what() + "; it is now " +
                                               file_.string() +
                                               ".damaged, and a new series of alerts begins");
    open();
  }
}

AlertStore::~AlertStore() {
  try {
    flush();
  } catch (const std::exception&) {  // they are sent once more
  }
}

void AlertStore::open() {
  sqlite3* made = nullptr;
  const int code = sqlite3_open_v2(file_.c_str(), &made,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  database_.reset(made);
  if (made == nullptr) throw std::bad_alloc();
  if (code != SQLITE_OK) throw std::runtime_error(file_.string() + ": " + sqlite3_errmsg(made));
  run(kSetUp);
  load();
}

void AlertStore::load() {
  Statement check(database_.get(), "PRAGMA quick_check");
  if (check.step() && check.text(0) != "ok") throw Damaged(check.text(0));
  Statement facts(database_.get(), "SELECT series, dropped FROM facts");
  if (!facts.step()) throw Damaged("it has no series");
  series_ = facts.text(0);
  dropped_ = facts.number(1);
  Statement count(database_.get(), "SELECT count(*) FROM alerts");
  waiting_ = count.step() ? count.number(0) : 0;
  Statement last(database_.get(), "SELECT seq FROM sqlite_sequence WHERE name = 'alerts'");
  last_ = last.step() ? last.number(0) : 0;
}

void AlertStore::run(const char* sql) {
  if (sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK)
    throw_error_of(database_.get());
}

// Notes when an alert began, and forgets those that last_hour() no longer counts.
void AlertStore::note_begin(std::int64_t begun_ns) {
  Statement(database_.get(),
            "DELETE FROM begun WHERE time_ns <= ? OR rowid <= (SELECT max(rowid) FROM begun) - ?")
      .bind(1, begun_ns - kHourNs)
      .bind(2, kMostCounted - 1)
      .step();
  Statement(database_.get(), "INSERT INTO begun VALUES (?)").bind(1, begun_ns).step();
}

std::optional<std::int64_t> AlertStore::last_hour(std::int64_t now_ns) {
  try {
    Statement counted(database_.get(), "SELECT count(*) FROM begun WHERE time_ns > ? AND time_ns <= ?");
    counted.bind(1, now_ns - kHourNs).bind(2, now_ns);
    return counted.step() ? counted.number(0) : 0;
  } catch (const std::runtime_error& error) {
    trouble_ = error.what();
    return std::nullopt;
  }
}

std::optional<std::int64_t> AlertStore::append(const std::string& topic, const MakePayload& payload,
                                               std::int64_t begun_ns, int stands) {
  flush();
  const std::int64_t number = last_ + 1;
  const std::int64_t surplus = std::max<std::int64_t>(0, waiting_ + 1 - max_alerts_);
  try {
    run("BEGIN IMMEDIATE");
    Statement(database_.get(),
              "DELETE FROM alerts WHERE number IN (SELECT number FROM alerts ORDER BY number LIMIT ?)")
        .bind(1, surplus)
        .step();
    Statement(database_.get(), "UPDATE facts SET dropped = ?").bind(1, dropped_ + surplus).step();
    Statement(database_.get(), "INSERT INTO alerts (number, topic, payload) VALUES (?, ?, ?)")
        .bind(1, number)
        .bind(2, topic)
        .bind(3, payload(number, dropped_ + surplus))
        .step();
    if (begun_ns > 0) note_begin(begun_ns);
    Statement(database_.get(), "INSERT OR REPLACE INTO standing VALUES (?, ?)")
        .bind(1, topic)
        .bind(2, stands)
        .step();
    run("COMMIT");
  } catch (const std::runtime_error& error) {
    sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    ++dropped_;  // on disk with the next alert that can be written
    trouble_ = error.what();
    return std::nullopt;
  }
  last_ = number;
  dropped_ += surplus;
  waiting_ += 1 - surplus;
  trouble_.clear();
  return number;
}

int AlertStore::standing(const std::string& topic) {
  try {
    Statement last(database_.get(), "SELECT stands FROM standing WHERE topic = ?");
    last.bind(1, topic);
    return last.step() ? static_cast<int>(last.number(0)) : 0;
  } catch (const std::runtime_error& error) {
    trouble_ = error.what();
    return 0;
  }
}

std::optional<StoredAlert> AlertStore::after(std::int64_t number) {
  try {
    Statement next(database_.get(),
                   "SELECT number, topic, payload FROM alerts WHERE number > ? ORDER BY number LIMIT 1");
    next.bind(1, number);
    if (!next.step()) return std::nullopt;
    return StoredAlert{next.number(0), next.text(1), next.text(2)};
  } catch (const std::runtime_error& error) {
    trouble_ = error.what();
    return std::nullopt;
  }
}

void AlertStore::acknowledge(std::int64_t number) {
  acknowledged_.push_back(number);
}

void AlertStore::flush() {
  if (acknowledged_.empty()) return;
  try {
    run("BEGIN IMMEDIATE");
    std::int64_t removed = 0;
    for (const std::int64_t number : acknowledged_) {
      Statement(database_.get(), "DELETE FROM alerts WHERE number = ?").bind(1, number).step();
      removed += sqlite3_changes(database_.get());  // 0: it was dropped meanwhile
    }
    run("COMMIT");
    waiting_ -= removed;
    acknowledged_.clear();
  } catch (const std::runtime_error& error) {
    sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    trouble_ = error.what();
  }
}

}  // namespace slipd::mqtt
