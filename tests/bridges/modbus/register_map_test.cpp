#include "bridges/modbus/register_map.hpp"

#include <gmock/gmock.h>
#include <time.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <set>

namespace slipd::modbus {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kSource = SLIPD_SOURCE_DIR;

slipd_estimate sure() {
  slipd_estimate e{};
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  e.state = SLIPD_STATE_OK;
  e.valid_until_ns = (now.tv_sec + 1000) * 1'000'000'000LL;
  e.sequence = 0x1'2345'6789;
  e.age_s = 0.0123;
  e.gamma = 0.6214;
  e.gamma_low = 0.59;
  e.sigma = 0.01;
  e.friction = 0.45;
  e.friction_sigma = 0.02;
  e.normal_n = 2.1;
  e.shear_n = 0.36;
  e.torque_nm = -0.0123;
  e.grip_increase_n = -0.5;
  e.time_to_slip_s = 0.0205;
  return e;
}

std::array<std::uint16_t, kBlockSize> block_of(const slipd_estimate& e) {
  std::array<std::uint16_t, kBlockSize> block{};
  write_block(e, block);
  return block;
}

std::string file(const std::string& name) {
  std::ifstream in(std::string(kSource) + "/" + name);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(RegisterMap, ScalesValues) {
  const auto block = block_of(sure());
  EXPECT_EQ(block[0], SLIPD_STATE_OK);
  EXPECT_EQ(block[2], 6214);
  EXPECT_EQ(block[3], 5900);
  EXPECT_EQ(block[4], 100);
  EXPECT_EQ(block[5], 450);
  EXPECT_EQ(block[6], 210);
  EXPECT_EQ(block[7], 36);
  EXPECT_EQ(static_cast<std::int16_t>(block[8]), -123);
  EXPECT_EQ(static_cast<std::int16_t>(block[9]), -50);
  EXPECT_EQ(block[12], 21);
}

TEST(RegisterMap, AWideValueHasItsHighWordFirst) {
  const auto block = block_of(sure());
  EXPECT_EQ((std::uint32_t{block[16]} << 16U) + block[17], 0x2345'6789U);
  EXPECT_EQ((std::uint32_t{block[14]} << 16U) + block[15], 12U);
}

TEST(RegisterMap, AnAlertHasItsCauseOrAnUnknownOne) {
  slipd_estimate e = sure();
  EXPECT_EQ(block_of(e)[19], 0);
  e.alert = SLIPD_ALERT_WARN;
  EXPECT_EQ(block_of(e)[19], kUnknown) << "an older libslipd gives no cause";
  e.alert_cause = SLIPD_CAUSE_MARGIN;
  EXPECT_EQ(block_of(e)[19], 1);
  e.alert_cause = SLIPD_CAUSE_SLIDING;
  EXPECT_EQ(block_of(e)[19], 2);
  e.alert_cause = SLIPD_CAUSE_UNKNOWN;
  EXPECT_EQ(block_of(e)[19], kUnknown);
}

TEST(RegisterMap, WithoutFramesARaisedAlertStandsAndNoneIsUnknown) {
  slipd_estimate e = sure();
  for (const int state : {SLIPD_STATE_STALE, SLIPD_STATE_DISCONNECTED}) {
    e.state = state;
    e.alert = SLIPD_ALERT_SLIP;
    e.alert_cause = SLIPD_CAUSE_SLIDING;
    EXPECT_EQ(block_of(e)[10], 2);
    EXPECT_EQ(block_of(e)[19], 2);
    e.alert = SLIPD_ALERT_NONE;
    e.alert_cause = SLIPD_CAUSE_NONE;
    EXPECT_EQ(block_of(e)[10], kUnknown);
    EXPECT_EQ(block_of(e)[19], kUnknown);
  }
}

TEST(RegisterMap, AnUnknownAlertIsNotKnownInAnyState) {
  slipd_estimate e = sure();
  e.alert = SLIPD_ALERT_UNKNOWN;
  for (const int state : {SLIPD_STATE_NO_CONTACT, SLIPD_STATE_FAULT, SLIPD_STATE_STALE}) {
    e.state = state;
    EXPECT_EQ(block_of(e)[10], kUnknown);
    EXPECT_EQ(block_of(e)[19], kUnknown);
  }
}

TEST(RegisterMap, AMarginThatHasExpiredIsUnknown) {
  slipd_estimate e = sure();
  e.valid_until_ns = 1;
  EXPECT_EQ(block_of(e)[2], kUnknown);
}

TEST(RegisterMap, NothingThatIsUnknownReadsAsZero) {
  slipd_estimate e = sure();
  for (double* value : {&e.gamma, &e.gamma_low, &e.sigma, &e.friction, &e.friction_sigma, &e.normal_n,
                        &e.shear_n, &e.torque_nm, &e.grip_increase_n, &e.time_to_slip_s})
    *value = kNothing;
  e.sliding = SLIPD_SLIDING_UNKNOWN;
  e.age_s = std::numeric_limits<double>::infinity();
  const auto block = block_of(e);
  for (const int at : {2, 3, 4, 5, 6, 7, 11, 12, 14, 15, 18}) EXPECT_EQ(block[at], kUnknown) << at;
  for (const int at : {8, 9}) EXPECT_EQ(block[at], kUnknownSigned) << at;
}

TEST(RegisterMap, WithoutSlipdOnlyTheStateIsKnown) {
  slipd_estimate e = sure();
  e.state = SLIPD_STATE_DISCONNECTED;
  const auto block = block_of(e);
  EXPECT_EQ(block[0], SLIPD_STATE_DISCONNECTED);
  for (int at = 1; at < kBlockSize; ++at)
    EXPECT_THAT(block[at], ::testing::AnyOf(kUnknown, kUnknownSigned)) << at;
}

TEST(RegisterMap, AValueBeyondItsRangeIsItsLimitAndNotTheSentinel) {
  slipd_estimate e = sure();
  e.normal_n = 1e9;
  e.shear_n = -1;
  e.torque_nm = -1e9;
  const auto block = block_of(e);
  EXPECT_EQ(block[6], 0xFFFE);
  EXPECT_EQ(block[7], 0);
  EXPECT_EQ(static_cast<std::int16_t>(block[8]), -32767);
}

TEST(RegisterMap, TheHeartbeatRisesOnlyWithSignsOfLife) {
  std::array<std::uint16_t, kFirstBlock> first{}, later{};
  write_header({true, 1000, 2}, first);
  write_header({true, 1100, 2}, later);
  EXPECT_EQ(static_cast<std::uint16_t>(later[1] - first[1]), 1);
  EXPECT_EQ(later[2], 1);
  write_header({false, 1100, 2}, first);
  EXPECT_EQ(first[1], later[1]);
  EXPECT_EQ(first[2], 2);
}

TEST(RegisterMap, NoTwoValuesShareARegister) {
  const auto check = [](const auto& table, int size) {
    std::set<int> taken;
    for (const auto& each : table) {
      const int registers = each.type == RegisterType::u32 ? 2 : 1;
      for (int i = 0; i < registers; ++i) {
        EXPECT_TRUE(taken.insert(each.offset + i).second) << each.name;
        EXPECT_LT(each.offset + i, size);
      }
    }
  };
  check(header_registers(), kFirstBlock);
  check(block_registers(), kBlockSize);
}

// SLIPD_WRITE_MAP=1 writes the CSV anew.
TEST(RegisterMap, TheFileForImportAndThePageAreMadeOfTheTable) {
  if (std::getenv("SLIPD_WRITE_MAP") != nullptr)
    std::ofstream(std::string(kSource) + "/bridges/modbus/registers.csv") << map_as_csv();
  EXPECT_EQ(file("bridges/modbus/registers.csv"), map_as_csv());
  EXPECT_THAT(file("docs/plc.md"), ::testing::HasSubstr(map_as_markdown())) << map_as_markdown();
}

}  // namespace
}  // namespace slipd::modbus
