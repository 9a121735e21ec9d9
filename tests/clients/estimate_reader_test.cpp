// Estimates are read from text in one pass; the truth here is the tree of values that nlohmann/json makes of
// the same text, asked member by member.
#include "clients/c/estimate_reader.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>

#include "clients/c/json_values.hpp"

namespace slipd::client {
namespace {

EstimateValues looked_up(const Json& in) {
  EstimateValues out;
  out.name = text(in, in.contains("grasp") ? "grasp" : "sensor");
  out.state = text(in, "state", "fault");
  out.alert = text(in, "alert", "slip");
  out.sequence = count(in, "seq");
  out.time_ns = integer(in, "time_ns");
  out.gamma = number(in, "gamma");
  out.shear_x_n = number(in, "shear_x_n");
  if (const auto value = number(in, "class"); value && *value >= 1 && *value <= 5)
    out.slip_class = static_cast<int>(*value);
  if (const Json& center = member(in, "center_mm");
      center.is_array() && center.size() == 2 && center[0].is_number() && center[1].is_number()) {
    out.center_x_mm = center[0].get<double>();
    out.center_y_mm = center[1].get<double>();
  }
  out.true_gamma = number(member(in, "truth"), "gamma");
  out.true_friction = number(member(in, "truth"), "friction");
  out.simulated = flag(in, "simulated");
  return out;
}

void expect_same(const EstimateValues& read, const EstimateValues& truth, const std::string& text) {
  EXPECT_EQ(read.name, truth.name) << text;
  EXPECT_EQ(read.state, truth.state) << text;
  EXPECT_EQ(read.alert, truth.alert) << text;
  EXPECT_EQ(read.sequence, truth.sequence) << text;
  EXPECT_EQ(read.time_ns, truth.time_ns) << text;
  EXPECT_EQ(read.gamma, truth.gamma) << text;
  EXPECT_EQ(read.shear_x_n, truth.shear_x_n) << text;
  EXPECT_EQ(read.slip_class, truth.slip_class) << text;
  EXPECT_EQ(read.center_x_mm, truth.center_x_mm) << text;
  EXPECT_EQ(read.center_y_mm, truth.center_y_mm) << text;
  EXPECT_EQ(read.true_gamma, truth.true_gamma) << text;
  EXPECT_EQ(read.true_friction, truth.true_friction) << text;
  EXPECT_EQ(read.simulated, truth.simulated) << text;
}

constexpr std::array kKeys{"sensor", "grasp",  "seq",       "time_ns",   "state",
                           "gamma",  "class",  "shear_x_n", "center_mm", "truth",
                           "alert",  "health", "friction",  "simulated", "x"};

// A value of any type, in lists and objects at most `deep` deep.
Json any_value(std::mt19937& random, int deep) {
  const auto below = [&](int end) { return std::uniform_int_distribution(0, end - 1)(random); };
  switch (below(deep > 0 ? 9 : 6)) {
    case 0:
      return nullptr;
    case 1:
      return below(2) == 1;
    case 2:
      return below(9) - 4;
    case 3:
      return 0.25 * below(9);
    case 4:
      return std::uint64_t{1} << 62;
    case 5:
      return "ok";
    case 6:
    case 7: {
      Json list = Json::array();
      for (int left = below(4); left > 0; --left) list.push_back(any_value(random, deep - 1));
      return list;
    }
    default: {
      Json object = Json::object();
      for (int left = below(4); left > 0; --left)
        object[kKeys.at(static_cast<std::size_t>(below(kKeys.size())))] = any_value(random, deep - 1);
      return object;
    }
  }
}

Json any_object(std::mt19937& random) {
  Json object = Json::object();
  for (const char* const key : kKeys) {
    if (random() % 3 != 0) object[key] = any_value(random, 3);
  }
  return object;
}

TEST(EstimateReader, ReadsWhatTheTreeOfValuesHas) {
  std::mt19937 random(21);
  for (int i = 0; i < 3000; ++i) {
    const Json params = any_object(random);
    const Json message{{"jsonrpc", "2.0"}, {"method", "alert"}, {"params", params}};
    const std::string text = message.dump();
    NotificationReader reader;
    ASSERT_TRUE(Json::sax_parse(text, &reader)) << text;
    ASSERT_TRUE(reader.complete()) << text;
    EXPECT_EQ(reader.method(), "alert");
    expect_same(reader.values(), looked_up(params), text);
    expect_same(estimate_from(params), looked_up(params), text);
  }
}

TEST(EstimateReader, ReadsMembersInAnyOrderAndTheLastOfTheSameName) {
  NotificationReader reader;
  ASSERT_TRUE(Json::sax_parse(
      R"({"params":{"gamma":1,"grasp":"both","sensor":"left","gamma":null,"state":"ok"},"method":"state"})",
      &reader));
  ASSERT_TRUE(reader.complete());
  EXPECT_EQ(reader.method(), "state");
  EXPECT_EQ(reader.values().name, "both");
  EXPECT_EQ(reader.values().state, "ok");
  EXPECT_EQ(reader.values().gamma, std::nullopt);
}

TEST(EstimateReader, AnObjectWithoutStateOrAlertIsAFaultThatSlips) {
  const EstimateValues values = estimate_from(Json::object());
  EXPECT_EQ(values.state, "fault");
  EXPECT_EQ(values.alert, "slip");
  EXPECT_EQ(estimate_from(Json(nullptr)).state, "fault");
}

TEST(EstimateReader, NothingButANotificationIsComplete) {
  for (const char* const text :
       {R"({"jsonrpc":"2.0","id":1,"result":{"subscription":1}})", R"({"jsonrpc":"2.0","method":"estimate"})",
        R"({"jsonrpc":"2.0","error":{"code":1}})", R"({"method":"estimate","params":[1]})",
        R"({"method":"estimate","params":7})", R"({"method":"estimate","params":{"gamma":0.5})", "[]", "1",
        ""}) {
    NotificationReader reader;
    EXPECT_FALSE(Json::sax_parse(std::string(text), &reader) && reader.complete()) << text;
  }
}

}  // namespace
}  // namespace slipd::client
