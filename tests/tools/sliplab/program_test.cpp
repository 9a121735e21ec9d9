// sliplab itself, as a user or the daemon runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <set>

#include "core/contact/contact_field.hpp"
#include "tests/support/synthetic.hpp"
#include "tests/tools/offline_program.hpp"
#include "tests/tools/sample_recording.hpp"

namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

class Sliplab : public slipctl::testing::OfflineProgram {
 protected:
  Sliplab() : OfflineProgram("sliplab") {}
};

constexpr const char* kConfig = R"({ "sensors": [ { "name": "left", "driver": "sim",
  "layout": { "grid": [16, 16], "pitch_mm": 0.9 } } ], "estimator": { "offset_mm": 0 } })";

TEST_F(Sliplab, MakesAPictureOfARecording) {
  if (std::system("gnuplot --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "gnuplot-nox is not installed";
  slipctl::testing::write_sample_recording(folder_ / "left.rec", true);
  for (const std::string format : {"svg", "png"}) {
    const auto ran =
        run({"--json", "--out", folder_ / "out", "picture", folder_ / "left.rec", "--format", format});
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
    const json said = json::parse(ran.out);
    EXPECT_EQ(said["frames"], slipctl::testing::kSampleFrames);
    EXPECT_EQ(said["estimates"], true);
    std::ifstream picture(said["picture"].get<std::string>(), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(picture)), {});
    EXPECT_THAT(bytes, HasSubstr(format == "svg" ? "</svg>" : "IEND"));
    EXPECT_GT(bytes.size(), 5000U);
  }
  EXPECT_EQ(run({"picture", write("x.rec", "nothing")}).exit_code, 1);
  EXPECT_EQ(run({"picture", folder_ / "none.rec"}).exit_code, 2);
}

TEST_F(Sliplab, TrainsOnceAndThenFindsTheModel) {
  const std::vector<std::string> words{"--json",   "train", "--config", write("c.json", kConfig),
                                       "--sensor", "left",  "--model",  folder_ / "m.cbor"};
  const auto first = run(words);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.err, HasSubstr("100 %"));
  EXPECT_EQ(json::parse(first.out)["taxels"], 256);
  EXPECT_GE(json::parse(first.out)["tradeoff"].size(), 3U);
  const auto second = run(words);
  EXPECT_EQ(second.exit_code, 0);
  EXPECT_EQ(second.err, "");

  std::fstream file(folder_ / "m.cbor", std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(5000);
  file.put('\x55').put('\x55');
  file.close();
  const auto third = run(words);
  EXPECT_EQ(third.exit_code, 0);
  EXPECT_THAT(third.err, HasSubstr("damaged"));
  EXPECT_EQ(run(words).err, "");
}

// Presses with something round on a pad of 8 x 8 taxels, as profile vendor-hid-8x8 has it.
void write_presses(const fs::path& file, double depth_m) {
  using namespace slipd;
  const TaxelLayout layout = TaxelLayout::grid(8, 8, 0.002);
  contact::ContactField sheet(layout, {.depth_m = depth_m, .bonded_poisson = std::nullopt});
  const UniqueFd fd(::open(file.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600));
  RecordingWriter writer(fd.get(), {.sensor = "left", .layout = layout, .rate_hz = 100, .description = {}});
  std::vector<float> normal(64), x(64), y(64);
  FrameSlot slot;
  slot.normal_pa = normal;
  slot.shear_x_pa = x;
  slot.shear_y_pa = y;
  std::mt19937_64 random(3);
  std::normal_distribution<float> noise(0, 100);
  for (int i = 0; i < 12; ++i) {
    contact::LoadHistory contact(synthetic::paper_pair());
    contact.move_to(6, 0, 0.5);
    contact.move_to(6, 0.5, 0.5);
    sheet.sense(contact, 0.0005 * (i % 3), 0.0005 * (i % 4), 0.5 * i, normal, x, y);
    for (auto* channel : {&normal, &x, &y})
      for (float& value : *channel) value += noise(random);
    slot.sequence = static_cast<std::uint64_t>(i);
    slot.time_ns = 10'000'000LL * (i + 1);
    ASSERT_FALSE(writer.append(slot));
  }
}

TEST_F(Sliplab, PrintsASkinThatTheConfigurationTakesBesideAProfile) {
  write_presses(folder_ / "presses.rec", 0.002);
  const auto configured = [&](const std::string& more) {
    return write(
        "scene.json",
        R"({ "sensors": [ { "name": "left", "driver": "hid", "profile": "vendor-hid-8x8")" + more + " } ] }");
  };
  const auto found = run({"skin", "--scene", configured(""), folder_ / "presses.rec"});
  ASSERT_EQ(found.exit_code, 0) << found.err;
  std::smatch line;
  ASSERT_TRUE(std::regex_search(found.out, line, std::regex(R"(: ("skin": \{ "depth_mm": ([0-9.]+) \}))")))
      << found.out;
  EXPECT_NEAR(std::stod(line[2]), 2, 0.3);
  EXPECT_THAT(found.out, HasSubstr("no effect")) << "the profile's skin is flat";
  const auto taken = run({"skin", "--scene", configured(", " + line[1].str()), folder_ / "presses.rec"});
  EXPECT_EQ(taken.exit_code, 0) << taken.err;
  const auto curved =
      run({"skin", "--scene", configured(R"(, "skin": { "radius_mm": 10 })"), folder_ / "presses.rec"});
  EXPECT_THAT(curved.out, Not(HasSubstr("no effect"))) << curved.err;
}

TEST_F(Sliplab, WrongUseEndsWithTwo) {
  EXPECT_EQ(run({}).exit_code, 2);
  EXPECT_EQ(run({"train"}).exit_code, 2);
  EXPECT_EQ(run({"train", "--setup", write("s.json", "{}")}).exit_code, 2);
  const auto unknown = run({"train", "--config", write("c.json", kConfig), "--sensor", "right"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("left"));
}

TEST_F(Sliplab, AModelThatCannotBeWrittenEndsWithOne) {
  const auto ran = run({"train", "--config", write("c.json", kConfig), "--sensor", "left", "--model",
                        write("file", "") + "/model.cbor"});
  EXPECT_EQ(ran.exit_code, 1);
  EXPECT_THAT(ran.err, HasSubstr("cannot be made"));
}

TEST_F(Sliplab, MergesTheShardsOfASweepToTheResultOfOneRun) {
  const std::string scenes = SLIPD_SOURCE_DIR "/config/scenes/",
                    data = SLIPD_SOURCE_DIR "/tests/data/eflesh/";
  expect_shards_merge({"replay", "--scene", scenes + "eflesh.json", "--sensor", "left", "--file",
                       data + "seq_000.csv", "--file", data + "seq_002.csv"});
}

}  // namespace
