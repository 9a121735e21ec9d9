#include "camera/picture/jpeg.hpp"

#include <jpeglib.h>

#include <csetjmp>
#include <cstdint>
#include <cstdio>

namespace slipd::camera {
namespace {

constexpr unsigned kLargestSide = 8192;

// libjpeg's errors come back by longjmp, so that between setjmp and the end nothing may have a destructor.
struct Errors {
  jpeg_error_mgr base;
  std::jmp_buf back;
};

void go_back(j_common_ptr info) {
  std::longjmp(reinterpret_cast<Errors*>(info->err)->back, 1);
}

// Counted in num_warnings.
void count_warning(j_common_ptr info, int level) {
  if (level < 0) ++info->err->num_warnings;
}

void say_nothing(j_common_ptr) {}

// False: no picture at all. `out` is allocated when the size is known.
bool decode(std::span<const std::byte> bytes, int shrink, jpeg_decompress_struct& info, Errors& errors,
            cv::Mat& out) {
  if (setjmp(errors.back) != 0) return false;
  jpeg_mem_src(&info, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  if (info.image_width > kLargestSide || info.image_height > kLargestSide) return false;
  info.out_color_space = JCS_GRAYSCALE;
  info.scale_num = 1;
  info.scale_denom = static_cast<unsigned>(shrink);
  info.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&info);
  out.create(static_cast<int>(info.output_height), static_cast<int>(info.output_width), CV_8UC1);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = out.ptr<std::uint8_t>(static_cast<int>(info.output_scanline));
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  return true;
}

}  // namespace

Decoded decode_jpeg(std::span<const std::byte> bytes, int shrink) {
  Decoded out;
  Errors errors{};
  jpeg_decompress_struct info{};
  info.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = go_back;
  errors.base.emit_message = count_warning;
  errors.base.output_message = say_nothing;
  jpeg_create_decompress(&info);
  const bool whole = decode(bytes, shrink, info, errors, out.brightness);
  out.torn = !whole || errors.base.num_warnings > 0;
  if (!whole) out.brightness.release();
  jpeg_destroy_decompress(&info);
  return out;
}

}  // namespace slipd::camera
