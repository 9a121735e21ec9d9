// The commands that ask once and print: results on stdout, as tables for people or as the daemon's own JSON.
#pragma once

#include <string>

namespace slipctl {

struct CommonOptions {
  std::string socket;
  bool json = false;
};

struct RecordOptions {
  std::string sensor;
  double seconds = 10;
  std::string out;
  bool force = false;  // overwrite
};

// All throw ClientError.
void print_status(const CommonOptions& common);
void print_sensors(const CommonOptions& common);
void print_gamma(const CommonOptions& common, const std::string& sensor);  // empty: all
void print_frame(const CommonOptions& common, const std::string& sensor);  // CSV, one taxel a line
void print_metrics(const CommonOptions& common);                           // OpenMetrics text
// Has the flight recorder keep the last seconds; empty: of all sensors.
void keep_flight(const CommonOptions& common, const std::string& sensor);
void print_dbc(const CommonOptions& common);  // the CAN messages' definition
void rebias(const CommonOptions& common, const std::string& sensor, bool force);

// Opens the file here, with the user's own rights, and lets the daemon's writer fill it.
void record(const CommonOptions& common, const RecordOptions& options);

}  // namespace slipctl
