// The ROS 2 messages that slipd writes and reads: the one table of their names, fields and order. Encoder and
// decoder (cdr.hpp), the .msg text and the type hashes (definition.hpp) are all made from `fields`. Values;
// any thread.
//
// Standard messages are those of the packages builtin_interfaces, std_msgs, geometry_msgs, sensor_msgs,
// diagnostic_msgs and rmw_dds_common as released with Humble and Jazzy; the type hashes are those of Iron and
// later, `RIHS01_` and SHA-256 of REP-2011's type description. tests/bridges/ros2 computes them from the
// fields.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace slipd::ros2 {

// An unknown number.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// `byte` of a .msg file: eight bits that are no number.
struct Byte {
  std::uint8_t value = 0;
};

// `string<=MOST` of a .msg file.
template <std::size_t MOST>
struct BoundedString {
  static constexpr std::size_t kMost = MOST;
  std::string text;
};

struct Time {
  static constexpr std::string_view kName = "builtin_interfaces/msg/Time";
  std::int32_t sec = 0;       // s since 1970
  std::uint32_t nanosec = 0;  // 0 to 999999999
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("sec", m.sec);
    visit("nanosec", m.nanosec);
  }
};

struct Header {
  static constexpr std::string_view kName = "std_msgs/msg/Header";
  Time stamp;
  std::string frame_id;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("stamp", m.stamp);
    visit("frame_id", m.frame_id);
  }
};

struct Float32 {
  static constexpr std::string_view kName = "std_msgs/msg/Float32";
  static constexpr std::string_view kTypeHash =
      "7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2";
  float data = std::numeric_limits<float>::quiet_NaN();
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("data", m.data);
  }
};

struct MultiArrayDimension {
  static constexpr std::string_view kName = "std_msgs/msg/MultiArrayDimension";
  std::string label;
  std::uint32_t size = 0;    // steps of this dimension
  std::uint32_t stride = 0;  // numbers of one step of the dimension before
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("label", m.label);
    visit("size", m.size);
    visit("stride", m.stride);
  }
};

struct MultiArrayLayout {
  static constexpr std::string_view kName = "std_msgs/msg/MultiArrayLayout";
  std::vector<MultiArrayDimension> dim;  // the outermost first; many publishers leave it empty
  std::uint32_t data_offset = 0;         // numbers in front of the first one
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("dim", m.dim);
    visit("data_offset", m.data_offset);
  }
};

struct Float32MultiArray {
  static constexpr std::string_view kName = "std_msgs/msg/Float32MultiArray";
  static constexpr std::string_view kTypeHash =
      "0599f6f85b4bfca379873a0b4375a0aca022156bd2d7021275d116ed1fa8bfe0";
  MultiArrayLayout layout;
  std::vector<float> data;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("layout", m.layout);
    visit("data", m.data);
  }
};

struct Vector3 {
  static constexpr std::string_view kName = "geometry_msgs/msg/Vector3";
  double x = kUnknown;
  double y = kUnknown;
  double z = kUnknown;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("x", m.x);
    visit("y", m.y);
    visit("z", m.z);
  }
};

struct Wrench {
  static constexpr std::string_view kName = "geometry_msgs/msg/Wrench";
  Vector3 force;   // N
  Vector3 torque;  // N m
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("force", m.force);
    visit("torque", m.torque);
  }
};

struct WrenchStamped {
  static constexpr std::string_view kName = "geometry_msgs/msg/WrenchStamped";
  static constexpr std::string_view kTypeHash =
      "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77";
  Header header;
  Wrench wrench;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("header", m.header);
    visit("wrench", m.wrench);
  }
};

struct PointField {
  static constexpr std::string_view kName = "sensor_msgs/msg/PointField";
  static constexpr std::string_view kConstants =
      "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n"
      "uint8 FLOAT32=7\nuint8 FLOAT64=8\n";
  static constexpr std::uint8_t kFloat32 = 7;
  std::string name;
  std::uint32_t offset = 0;  // in a point, bytes
  std::uint8_t datatype = kFloat32;
  std::uint32_t count = 1;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("name", m.name);
    visit("offset", m.offset);
    visit("datatype", m.datatype);
    visit("count", m.count);
  }
};

