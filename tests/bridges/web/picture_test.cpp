#include "bridges/web/picture.hpp"

#include <gtest/gtest.h>

#include <boost/beast/core/detail/base64.hpp>  // another one's than the picture is read with
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

namespace slipd::web {
namespace {

using Json = nlohmann::json;

std::string base64(const std::vector<float>& values) {
  namespace other = boost::beast::detail::base64;
  std::string text(other::encoded_size(values.size() * sizeof(float)), '\0');
  text.resize(other::encode(text.data(), values.data(), values.size() * sizeof(float)));
  return text;
}

std::string answer(const std::vector<float>& normal, const std::vector<float>& x,
                   const std::vector<float>& y) {
  return Json{{"seq", 7},
              {"time_ns", 1},
              {"normal_pa", base64(normal)},
              {"shear_x_pa", base64(x)},
              {"shear_y_pa", base64(y)}}
      .dump();
}

struct Read {
  Json head;
  std::string values;
};
Read read(const std::string& message) {
  std::uint32_t length = 0;
  std::memcpy(&length, message.data(), sizeof length);
  return {Json::parse(message.substr(sizeof length, length)), message.substr(sizeof length + length)};
}

TEST(Picture, HasEachValueToWithinHalfAStep) {
  for (std::size_t taxels = 1; taxels < 9; ++taxels) {  // every length of the last group of base64
    std::vector<float> normal, x, y;
    for (std::size_t i = 0; i < taxels; ++i) {
      normal.push_back(static_cast<float>(1000 * i + 10));
      x.push_back(static_cast<float>(i) - 3.5F);
      y.push_back(5.F * static_cast<float>(i));
    }
    const Read picture = read(frame_picture("left", answer(normal, x, y)));
    ASSERT_EQ(picture.values.size(), 3 * taxels);
    const double peak = picture.head.at("peak_pa"), shear = picture.head.at("peak_shear_pa");
    for (std::size_t i = 0; i < taxels; ++i) {
      const auto pressure = static_cast<unsigned char>(picture.values[i]);
      EXPECT_NEAR(pressure / 255. * peak, normal[i], peak / 509);
      EXPECT_NEAR(static_cast<signed char>(picture.values[taxels + i]) / 127. * shear, x[i], shear / 253);
      EXPECT_NEAR(static_cast<signed char>(picture.values[2 * taxels + i]) / 127. * shear, y[i], shear / 253);
    }
    EXPECT_EQ(picture.head.at("seq"), 7);
    EXPECT_EQ(picture.head.at("sensor"), "left");
  }
}

TEST(Picture, OfValuesThatAreNoNumbersHasZeros) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), far = std::numeric_limits<float>::infinity();
  const Read picture = read(frame_picture("left", answer({nan, 2, -1}, {far, -far, 1}, {0, 0, nan})));
  EXPECT_EQ(picture.head.at("peak_pa"), 2);
  EXPECT_EQ(picture.values, std::string({0, '\xff', 0, 0, 0, 127, 0, 0, 0}));
}

TEST(Picture, RefusesWhatIsNoFrame) {
  for (const char* text :
       {"", "{}", R"({"seq":1,"normal_pa":[1],"shear_x_pa":"","shear_y_pa":""})",
        R"({"seq":1,"normal_pa":"AAA=","shear_x_pa":"","shear_y_pa":""})",
        R"({"seq":1,"normal_pa":"AAAAAA==","shear_x_pa":"","shear_y_pa":""})",
        R"({"seq":1,"normal_pa":"!!!!!!==","shear_x_pa":"AAAAAA==","shear_y_pa":"AAAAAA=="})"})
    EXPECT_ANY_THROW(frame_picture("left", text)) << text;
}

TEST(Picture, OfTheLayoutHasPlaces) {
  const Read picture = read(layout_picture("a \"b\" ü", R"({"x_mm":[1.5,-2],"y_mm":[0,4]})"));
  EXPECT_EQ(picture.head.at("sensor"), "a \"b\" ü");
  std::vector<float> places(4);
  ASSERT_EQ(picture.values.size(), 4 * sizeof(float));
  std::memcpy(places.data(), picture.values.data(), picture.values.size());
  EXPECT_EQ(places, (std::vector<float>{1.5, -2, 0, 4}));
  EXPECT_ANY_THROW(layout_picture("a", R"({"x_mm":[1],"y_mm":[]})"));
}

}  // namespace
}  // namespace slipd::web
