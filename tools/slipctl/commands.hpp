// The commands that send one request and print the result on stdout, as a table or as the daemon's JSON.
#pragma once

#include <string>

namespace slipctl {

struct CommonOptions {
  std::string socket;  // path of the daemon's socket
  bool json = false;   // print the daemon's JSON
};

struct RecordOptions {
  std::string sensor;   // its name
  double seconds = 10;  // length of the recording, s, > 0
  std::string out;      // the file
  bool force = false;   // overwrite an existing file
};

// All throw ClientError.
void print_status(const CommonOptions& common);
void print_sensors(const CommonOptions& common);
void print_gamma(const CommonOptions& common, const std::string& name);    // a sensor or grasp; empty: all
void print_frame(const CommonOptions& common, const std::string& sensor);  // CSV, one taxel a line
void print_metrics(const CommonOptions& common);                           // OpenMetrics text
// Makes the flight recorder write the last seconds to a file; empty: of all sensors.
// 0: all recordings are written; 1: one has failed; the reason is on stderr.
int keep_flight(const CommonOptions& common, const std::string& sensor);
void print_dbc(const CommonOptions& common);  // the CAN messages as a DBC file
void rebias(const CommonOptions& common, const std::string& sensor, bool force);
// sensor: empty: all that see displacements; seconds: 0 … 60.
void releasing(const CommonOptions& common, const std::string& sensor, double seconds);

// Reads a recording from the daemon into a file that the user may write.
void record(const CommonOptions& common, const RecordOptions& options);

}  // namespace slipctl