struct PointCloud2 {
  static constexpr std::string_view kName = "sensor_msgs/msg/PointCloud2";
  static constexpr std::string_view kTypeHash =
      "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5";
  Header header;
  std::uint32_t height = 0;  // rows of points
  std::uint32_t width = 0;   // points in a row
  std::vector<PointField> point_fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0;  // bytes of a point
  std::uint32_t row_step = 0;    // bytes of a row
  std::vector<std::uint8_t> data;
  bool is_dense = true;  // no point has an unknown coordinate
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("header", m.header);
    visit("height", m.height);
    visit("width", m.width);
    visit("fields", m.point_fields);
    visit("is_bigendian", m.is_bigendian);
    visit("point_step", m.point_step);
    visit("row_step", m.row_step);
    visit("data", m.data);
    visit("is_dense", m.is_dense);
  }
};

struct KeyValue {
  static constexpr std::string_view kName = "diagnostic_msgs/msg/KeyValue";
  std::string key;
  std::string value;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("key", m.key);
    visit("value", m.value);
  }
};

struct DiagnosticStatus {
  static constexpr std::string_view kName = "diagnostic_msgs/msg/DiagnosticStatus";
  static constexpr std::string_view kConstants = "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n";
  static constexpr std::uint8_t kOk = 0;
  static constexpr std::uint8_t kWarn = 1;
  static constexpr std::uint8_t kError = 2;
  static constexpr std::uint8_t kStale = 3;
  Byte level;
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("level", m.level);
    visit("name", m.name);
    visit("message", m.message);
    visit("hardware_id", m.hardware_id);
    visit("values", m.values);
  }
};

struct DiagnosticArray {
  static constexpr std::string_view kName = "diagnostic_msgs/msg/DiagnosticArray";
  static constexpr std::string_view kTypeHash =
      "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e";
  Header header;
  std::vector<DiagnosticStatus> status;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("header", m.header);
    visit("status", m.status);
  }
};

