#include "bridges/web/answers/picture.hpp"

#include <gtest/gtest.h>

#include <boost/beast/core/detail/base64.hpp>  // another one's than the picture is read with
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

namespace slipd::web {
namespace {

using Json = nlohmann::json;

constexpr double kOldestMs = 100;

Answer answer(const std::string& values, const char* state = "ok", const Json& age_ms = 5,
              double waited_ms = 0) {
  namespace other = boost::beast::detail::base64;
  std::string text(other::encoded_size(values.size()), '\0');
  text.resize(other::encode(text.data(), values.data(), values.size()));
  const Json frame{{"seq", 7},        {"time_ns", 1},         {"state", state}, {"age_ms", age_ms},
                   {"peak_pa", 40.5}, {"peak_shear_pa", 2.5}, {"values", text}};
  return {frame.dump(), 1000, 1000 + waited_ms};
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

TEST(Picture, HasTheFramesBytes) {
  std::string values;
  for (std::size_t taxels = 0; taxels < 9; ++taxels) {  // every length of the last group of base64
    const Read picture = read(frame_picture("left", answer(values), kOldestMs));
    EXPECT_EQ(picture.values, values);
    EXPECT_EQ(picture.head.at("taxels"), taxels);
    EXPECT_EQ(picture.head.at("seq"), 7);
    EXPECT_EQ(picture.head.at("age_ms"), 5);
    EXPECT_EQ(picture.head.at("made_ms"), 1000);
    EXPECT_EQ(picture.head.at("sensor"), "left");
    EXPECT_EQ(picture.head.at("peak_pa"), 40.5);
    EXPECT_EQ(picture.head.at("peak_shear_pa"), 2.5);
    for (const int step : {255, 0, -127}) values += static_cast<char>(step - static_cast<int>(taxels));
  }
}

TEST(Picture, IsNotMadeOfAFrameThatIsPast) {
  EXPECT_NO_THROW(frame_picture("left", answer("abc", "ok", kOldestMs), kOldestMs));
  EXPECT_NO_THROW(frame_picture("left", answer("abc", "fault", 5), kOldestMs));
  EXPECT_ANY_THROW(frame_picture("left", answer("abc", "ok", kOldestMs + 0.1), kOldestMs));
  EXPECT_ANY_THROW(frame_picture("left", answer("abc", "ok", 5, kOldestMs), kOldestMs));
  EXPECT_ANY_THROW(frame_picture("left", answer("abc", "stale", 5), kOldestMs));
  EXPECT_ANY_THROW(frame_picture("left", answer("abc", "ok", nullptr), kOldestMs));
}

TEST(Picture, RefusesWhatIsNoFrame) {
  const auto frame = [](const char* values) {
    return R"({"seq":1,"state":"ok","age_ms":5,"peak_pa":1,"peak_shear_pa":1,"values":)" +
           std::string(values) + "}";
  };
  EXPECT_NO_THROW(frame_picture("left", {frame(R"("AAAA")")}, kOldestMs));
  for (const std::string& text : {std::string(), std::string("{}"), frame("[1]"), frame(R"("AAA=")"),
                                  frame(R"("AAAAA===")"), frame(R"("AAAAA")"), frame(R"("!!!!")")})
    EXPECT_ANY_THROW(frame_picture("left", {text}, kOldestMs)) << text;
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
