#include "camera/frames/frame_writer.hpp"

#include <cerrno>
#include <limits>
#include <system_error>

#include "push_layout/layout.hpp"

namespace slipd::camera {

FrameWriter::FrameWriter(const std::string& path, const NodeGrid& nodes, double rate_hz)
    : path_(path),
      file_(path == "-" ? stdout : std::fopen(path.c_str(), "wbe")),
      none_(NodeGrid::kValues * nodes.size(), std::numeric_limits<float>::quiet_NaN()) {
  if (!file_) throw std::system_error(errno, std::generic_category(), path_);
  const push_layout::Hello hello{.axes = NodeGrid::kValues,
                                 .unit = push_layout::Unit::millimetre,
                                 .taxels = static_cast<std::uint32_t>(nodes.size()),
                                 .rate_hz = rate_hz};
  put(&hello, sizeof hello);
}

void FrameWriter::write(const Picture& picture, std::span<const float> values) {
  const bool bad = values.empty();
  if (bad) values = none_;
  const push_layout::FrameHead head{.flags = bad ? push_layout::kBad : std::uint16_t{0},
                                    .size = static_cast<std::uint32_t>(push_layout::frame_size(
                                        none_.size() / NodeGrid::kValues, NodeGrid::kValues)),
                                    .sequence = picture.sequence,
                                    .time_ns = picture.time_ns};
  put(&head, sizeof head);
  put(values.data(), values.size_bytes());
  if (std::fflush(file_.get()) != 0) throw std::system_error(errno, std::generic_category(), path_);
}

void FrameWriter::put(const void* bytes, std::size_t size) {
  if (std::fwrite(bytes, 1, size, file_.get()) != size)
    throw std::system_error(errno, std::generic_category(), path_);
}

}  // namespace slipd::camera
