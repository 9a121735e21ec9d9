// What Cyclone DDS logs goes to this program's log. A sample whose bytes are no message of its type never
// comes to a subscription, and Cyclone says so in a line for each: these are counted instead. One object at a
// time in a process; it must live longer than the node.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

namespace slipd::ros2 {

// The topic, "/left/taxels", of a line in which Cyclone 0.10 says that it cannot read a sample; none: it is
// another line.
std::optional<std::string_view> topic_of_refusal(std::string_view line);

class CycloneLog {
 public:
  // False: nobody counts for this topic.
  using Refused = std::function<bool(std::string_view topic)>;

  // `refused` is called in Cyclone's threads; it must not throw.
  explicit CycloneLog(Refused refused);
  ~CycloneLog();
  CycloneLog(const CycloneLog&) = delete;
  CycloneLog& operator=(const CycloneLog&) = delete;

 private:
  Refused refused_;
};

}  // namespace slipd::ros2
