// What a simulated device does wrong, on demand. Orders are short texts, the same from a command line, a
// control socket or a test, and apply to the next scans:
//   lose [N]      a part of each of N scans (1 unless said) never comes, or the scan if it has one part
//   reorder [N]   parts come in reverse
//   repeat [N]    each part comes twice
//   garbage [N]   a part is noise of the right length
//   shorten [N]   a part lacks its second half
//   lengthen [N]  a part has three bytes too many
//   stall [N]     nothing is said for N scans; a device that is asked does not answer
//   unplug, plug  the cable
//   quit          the program ends
#pragma once

#include <random>
#include <string>

#include "tests/devices/bytes.hpp"

namespace slipd::devices {

class Misbehaviour {
 public:
  enum class Kind : std::uint8_t {
    none,
    lose,
    reorder,
    repeat,
    garbage,
    shorten,
    lengthen,
    stall,
    unplug,
    plug,
    quit
  };

  struct Order {
    Kind kind = Kind::none;
    int scans = 1;
    std::string text() const;  // the order as text: "lose 3"
  };

  // Throws std::invalid_argument, which lists the valid orders.
  static Order parse(const std::string& text);

  // Distorts one scan. Kinds that concern no part of a scan leave it unchanged.
  void distort(Kind kind, std::vector<Packet>& scan);

 private:
  std::mt19937 random_{1};  // NOLINT(cert-msc51-cpp): noise that is the same in every run
};

}  // namespace slipd::devices
