// Fields and constants of the standard messages, compared with the .msg files of Debian's packages ros-*-msgs
// (tools/setup --peers). These are of ROS 1, which ROS 2 took the messages from. Type hashes cover no
// constants; this does.
#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "bridges/ros2/messages/definition.hpp"

namespace slipd::ros2 {
namespace {

// ROS 1's name of a field's type as ROS 2 has it.
std::string modern_type(const std::string& type, const std::string& package) {
  if (type == "time") return "builtin_interfaces/Time";
  if (type == "Header") return "std_msgs/Header";
  const bool message = std::isupper(static_cast<unsigned char>(type.front())) != 0;
  return message ? package + "/" + type : type;
}

// The .msg text of a file, in the form of msg_text(). Header's `seq` is not in ROS 2.
std::string modern_text(const std::filesystem::path& file, const std::string& package) {
  static const std::regex parts(R"(^\s*(\S+)\s+(\w+)\s*(=\s*(\S+))?\s*(#.*)?$)");
  std::ifstream in(file);
  EXPECT_TRUE(in) << file;
  std::string constants;
  std::string fields;
  for (std::string line; std::getline(in, line);) {
    std::smatch part;
    if (line.starts_with('#') || !std::regex_match(line, part, parts)) continue;
    if (file.filename() == "Header.msg" && part[2] == "seq") continue;
    const std::string begin = modern_type(part[1], package) + " " + part[2].str();
    (part[4].matched ? constants : fields) += begin + (part[4].matched ? "=" + part[4].str() : "") + "\n";
  }
  return constants + fields;
}

template <class T>
void expect_debians() {
  for (const Definition& definition : definitions_of<T>()) {
    const std::string name = short_name(definition.name);
    const std::size_t slash = name.find('/');
    const std::string package = name.substr(0, slash);
    if (package == "builtin_interfaces") continue;  // ROS 1 has its type `time` instead
    const std::filesystem::path folder = std::filesystem::path("/usr/share") / package / "msg";
    if (!std::filesystem::exists(folder))
      GTEST_SKIP() << folder << " is missing: tools/setup --peers installs it";
    EXPECT_EQ(msg_text(definition), modern_text(folder / (name.substr(slash + 1) + ".msg"), package)) << name;
  }
}

TEST(DebiansMessages, HaveTheFieldsAndConstantsOfOurs) {
  expect_debians<Float32>();
  expect_debians<WrenchStamped>();
  expect_debians<PointCloud2>();
  expect_debians<DiagnosticArray>();
}

}  // namespace
}  // namespace slipd::ros2
