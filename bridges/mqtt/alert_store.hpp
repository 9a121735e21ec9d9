// Alerts that no broker has acknowledged: an SQLite database, which survives a crash and a loss of power. One
// thread's own; calls wait for the disk.
//
// An alert is on disk before its number is given out, so no number of a series stands for two alerts.
// Acknowledged alerts are removed together, at flush(): after a crash before it they are sent once more under
// the same number.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

struct sqlite3;

namespace slipd::mqtt {

struct StoredAlert {
  // From 1, in the order of append().
  std::int64_t number = 0;
  // Where it goes, and what.
  std::string topic, payload;
};

class AlertStore {
 public:
  // Makes the payload of the alert with this number; `dropped`: as dropped() once it is stored.
  using MakePayload = std::function<std::string(std::int64_t number, std::int64_t dropped)>;

  // Opens or makes `file`. One that is damaged is renamed to FILE.damaged and a new series begins. Throws
  // std::runtime_error that names the file.
  AlertStore(std::filesystem::path file, std::int64_t max_alerts);
  ~AlertStore();
  AlertStore(const AlertStore&) = delete;
  AlertStore& operator=(const AlertStore&) = delete;

  // Adds an alert behind all others, and returns its number. In a full store the oldest is dropped and
  // counted. None: it could not be written, which is counted as dropped. `begun_ns`: CLOCK_REALTIME, for
  // last_hour(); 0: it is the end of an alert, which is not counted. `stands`: for standing().
  std::optional<std::int64_t> append(const std::string& topic, const MakePayload& payload,
                                     std::int64_t begun_ns = 0, int stands = 0);

  // `stands` of the alert of this topic that was appended last, also before a restart, and whether or not a
  // broker has it. 0: there was none, or the disk refused to say.
  int standing(const std::string& topic);

  // Alerts that were appended with a `begun_ns` of the hour up to `now_ns`, CLOCK_REALTIME, also before a
  // restart, and whether or not a broker has them; at most kMostCounted. None: the disk refused to say.
  std::optional<std::int64_t> last_hour(std::int64_t now_ns);
  static constexpr std::int64_t kMostCounted = 100'000;

  // The first alert behind `number`; none if there is none.
  std::optional<StoredAlert> after(std::int64_t number);

  // A broker has it. It is no longer waiting.
  void acknowledge(std::int64_t number);
  // Removes the acknowledged alerts from the disk.
  void flush();

  // Name of this series of numbers: 32 hexadecimal digits.
  const std::string& series() const noexcept { return series_; }
  // The last number given out; 0: none.
  std::int64_t last() const noexcept { return last_; }
  // Alerts without an acknowledgement.
  std::int64_t waiting() const noexcept { return waiting_; }
  // Alerts of this series that were dropped.
  std::int64_t dropped() const noexcept { return dropped_; }
  // Why the disk refused something last; empty: nothing.
  const std::string& trouble() const noexcept { return trouble_; }

 private:
  struct Close {
    void operator()(sqlite3* database) const noexcept;
  };
  void open();
  void load();
  void run(const char* sql);
  void note_begin(std::int64_t begun_ns);

  std::filesystem::path file_;
  std::int64_t max_alerts_;
  std::unique_ptr<sqlite3, Close> database_;
  std::string series_, trouble_;
  std::int64_t last_ = 0, waiting_ = 0, dropped_ = 0;
  std::vector<std::int64_t> acknowledged_;  // not yet removed
};

}  // namespace slipd::mqtt
