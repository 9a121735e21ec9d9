// `slipctl export`: a recording as an MCAP file of ROS 2 messages, or as CSV. Needs no daemon.
#pragma once

#include <string>

namespace slipctl {

struct ExportOptions {
  std::string file;    // the recording
  std::string mcap;    // the MCAP file to write; empty: none
  std::string csv;     // the CSV file to write; empty: none
  std::string prefix;  // what topics begin with, "/slipd"
  bool force = false;  // replace files that exist
};

// Writes what was asked for. True: the recording was whole; else what is missing was printed on stderr, and
// the rest was written. Throws ClientError for a file that is no recording or has no frame, and for one that
// cannot be written.
bool export_recording(const ExportOptions& options);

}  // namespace slipctl