// What slipd says of one sensor or grasp: slipd_msgs/msg/SlipEstimate.msg describes each field. SI units.
struct SlipEstimate {
  static constexpr std::string_view kName = "slipd_msgs/msg/SlipEstimate";
  static constexpr std::string_view kTypeHash =
      "f53b2e6cc722b9d0c5f33933d914448c3770e3c0f0c0b1cb74bdd98ad2849d57";
  static constexpr std::string_view kConstants =
      "uint8 STATE_OK=0\nuint8 STATE_NO_CONTACT=1\nuint8 STATE_LEARNING=2\nuint8 STATE_OUT_OF_MODEL=3\n"
      "uint8 STATE_NO_SHEAR=4\nuint8 STATE_UNZEROED=5\nuint8 STATE_STALE=6\nuint8 STATE_FAULT=7\n"
      "uint8 STATE_DISCONNECTED=8\nuint8 ALERT_NONE=0\nuint8 ALERT_WARN=1\nuint8 ALERT_SLIP=2\n"
      "uint8 ALERT_UNKNOWN=3\n"
      "uint8 SLIDING_NONE=0\nuint8 SLIDING_DISTURBED=1\nuint8 SLIDING_TRANSLATION=2\n"
      "uint8 SLIDING_ROTATION=3\nuint8 SLIDING_UNKNOWN=255\n";
  static constexpr std::uint8_t kOk = 0;
  static constexpr std::uint8_t kNoContact = 1;
  static constexpr std::uint8_t kUnzeroed = 5;
  static constexpr std::uint8_t kStale = 6;
  static constexpr std::uint8_t kFault = 7;
  static constexpr std::uint8_t kDisconnected = 8;
  static constexpr std::uint8_t kAlertUnknown = 3;
  static constexpr std::uint8_t kSlidingUnknown = 255;
  Header header;
  std::string name;
  std::uint8_t state = kStale;
  std::uint8_t alert = kAlertUnknown;
  std::uint8_t sliding = kSlidingUnknown;
  bool simulated = false;
  std::uint64_t seq = 0;
  std::uint64_t dropped = 0;
  double age = kUnknown;
  double margin = kUnknown;
  double margin_sigma = kUnknown;
  double margin_low = kUnknown;
  double friction = kUnknown;
  double friction_sigma = kUnknown;
  double normal_force = kUnknown;
  double shear_force = kUnknown;
  double shear_force_x = kUnknown;
  double shear_force_y = kUnknown;
  double torque = kUnknown;
  double torque_sigma = kUnknown;
  double center_x = kUnknown;
  double center_y = kUnknown;
  double radius = kUnknown;
  double time_to_slip = kUnknown;
  double grip_increase = kUnknown;
  double grip_increase_sigma = kUnknown;
  double sliding_for = kUnknown;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("header", m.header);
    visit("name", m.name);
    visit("state", m.state);
    visit("alert", m.alert);
    visit("sliding", m.sliding);
    visit("simulated", m.simulated);
    visit("seq", m.seq);
    visit("dropped", m.dropped);
    visit("age", m.age);
    visit("margin", m.margin);
    visit("margin_sigma", m.margin_sigma);
    visit("margin_low", m.margin_low);
    visit("friction", m.friction);
    visit("friction_sigma", m.friction_sigma);
    visit("normal_force", m.normal_force);
    visit("shear_force", m.shear_force);
    visit("shear_force_x", m.shear_force_x);
    visit("shear_force_y", m.shear_force_y);
    visit("torque", m.torque);
    visit("torque_sigma", m.torque_sigma);
    visit("center_x", m.center_x);
    visit("center_y", m.center_y);
    visit("radius", m.radius);
    visit("time_to_slip", m.time_to_slip);
    visit("grip_increase", m.grip_increase);
    visit("grip_increase_sigma", m.grip_increase_sigma);
    visit("sliding_for", m.sliding_for);
  }
};

// Bytes of the identifier of a DDS entity in rmw_dds_common: 24 in Humble and before, 16 in Iron and later.
// The type's name is the same, so nodes of both kinds cannot read each other's.
inline constexpr std::size_t kHumbleGidBytes = 24;
inline constexpr std::size_t kGidBytes = 16;

template <std::size_t BYTES>
struct Gid {
  static constexpr std::string_view kName = "rmw_dds_common/msg/Gid";
  std::array<std::uint8_t, BYTES> data{};
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("data", m.data);
  }
};

template <std::size_t BYTES>
struct NodeEntitiesInfo {
  static constexpr std::string_view kName = "rmw_dds_common/msg/NodeEntitiesInfo";
  BoundedString<256> node_namespace;
  BoundedString<256> node_name;
  std::vector<Gid<BYTES>> reader_gid_seq;
  std::vector<Gid<BYTES>> writer_gid_seq;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("node_namespace", m.node_namespace);
    visit("node_name", m.node_name);
    visit("reader_gid_seq", m.reader_gid_seq);
    visit("writer_gid_seq", m.writer_gid_seq);
  }
};

// The topic `ros_discovery_info`: which nodes a participant has, and their readers and writers.
template <std::size_t BYTES>
struct ParticipantEntitiesInfo {
  static constexpr std::string_view kName = "rmw_dds_common/msg/ParticipantEntitiesInfo";
  // Of kGidBytes; Humble has no hashes.
  static constexpr std::string_view kTypeHash =
      "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e";
  Gid<BYTES> gid;
  std::vector<NodeEntitiesInfo<BYTES>> node_entities_info_seq;
  template <class Self, class Visit>
  static void fields(Self& m, Visit&& visit) {
    visit("gid", m.gid);
    visit("node_entities_info_seq", m.node_entities_info_seq);
  }
};

}  // namespace slipd::ros2
