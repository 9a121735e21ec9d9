// What `slipctl fleet` shows of the lines that slipd-fleet prints.
#include <gmock/gmock.h>

#include "tools/slipctl/fleet_state.hpp"

namespace slipctl::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kBroker = R"({"broker":"b:1883","connected":true,"trouble":null})";
constexpr const char* kGood =
    R"({"gripper":"g1","status":"online","state":"ok","state_of":"left","gamma":0.62,"gamma_of":"left","alert":"none",)"
    R"("alerts_last_hour":3,"alerts_waiting":0,"alerts_dropped":0,"version":"0.1.0","simulated":true,"offline_since_ns":null})";
constexpr const char* kFault =
    R"({"gripper":"g2","status":"online","state":"fault","state_of":"right","gamma":null,"gamma_of":null,"alert":"warn",)"
    R"("alerts_last_hour":4,"alerts_waiting":0,"alerts_dropped":2,"version":"0.1.0","simulated":false,"offline_since_ns":null})";
constexpr const char* kOffline =
    R"({"gripper":"g3","status":"offline","state":"disconnected","state_of":null,"gamma":null,"gamma_of":null,"alert":null,)"
    R"("alerts_last_hour":null,"alerts_waiting":null,"alerts_dropped":null,"version":"0.1.0","simulated":null,)"
    R"("offline_since_ns":1790000000000000000})";

FleetState state_of(const std::vector<std::string>& lines) {
  FleetState state;
  for (const std::string& line : lines) take_fleet_line(state, line);
  return state;
}

std::string row_of(const std::string& text, const std::string& gripper) {
  const auto begin = text.find(gripper + " ");
  return begin == std::string::npos ? "" : text.substr(begin, text.find('\n', begin) - begin);
}

TEST(FleetView, ATableOfAllGrippers) {
  const std::string text = fleet_table(state_of({kBroker, kOffline, kGood, kFault}));
  EXPECT_THAT(row_of(text, "g1"),
              AllOf(HasSubstr("ok"), HasSubstr("0.62 (left)"), HasSubstr("0.1.0 simulated")));
  EXPECT_THAT(row_of(text, "g2"),
              AllOf(HasSubstr("fault (right)"), HasSubstr("–"), HasSubstr("4, 2 dropped")));
  EXPECT_THAT(row_of(text, "g3"), AllOf(HasSubstr("offline"), HasSubstr("2026-09-"), Not(HasSubstr("0.6"))));
  EXPECT_LT(text.find("g1"), text.find("g2"));
}

TEST(FleetView, WhoNeedsAPersonComesFirst) {
  std::string slip = kFault;
  slip.replace(slip.find("g2"), 2, "g4").replace(slip.find("warn"), 4, "slip");
  const FleetState state = state_of({kBroker, kGood, kFault, kOffline, slip});
  std::vector<std::string> names;
  for (const FleetLine* line : by_urgency(state)) names.push_back(line->gripper);
  EXPECT_THAT(names, ElementsAre("g4", "g3", "g2", "g1"));
}

TEST(FleetView, TheScreenCountsWhatDoesNotFit) {
  FleetState state = state_of({kBroker, kFault, kOffline});
  for (int i = 10; i < 99; ++i) {
    std::string line = kGood;
    take_fleet_line(state, line.replace(line.find("g1"), 2, "h" + std::to_string(i)));
  }
  for (const int columns : {1, 20, 80, 211})
    for (const int rows : {1, 2, 3, 24}) {
      const Canvas canvas = draw_fleet(state, columns, rows);
      EXPECT_EQ(canvas.columns(), columns);
      EXPECT_EQ(canvas.rows(), rows);
    }
  EXPECT_THAT(draw_fleet(state, 120, 24).to_text(),
              AllOf(HasSubstr("91 grippers, 1 offline, 1 warn"), HasSubstr("and 70 more"), HasSubstr("g3 ")));
}

TEST(FleetView, WithoutABrokerNothingIsKnown) {
  FleetState state = state_of({kBroker, kGood});
  take_fleet_line(state, R"({"broker":"b:1883","connected":false,"trouble":"b:1883: Connection refused"})");
  EXPECT_THAT(draw_fleet(state, 120, 24).to_text(),
              AllOf(HasSubstr("no broker: b:1883: Connection refused"), Not(HasSubstr("0.62"))));
}

TEST(FleetView, AGripperIsRemoved) {
  FleetState state = state_of({kBroker, kGood});
  EXPECT_EQ(take_fleet_line(state, R"({"gripper":"g1","status":"removed"})"), "g1");
  EXPECT_TRUE(state.lines.empty());
}

TEST(FleetView, NoControlCharacterReachesTheTerminal) {
  const FleetState state = state_of(
      {kBroker,
       R"({"gripper":"g\u001b[2J\u009b1","status":"online","state":"o\nk","gamma":"x","version":"\u0007"})"});
  for (const std::string& text : {fleet_table(state), fleet_text(state.lines.begin()->second)}) {
    EXPECT_THAT(text, AllOf(HasSubstr("g?[2J?1"), Not(HasSubstr("\x1b")), Not(HasSubstr("\xc2\x9b")),
                            Not(HasSubstr("\x07"))));
  }
}

TEST(FleetView, WhatIsNoLineChangesNothing) {
  FleetState state;
  for (const char* line : {"", "no JSON", "[]", "{}", R"({"gripper":3})", "\xff"})
    EXPECT_EQ(take_fleet_line(state, line), "");
  EXPECT_TRUE(state.lines.empty());
}

}  // namespace
}  // namespace slipctl::testing
