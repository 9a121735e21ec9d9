// `slipctl import`: a topic of an MCAP file, such as rosbag2 writes, as a recording. The messages are read by
// the profiles and decoders of slipd-feed-ros2. Needs no daemon.
#pragma once

#include <string>
#include <vector>

namespace slipctl {

struct ImportOptions {
  std::string file;           // the MCAP file
  std::string out;            // the recording to write
  std::string topic;          // empty: the profile's
  std::string profile;        // as in slipd-feed-ros2's settings
  std::string frame_id;       // only messages with it; empty: all
  std::string sensor;         // the recording's sensor, "sensor"
  std::string grid;           // "4x4": columns and rows; empty: `taxels_mm`
  double pitch_mm = 0;        // of the grid
  std::string taxels_mm;      // "0,0 -6,0 6,0"
  std::vector<double> scale;  // of x, y and z; empty: 1
  bool force = false;         // replace a file that exists
};

// Writes the recording and says on stderr what became no frame. True: every message of the topic is a frame.
// Throws ClientError for options that contradict each other, for a file that is no MCAP file or has no frame
// on the topic, and for one that cannot be written.
bool import_recording(const ImportOptions& options);

}  // namespace slipctl
