// A bias is read back from its file unchanged, and any other content is refused.
#include "daemon/state/bias_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/temp_folder.hpp"

namespace slipd {
namespace {

using ::testing::HasSubstr;

const BiasIdentity kBiasedSensor{"can", "xela-xr1944", R"({"interface":"can0"})", "board 1", 2};
constexpr Now kWritten{.monotonic_ns = 5'000, .realtime_ns = 1'790'000'000'000'000'000};

Bias some_zero() {
  return {.bias_pa = {1, -2, 3, 4, 5, 6e9F},
          .noise_pa = {0, 1, 2, 3, 4, 5},
          .origin = BiasOrigin::command,
          .taken_ns = 1'000,
          .confirmed_ns = 2'000,
          .last_pa = {1, 2, 3, 4, 5, 6}};
}

std::string refusal_of(const std::vector<std::uint8_t>& bytes, const BiasIdentity& sensor = kBiasedSensor) {
  try {
    static_cast<void>(decode_bias(bytes, sensor, kWritten));
  } catch (const BiasError& error) {
    return error.what();
  }
  return {};
}

TEST(BiasFileTest, ReadsBackWhatWasWrittenWithTheWallClocksTime) {
  const auto bytes = encode_bias(kBiasedSensor, some_zero(), kWritten);
  constexpr Now kAfterReboot{.monotonic_ns = 100, .realtime_ns = kWritten.realtime_ns + 1'000'000};
  const Bias read = decode_bias(bytes, kBiasedSensor, kAfterReboot);
  EXPECT_EQ(read.bias_pa, some_zero().bias_pa);
  EXPECT_EQ(read.noise_pa, some_zero().noise_pa);
  EXPECT_EQ(read.origin, BiasOrigin::command);
  EXPECT_EQ(read.last_pa, some_zero().last_pa);
  EXPECT_EQ(kAfterReboot.monotonic_ns - read.taken_ns, 1'000'000 + 4'000) << "its age: before this boot";
  EXPECT_EQ(kAfterReboot.monotonic_ns - read.confirmed_ns, 1'000'000 + 3'000);
}

TEST(BiasFileTest, NeedNotHoldWhatTheSensorReadLast) {
  Bias zero = some_zero();
  zero.last_pa.clear();
  EXPECT_TRUE(
      decode_bias(encode_bias(kBiasedSensor, zero, kWritten), kBiasedSensor, kWritten).last_pa.empty());
}

TEST(BiasFileTest, RefusesEveryByteThatIsChangedAndEveryCut) {
  const auto bytes = encode_bias(kBiasedSensor, some_zero(), kWritten);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto changed = bytes;
    changed[i] ^= 0x10;
    EXPECT_NE(refusal_of(changed), "") << "byte " << i;
    EXPECT_NE(refusal_of({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(i)}), "")
        << i << " bytes";
  }
}

TEST(BiasFileTest, RefusesTheBiasOfAnotherSensorAndNamesIt) {
  const auto bytes = encode_bias(kBiasedSensor, some_zero(), kWritten);
  BiasIdentity other = kBiasedSensor;
  other.part = "board 2";
  EXPECT_THAT(refusal_of(bytes, other),
              HasSubstr("is another sensor's: can xela-xr1944 {\"interface\":\"can0\"} "
                        "board 1, 2 taxels"));
  other = kBiasedSensor;
  other.taxels = 3;
  EXPECT_NE(refusal_of(bytes, other), "");
}

TEST(BiasFileTest, RefusesValuesThatAreNotFinite) {
  Bias zero = some_zero();
  zero.bias_pa[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal_of(encode_bias(kBiasedSensor, zero, kWritten)), HasSubstr("no number"));
  zero = some_zero();
  zero.noise_pa.pop_back();
  EXPECT_THAT(refusal_of(encode_bias(kBiasedSensor, zero, kWritten)), HasSubstr("number of values"));
}

TEST(BiasFileTest, IsNotReadFromALinkOrAFileThatOthersCanWrite) {
  const testing::TempFolder folder;
  const auto file = folder.file("mine.cbor");
  save_bias(file, kBiasedSensor, some_zero());
  std::filesystem::create_symlink(file, folder.file("link.cbor"));
  EXPECT_THROW(static_cast<void>(load_bias(folder.file("link.cbor"), kBiasedSensor)), BiasError);
  std::filesystem::permissions(file, std::filesystem::perms::others_write,
                               std::filesystem::perm_options::add);
  EXPECT_THROW(static_cast<void>(load_bias(file, kBiasedSensor)), BiasError);
}

TEST(BiasFileTest, RefusesDeepNesting) {
  EXPECT_THAT(refusal_of(std::vector<std::uint8_t>(1'000'000, 0x81)), HasSubstr("no CBOR item"));
}

TEST(BiasFileTest, IsFoundAgainUnderItsIdentityOnly) {
  const testing::TempFolder folder;
  const auto file = folder.file("zero") / "mine.cbor";
  EXPECT_FALSE(load_bias(file, kBiasedSensor)) << "no file is no error";
  save_bias(file, kBiasedSensor, some_zero());
  ASSERT_TRUE(load_bias(file, kBiasedSensor));
  EXPECT_EQ(load_bias(file, kBiasedSensor)->bias_pa, some_zero().bias_pa);
  for (const auto& left : std::filesystem::directory_iterator(file.parent_path()))
    EXPECT_EQ(left.path(), file);
  BiasIdentity other = kBiasedSensor;
  other.device = "serial 7";
  EXPECT_THROW(static_cast<void>(load_bias(file, other)), BiasError);
}

}  // namespace
}  // namespace slipd
