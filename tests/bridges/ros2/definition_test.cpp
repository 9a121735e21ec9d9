// Definitions: type hashes by REP-2011, .msg texts, names.
#include "bridges/ros2/messages/definition.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>

namespace slipd::ros2 {
namespace {

std::string sha256_of(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned bytes = 0;
  EVP_Digest(text.data(), text.size(), digest.data(), &bytes, EVP_sha256(), nullptr);
  std::string hex;
  for (unsigned i = 0; i < bytes; ++i) {
    std::array<char, 3> two{};
    std::snprintf(two.data(), two.size(), "%02x", digest.at(i));
    hex += two.data();
  }
  return hex;
}

template <class T>
std::string computed_hash() {
  return sha256_of(type_description(definitions_of<T>()));
}

// The public values of these types are in ROS 2's own .json descriptions.
TEST(TypeHashes, OfStandardMessagesAreThePublicOnes) {
  EXPECT_EQ(computed_hash<WrenchStamped>(),
            "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77");
  EXPECT_EQ(computed_hash<Float32>(), "7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2");
  EXPECT_EQ(computed_hash<Float32MultiArray>(),
            "0599f6f85b4bfca379873a0b4375a0aca022156bd2d7021275d116ed1fa8bfe0");
  EXPECT_EQ(computed_hash<DiagnosticArray>(),
            "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e");
  EXPECT_EQ(computed_hash<PointCloud2>(), "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5");
}

TEST(TypeHashes, AreThoseThatTheFieldsGive) {
  EXPECT_EQ(WrenchStamped::kTypeHash, computed_hash<WrenchStamped>());
  EXPECT_EQ(Float32::kTypeHash, computed_hash<Float32>());
  EXPECT_EQ(DiagnosticArray::kTypeHash, computed_hash<DiagnosticArray>());
  EXPECT_EQ(PointCloud2::kTypeHash, computed_hash<PointCloud2>());
  EXPECT_EQ(Float32MultiArray::kTypeHash, computed_hash<Float32MultiArray>());
  EXPECT_EQ(SlipEstimate::kTypeHash, computed_hash<SlipEstimate>());
  EXPECT_EQ(ParticipantEntitiesInfo<kGidBytes>::kTypeHash,
            computed_hash<ParticipantEntitiesInfo<kGidBytes>>());
}

TEST(MessageTexts, HaveAllMessagesThatTheyNeedOnce) {
  EXPECT_EQ(msg_text(definitions_of<WrenchStamped>()),
            "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n" + std::string(80, '=') +
                "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" +
                std::string(80, '=') + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" +
                std::string(80, '=') +
                "\nMSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n" +
                std::string(80, '=') + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n");
}

// A .msg file without comments, its constants first.
std::string without_comments(const std::string& file) {
  std::ifstream in(file);
  EXPECT_TRUE(in) << file;
  std::string constants;
  std::string fields;
  for (std::string line; std::getline(in, line);) {
    line = line.substr(0, line.find('#'));
    line.erase(line.find_last_not_of(' ') + 1);
    if (line.empty()) continue;
    (line.find('=') == std::string::npos ? fields : constants) += line + "\n";
  }
  return constants + fields;
}

TEST(MessageTexts, AreThoseOfThePackageSlipdMsgs) {
  EXPECT_EQ(without_comments(SLIPD_SOURCE_DIR "/bridges/ros2/slipd_msgs/msg/SlipEstimate.msg"),
            msg_text(definitions_of<SlipEstimate>().front()));
}

// OMG IDL 4.2, table 7-6. Names that differ in case only collide, too.
constexpr const char* kIdlKeywords[] = {
    "abstract",  "any",      "alias",      "attribute", "bitfield", "bitmask",    "bitset",      "boolean",
    "case",      "char",     "component",  "connector", "const",    "consumes",   "context",     "custom",
    "default",   "double",   "exception",  "emits",     "enum",     "eventtype",  "factory",     "false",
    "finder",    "fixed",    "float",      "getraises", "home",     "import",     "in",          "inout",
    "interface", "local",    "long",       "manages",   "map",      "mirrorport", "module",      "multiple",
    "native",    "object",   "octet",      "oneway",    "out",      "primarykey", "private",     "port",
    "porttype",  "provides", "public",     "publishes", "raises",   "readonly",   "setraises",   "sequence",
    "short",     "string",   "struct",     "supports",  "switch",   "true",       "truncatable", "typedef",
    "typeid",    "typename", "typeprefix", "unsigned",  "union",    "uses",       "valuebase",   "valuetype",
    "void",      "wchar",    "wstring",    "int8",      "uint8",    "int16",      "int32",       "int64",
    "uint16",    "uint32",   "uint64"};

template <class T>
void expect_no_keyword() {
  for (const Definition& definition : definitions_of<T>()) {
    ASSERT_FALSE(definition.fields.empty());
    for (const Field& field : definition.fields) {
      std::string name = field.name;
      std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
      EXPECT_EQ(std::count(std::begin(kIdlKeywords), std::end(kIdlKeywords), name), 0)
          << field.name << " of " << definition.name << " is a keyword of IDL, which fastddsgen refuses";
    }
  }
}

TEST(Names, OfFieldsAreNoKeywordsOfIdl) {
  expect_no_keyword<SlipEstimate>();
  expect_no_keyword<WrenchStamped>();
  expect_no_keyword<Float32>();
  expect_no_keyword<PointCloud2>();
  expect_no_keyword<DiagnosticArray>();
}

TEST(Names, AreThoseOfDds) {
  EXPECT_EQ(dds_name(WrenchStamped::kName), "geometry_msgs::msg::dds_::WrenchStamped_");
  EXPECT_EQ(short_name(WrenchStamped::kName), "geometry_msgs/WrenchStamped");
}

}  // namespace
}  // namespace slipd::ros2
