#include "bridges/feed_ros2/topic_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "bridges/ros2/messages/cdr.hpp"
#include "wire/number.hpp"

namespace slipd::feed_ros2 {
namespace {

using feed::Outcome;

constexpr std::int64_t kNsPerS = 1'000'000'000;
// Of any clock: 2096 on that of this computer.
constexpr std::int64_t kLargestTimeNs = 4'000'000'000 * kNsPerS;

// Of PointField.datatype; none: there is no such.
std::optional<wire::NumberType> number_type(std::uint8_t datatype, bool big_endian) {
  using wire::NumberKind;
  constexpr wire::NumberType kTypes[] = {{NumberKind::whole, 1, false}, {NumberKind::natural, 1, false},
                                         {NumberKind::whole, 2, false}, {NumberKind::natural, 2, false},
                                         {NumberKind::whole, 4, false}, {NumberKind::natural, 4, false},
                                         {NumberKind::real, 4, false},  {NumberKind::real, 8, false}};
  if (datatype < 1 || datatype > std::size(kTypes)) return std::nullopt;
  wire::NumberType type = kTypes[datatype - 1];
  type.big_endian = big_endian;
  return type;
}

std::string counted(std::size_t has, std::size_t wanted, const char* what) {
  return "it has " + std::to_string(has) + " " + what + "; expected " + std::to_string(wanted);
}

}  // namespace

Outcome TopicReader::check_header(const ros2::Header& header) {
  stamp_ = header.stamp;
  if (!profile_.frame_id.empty() && header.frame_id != profile_.frame_id)
    return refuse(Outcome::other, "its frame_id is \"" + header.frame_id + "\", and \"frame_id\" is \"" +
                                      profile_.frame_id + "\"");
  return Outcome::frame;
}

Outcome TopicReader::read_array(feed::Bytes body, feed::Reading& out) {
  if (!ros2::decode(body, array_)) return refuse(Outcome::corrupt, "it is no Float32MultiArray");
  const ArrayLayout& layout = profile_.array;
  const std::size_t offset = array_.layout.data_offset;
  const std::size_t wanted = layout.first + taxels() * layout.row + layout.behind;
  if (array_.data.size() < offset || array_.data.size() - offset != wanted)
    return refuse(Outcome::corrupt,
                  counted(array_.data.size(), wanted, "numbers") +
                      (offset > 0 ? " behind its data_offset " + std::to_string(offset) : ""));
  // Strides are left alone: many publishers state none.
  std::size_t stated = 1;
  for (const ros2::MultiArrayDimension& dimension : array_.layout.dim)
    stated = std::min<std::size_t>(stated * dimension.size, std::size_t{1} << 31);
  if (!array_.layout.dim.empty() && stated != wanted)
    return refuse(Outcome::corrupt,
                  "its dimensions are of another number of values than " + std::to_string(wanted));
  const std::size_t taxel_step = layout.by_axes ? 1 : layout.row;
  const std::size_t column_step = layout.by_axes ? taxels() : 1;
  for (std::size_t taxel = 0; taxel < taxels(); ++taxel)
    for (const std::size_t column : profile_.columns)
      out.values.push_back(array_.data[offset + layout.first + taxel * taxel_step + column * column_step]);
  return Outcome::frame;
}

Outcome TopicReader::read_wrench(feed::Bytes body, feed::Reading& out) {
  if (!ros2::decode(body, wrench_)) return refuse(Outcome::corrupt, "it is no WrenchStamped");
  const ros2::Vector3& force = wrench_.wrench.force;
  for (const double value : {force.x, force.y, force.z}) out.values.push_back(static_cast<float>(value));
  return check_header(wrench_.header);
}

Outcome TopicReader::cloud_values(feed::Reading& out) {
  const std::uint64_t points = std::uint64_t{cloud_.height} * cloud_.width;
  if (points != taxels()) return refuse(Outcome::corrupt, counted(points, taxels(), "points"));
  if (cloud_.row_step < std::uint64_t{cloud_.width} * cloud_.point_step ||
      cloud_.data.size() != std::uint64_t{cloud_.height} * cloud_.row_step)
    return refuse(Outcome::corrupt, counted(cloud_.data.size(), std::size_t{cloud_.height} * cloud_.row_step,
                                            "bytes of points"));
  const std::size_t axes = profile_.fields.size();
  out.values.assign(taxels() * axes, 0);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const std::string& name = profile_.fields[axis];
    const auto field = std::ranges::find(cloud_.point_fields, name, &ros2::PointField::name);
    if (field == cloud_.point_fields.end())
      return refuse(Outcome::corrupt, "its points have no field " + name);
    const auto type = number_type(field->datatype, cloud_.is_bigendian);
    if (!type || field->count != 1 ||
        std::uint64_t{field->offset} + type->bytes > std::uint64_t{cloud_.point_step})
      return refuse(Outcome::corrupt, "its field " + name + " is no number within a point");
    for (std::size_t point = 0; point < taxels(); ++point) {
      const std::size_t at =
          point / cloud_.width * cloud_.row_step + point % cloud_.width * cloud_.point_step + field->offset;
      out.values[point * axes + axis] = static_cast<float>(wire::read_number(cloud_.data.data() + at, *type));
    }
  }
  return Outcome::frame;
}

Outcome TopicReader::read_cloud(feed::Bytes body, feed::Reading& out) {
  if (!ros2::decode(body, cloud_)) return refuse(Outcome::corrupt, "it is no PointCloud2");
  const Outcome outcome = check_header(cloud_.header);
  return outcome == Outcome::frame ? cloud_values(out) : outcome;
}

// The time also orders the messages: one that is not newer than the last is a repetition.
Outcome TopicReader::set_time(const feed::Message& message, feed::Reading& out) {
  std::optional<std::int64_t> sent_ns = message.sent_ns;
  if (profile_.time == TimeOf::stamp) {
    if (stamp_.sec < 0 || stamp_.nanosec >= kNsPerS || (stamp_.sec == 0 && stamp_.nanosec == 0))
      return refuse(Outcome::corrupt, "header.stamp is no time: give the profile \"time\": \"sent\"");
    sent_ns = kNsPerS * stamp_.sec + stamp_.nanosec;
  }
  if (profile_.time == TimeOf::received) return Outcome::frame;
  if (!sent_ns || *sent_ns <= 0 || *sent_ns > kLargestTimeNs)
    return refuse(Outcome::corrupt, "its sender says no time: give the profile \"time\": \"received\"");
  out.sequence = static_cast<std::uint64_t>(*sent_ns);
  out.sent_s = static_cast<double>(*sent_ns) / static_cast<double>(kNsPerS);
  return Outcome::frame;
}

Outcome TopicReader::read(const feed::Message& message, feed::Reading& out) {
  out = {};
  out.counted = false;
  const Outcome outcome = profile_.type == TopicType::array    ? read_array(message.body, out)
                          : profile_.type == TopicType::wrench ? read_wrench(message.body, out)
                                                               : read_cloud(message.body, out);
  if (outcome != Outcome::frame) return outcome;
  if (!std::ranges::all_of(out.values, [](float value) { return std::isfinite(value); }))
    return refuse(Outcome::corrupt, "a value is not finite");
  return set_time(message, out);
}

}  // namespace slipd::feed_ros2
