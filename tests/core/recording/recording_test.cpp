// Recorded frames are read back bit for bit, also those before a cut or a damaged byte, and nothing else is
// read.
#include "core/recording/recording.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "core/recording/recording_frame.hpp"

namespace slipd {
namespace {

using ::testing::HasSubstr;
using Status = RecordingReader::Status;

struct OwnedFrame {
  explicit OwnedFrame(std::size_t taxels) : memory(3 * taxels) {
    slot.normal_pa = std::span(memory).first(taxels);
    slot.shear_x_pa = std::span(memory).subspan(taxels, taxels);
    slot.shear_y_pa = std::span(memory).last(taxels);
  }
  std::vector<float> memory;
  FrameSlot slot;
};

OwnedFrame some_frame(std::size_t taxels, std::uint64_t number) {
  OwnedFrame frame(taxels);
  for (std::size_t i = 0; i < frame.memory.size(); ++i) {
    frame.memory[i] = std::sin(static_cast<float>(i + 31 * number)) * 1e5F;
  }
  frame.slot.sequence = 10 + 3 * number;
  frame.slot.time_ns = 1000000 + 1000 * static_cast<std::int64_t>(number);
  frame.slot.device_time_ns = number % 2 == 0 ? -1 : static_cast<std::int64_t>(number);
  if (number % 3 == 0) frame.slot.truth = {0.25, 0.5};
  return frame;
}

RecordingHeader header_for(TaxelLayout layout) {
  const auto sensor_class = layout.size() == 1 ? SensorClass::wrench : SensorClass::array3;
  return {"left", sensor_class, std::move(layout), 1000, true, 1790000000000000000, 12345, "a test"};
}

class Recordings : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::temp_directory_path() / ("slipd-recording-" + std::to_string(::getpid()));
  }
  void TearDown() override { std::filesystem::remove(path_); }

  void record(const RecordingHeader& header, std::uint64_t frames) {
    const int fd = ::open(path_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600);
    ASSERT_GE(fd, 0);
    {
      RecordingWriter writer(fd, header);
      for (std::uint64_t i = 0; i < frames; ++i) {
        ASSERT_FALSE(writer.append(some_frame(header.layout.size(), i).slot));
      }
    }
    ::close(fd);
  }
  std::string bytes() const {
    std::ostringstream content;
    content << std::ifstream(path_, std::ios::binary).rdbuf();
    return content.str();
  }
  void write(const std::string& content) const { std::ofstream(path_, std::ios::binary) << content; }

  // Writes a recording of version 1 of this many frames of four taxels; returns where its header and each of
  // its frames end.
  std::vector<std::size_t> ends_of_header_and_frames(std::uint64_t frames) {
    const auto header = nlohmann::json::to_cbor({{"format", "slipd-recording"},
                                                 {"version", 1},
                                                 {"sensor", "left"},
                                                 {"class", "array3"},
                                                 {"layout", {{"grid", {2, 2}}, {"pitch_m", 0.001}}},
                                                 {"rate_hz", 1000},
                                                 {"simulated", true},
                                                 {"start_realtime_ns", 1790000000000000000},
                                                 {"start_monotonic_ns", 12345},
                                                 {"description", "a test"}});
    std::string content(header.begin(), header.end());
    std::vector<std::size_t> ends{content.size()};
    for (std::uint64_t i = 0; i < frames; ++i) {
      std::vector<std::uint8_t> memory(largest_frame_bytes(4));
      cbor::Writer out(memory.data());
      put_frame(out, some_frame(4, i).slot, nullptr);
      content.append(memory.begin(), memory.begin() + (out.at() - memory.data()));
      ends.push_back(content.size());
    }
    write(content);
    return ends;
  }

  // Reads whole frames to the end, and compares each with the recorded one.
  static std::uint64_t count_frames(RecordingReader& reader) {
    const std::size_t taxels = reader.header().layout.size();
    OwnedFrame got(taxels);
    std::uint64_t count = 0;
    while (reader.next(got.slot) == Status::frame) {
      const auto want = some_frame(taxels, count);
      EXPECT_EQ(got.memory, want.memory);
      EXPECT_EQ(got.slot.sequence, want.slot.sequence);
      EXPECT_EQ(got.slot.time_ns, want.slot.time_ns);
      EXPECT_EQ(got.slot.device_time_ns, want.slot.device_time_ns);
      EXPECT_EQ(std::isnan(got.slot.truth.gamma), std::isnan(want.slot.truth.gamma));
      ++count;
    }
    return count;
  }
  std::string refusal() const {
    try {
      RecordingReader reader(path_);
    } catch (const std::exception& e) {
      return e.what();
    }
    return "read";
  }

  std::filesystem::path path_;
};

TEST_F(Recordings, GiveBackEveryBitOfEveryFrameForAnyLayout) {
  for (const auto& layout :
       {TaxelLayout::grid(4, 4, 0.004), TaxelLayout::grid(100, 100, 0.000144),
        TaxelLayout::scattered({0, 0.001, 0.003}, {0, 0.002, -0.001}), TaxelLayout::wrench(0.02)}) {
    const auto header = header_for(layout);
    record(header, 20);
    RecordingReader reader(path_);
    EXPECT_EQ(reader.header().layout, layout);
    EXPECT_EQ(reader.header().sensor, "left");
    EXPECT_EQ(reader.header().sensor_class, header.sensor_class);
    EXPECT_EQ(reader.header().rate_hz, 1000);
    EXPECT_TRUE(reader.header().simulated);
    EXPECT_EQ(reader.header().start_realtime_ns, 1790000000000000000);
    EXPECT_EQ(reader.header().description, "a test");
    EXPECT_EQ(count_frames(reader), 20U);
    EXPECT_EQ(reader.fault(), "");
    reader.rewind();
    EXPECT_EQ(count_frames(reader), 20U);
  }
}

TEST_F(Recordings, AreReadByAnyCborLibrary) {
  record(header_for(TaxelLayout::grid(2, 1, 0.001)), 1);
  const auto content = bytes();
  const std::vector<std::uint8_t> all(content.begin(), content.end());
  const auto header = nlohmann::json::from_cbor(all, false);
  EXPECT_EQ(header.at("format"), "slipd-recording");
  EXPECT_EQ(header.at("version"), 2);
  EXPECT_EQ(nlohmann::json::from_cbor(header.at("body").get_binary()).at("sensor"), "left");
  const auto header_end = all.begin() + static_cast<std::ptrdiff_t>(nlohmann::json::to_cbor(header).size());
  const auto block = nlohmann::json::from_cbor(std::vector<std::uint8_t>(header_end, all.end()), false);
  EXPECT_EQ(block.at("block"), 0);
  EXPECT_EQ(block.at("frames"), 1);
  const auto frame = nlohmann::json::from_cbor(block.at("body").get_binary(), true, true,
                                               nlohmann::json::cbor_tag_handler_t::store);
  EXPECT_EQ(frame.at("seq"), 10);
  EXPECT_TRUE(frame.at("device_time_ns").is_null());
  EXPECT_EQ(frame.at("truth_gamma"), 0.25);
  const auto& values = frame.at("normal_pa").get_binary();
  EXPECT_EQ(values.subtype(), 85U);
  ASSERT_EQ(values.size(), 2 * sizeof(float));
  float second = 0;
  std::memcpy(&second, values.data() + sizeof(float), sizeof second);
  EXPECT_EQ(second, some_frame(2, 0).memory[1]);
}

TEST_F(Recordings, GiveBackWhatWasEstimatedWhereItWasKnown) {
  const int fd = ::open(path_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600);
  const RecordedEstimate known{.state = 2,
                               .alert = 1,
                               .gamma = 0.625,
                               .sigma = 0.125,
                               .normal_n = 2.5,
                               .sliding = 3,
                               .alert_cause = 2,
                               .torque_nm = -0.0025,
                               .grip_increase_sigma_n = 0.75,
                               .method = 3,
                               .health = 16};
  {
    RecordingWriter writer(fd, header_for(TaxelLayout::grid(2, 2, 0.001)));
    for (std::uint64_t i = 0; i < 6; ++i)
      ASSERT_FALSE(writer.append(some_frame(4, i).slot, i % 2 == 0 ? &known : nullptr));
  }
  ::close(fd);
  const auto whole = bytes();
  RecordingReader reader(path_);
  OwnedFrame got(4);
  std::optional<RecordedEstimate> estimate;
  for (std::uint64_t i = 0; i < 6; ++i) {
    ASSERT_EQ(reader.next(got.slot, &estimate), Status::frame) << reader.fault();
    EXPECT_EQ(got.memory, some_frame(4, i).memory);
    ASSERT_EQ(estimate.has_value(), i % 2 == 0);
    if (!estimate) continue;
    EXPECT_EQ(estimate->state, 2);
    EXPECT_EQ(estimate->alert, 1);
    EXPECT_EQ(estimate->gamma, 0.625);
    EXPECT_EQ(estimate->sigma, 0.125);
    EXPECT_TRUE(std::isnan(estimate->friction));
    EXPECT_EQ(estimate->normal_n, 2.5);
    EXPECT_TRUE(std::isnan(estimate->shear_n));
    EXPECT_EQ(estimate->sliding, 3);
    EXPECT_EQ(estimate->alert_cause, 2);
    EXPECT_EQ(estimate->torque_nm, -0.0025);
    EXPECT_TRUE(std::isnan(estimate->turned_rad));
    EXPECT_EQ(estimate->grip_increase_sigma_n, 0.75);
    EXPECT_EQ(estimate->method, 3);
    EXPECT_EQ(estimate->health, 16);
  }
  EXPECT_EQ(reader.next(got.slot, &estimate), Status::end);
  EXPECT_FALSE(estimate);
  reader.rewind();
  EXPECT_EQ(count_frames(reader), 6U) << "who wants no estimates gets the frames alone";
}

// An estimate whose entries all differ.
RecordedEstimate every_entry() {
  RecordedEstimate estimate;
  int next = 1;
  for (const RecordedEntry& entry : kRecordedEntries) {
    if (entry.number != nullptr) {
      estimate.*entry.number = next++ / 8.0;
    } else {
      estimate.*entry.code = static_cast<std::uint8_t>(next++);
    }
  }
  return estimate;
}

// A frame with the first `entries` of an estimate's entries, as an older or a newer slipd writes it.
std::vector<std::uint8_t> encoded(const RecordedEstimate& estimate, std::size_t entries) {
  std::vector<std::uint8_t> memory(largest_frame_bytes(1) + 64);
  cbor::Writer whole(memory.data());
  put_frame(whole, some_frame(1, 0).slot, &estimate);
  memory.resize(static_cast<std::size_t>(whole.at() - memory.data()) + 64);
  // The estimate is the last entry: its map's head becomes another, and entries end earlier or follow.
  const std::string_view bytes(reinterpret_cast<const char*>(memory.data()), memory.size());
  const std::size_t head = bytes.find("estimate") + 8;
  memory[head] = 0xB8;
  memory[head + 1] = static_cast<std::uint8_t>(entries);
  cbor::Writer more(memory.data() + memory.size() - 64);
  for (std::size_t i = kRecordedEntries.size(); i < entries; ++i) {
    more.text("later");
    more.float64_or_null(1);
  }
  const auto end =
      entries < kRecordedEntries.size()
          ? bytes.find(std::string(1, static_cast<char>(0x60 + kRecordedEntries[entries].key.size())) +
                           std::string(kRecordedEntries[entries].key),
                       head)
          : static_cast<std::size_t>(more.at() - memory.data());
  memory.resize(end);
  return memory;
}

TEST_F(Recordings, GiveBackEachEntryThatTheirSlipdHadAndTheOthersAsUnknown) {
  const RecordedEstimate all = every_entry();
  for (std::size_t entries = kFewestRecordedEntries; entries <= kRecordedEntries.size() + 2; ++entries) {
    const auto bytes = encoded(all, entries);
    cbor::Reader in(bytes);
    OwnedFrame got(1);
    std::optional<RecordedEstimate> estimate;
    ASSERT_EQ(take_frame(in, got.slot, &estimate), nullptr) << entries;
    EXPECT_EQ(in.position(), bytes.size());
    ASSERT_TRUE(estimate);
    EXPECT_EQ(estimate->is_whole(), entries >= kRecordedEntries.size() - 1);
    for (std::size_t i = 0; i < kRecordedEntries.size(); ++i) {
      const RecordedEntry& entry = kRecordedEntries[i];
      if (entry.number != nullptr) {
        const double number = (*estimate).*entry.number;
        EXPECT_TRUE(i < entries ? number == all.*entry.number : std::isnan(number)) << entry.key;
      } else {
        const RecordedEstimate none;
        EXPECT_EQ((*estimate).*entry.code, i < entries ? all.*entry.code : none.*entry.code) << entry.key;
      }
    }
  }
}

TEST_F(Recordings, WithTooFewEntriesInAnEstimateAreNotRead) {
  const auto bytes = encoded(every_entry(), kFewestRecordedEntries - 1);
  cbor::Reader in(bytes);
  OwnedFrame got(1);
  std::optional<RecordedEstimate> estimate;
  EXPECT_STREQ(take_frame(in, got.slot, &estimate), "an estimate");
}

TEST_F(Recordings, KeepWhatIsUnknownOfAnEstimateUnknown) {
  const auto bytes = encoded({.state = 1}, kRecordedEntries.size());
  cbor::Reader in(bytes);
  OwnedFrame got(1);
  std::optional<RecordedEstimate> estimate;
  EXPECT_EQ(take_frame(in, got.slot, &estimate), nullptr);
  EXPECT_EQ(estimate.value().sliding, RecordedEstimate::kNoCode);
  EXPECT_EQ(estimate->method, RecordedEstimate::kNoCode);
  EXPECT_TRUE(std::isnan(estimate->gamma_low));
}

TEST_F(Recordings, OfVersionOneCutAnywhereGiveAllFramesBeforeTheCutAndSayWhereItIs) {
  const auto ends = ends_of_header_and_frames(3);
  const auto whole = bytes();
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    write(whole.substr(0, cut));
    if (cut < ends[0]) {
      EXPECT_THAT(refusal(), HasSubstr("byte " + std::to_string(cut))) << refusal();
      continue;
    }
    const auto before =
        static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), cut) - ends.begin()) - 1;
    RecordingReader reader(path_);
    EXPECT_EQ(count_frames(reader), before);
    OwnedFrame more(4);
    if (cut == ends[before]) {
      EXPECT_EQ(reader.next(more.slot), Status::end);
    } else {
      EXPECT_EQ(reader.next(more.slot), Status::damaged);
      EXPECT_EQ(reader.fault_offset(), cut);
      EXPECT_THAT(reader.fault(),
                  HasSubstr("byte " + std::to_string(cut) + ": the recording ends within the frame"));
    }
  }
}

TEST_F(Recordings, OfVersionOneDamagedInOneByteGiveAllFramesBeforeIt) {
  const auto ends = ends_of_header_and_frames(3);
  auto damaged = bytes();
  damaged[ends[1] + 2] = '!';  // in the name of the second frame's first entry
  write(damaged);
  RecordingReader reader(path_);
  EXPECT_EQ(count_frames(reader), 1U);
  EXPECT_THAT(reader.fault(), HasSubstr("byte " + std::to_string(ends[1] + 1) + ": damaged"));
}

TEST_F(Recordings, OfSomethingElseAreRefusedWithWhatWasExpected) {
  write("");
  EXPECT_THAT(refusal(), HasSubstr("empty"));
  write("txl1_x,txl1_y\n1,2\n");
  EXPECT_THAT(refusal(), HasSubstr("expected a CBOR map"));
  const auto refusal_of = [this](const nlohmann::json& header) {
    const auto item = nlohmann::json::to_cbor(header);
    write({item.begin(), item.end()});
    return refusal();
  };
  nlohmann::json good{{"format", "slipd-recording"},
                      {"version", 1},
                      {"sensor", "s"},
                      {"class", "array3"},
                      {"layout", {{"grid", {2, 2}}, {"pitch_m", 0.001}}},
                      {"rate_hz", 1},
                      {"simulated", false},
                      {"start_realtime_ns", 1},
                      {"start_monotonic_ns", 1},
                      {"description", ""}};
  EXPECT_EQ(refusal_of(good), "read");
  const auto with = [&good](const char* key, const nlohmann::json& value) {
    auto changed = good;
    changed[key] = value;
    return changed;
  };
  EXPECT_THAT(refusal_of(with("format", "other")), HasSubstr("slipd-recording"));
  EXPECT_THAT(refusal_of(with("version", 3)), HasSubstr("\"version\" is 3, expected 1 or 2"));
  EXPECT_THAT(refusal_of(with("class", "x")), HasSubstr("array3, wrench, normal or displacement"));
  EXPECT_THAT(refusal_of(with("rate_hz", "fast")), HasSubstr("\"rate_hz\" is \"fast\""));
  EXPECT_THAT(refusal_of(with("layout", {{"grid", {4096, 4096}}, {"pitch_m", 1}})), HasSubstr("1048576"));
  EXPECT_THAT(refusal_of(with("layout", {{"grid", {2, 2}}, {"pitch_m", -1}})), HasSubstr("pitch"));
  EXPECT_THAT(refusal_of(with("layout", nlohmann::json::object())), HasSubstr("layout"));
  good.erase("simulated");
  EXPECT_THAT(refusal_of(good), HasSubstr("no \"simulated\""));
}

TEST_F(Recordings, NeverCrashOnBytesAtRandom) {
  std::mt19937_64 random(20);  // NOLINT: the same bytes each time
  record(header_for(TaxelLayout::grid(2, 2, 0.001)), 3);
  const auto whole = bytes();
  for (int round = 0; round < 900; ++round) {
    auto content = whole;
    if (round % 3 == 0) {
      content.resize(random() % 300);
      for (auto& c : content) c = static_cast<char>(random());
      if (!content.empty() && round % 2 == 0) content[0] = static_cast<char>(0xA0 | (random() & 0x1F));
    } else {
      for (int flips = 1 + static_cast<int>(random() % 4); flips > 0; --flips) {
        content[random() % content.size()] = static_cast<char>(random());
      }
    }
    write(content);
    try {
      RecordingReader reader(path_);
      OwnedFrame frame(reader.header().layout.size());
      int frames = 0;
      while (reader.next_frame(frame.slot) == Status::frame) ++frames;
      EXPECT_LE(frames, 3);
    } catch (const RecordingError& e) {
      EXPECT_THAT(e.what(), HasSubstr("byte "));
    }
  }
  write(std::string(100000, '\x81'));  // arrays in arrays without end
  EXPECT_THAT(refusal(), HasSubstr("expected a CBOR map"));
  write("\xA1" + std::string(100000, '\x81'));
  EXPECT_THAT(refusal(), HasSubstr("no sound CBOR"));
}

TEST_F(Recordings, KeepTheFirstErrorOfTheDiskAndRefuseFramesOfAnotherSize) {
  const int full = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
  ASSERT_GE(full, 0);
  RecordingWriter writer(full, header_for(TaxelLayout::grid(2, 2, 0.001)), std::chrono::milliseconds(0));
  EXPECT_EQ(writer.append(some_frame(9, 0).slot), std::errc::invalid_argument);
  EXPECT_EQ(writer.append(some_frame(4, 0).slot), std::errc::no_space_on_device);
  EXPECT_EQ(writer.append(some_frame(4, 1).slot), std::errc::no_space_on_device);
  ::close(full);
}

TEST_F(Recordings, ThatAreNoFilesAreRefused) {
  EXPECT_THAT(refusal(), HasSubstr("No such file"));
  path_ = "/tmp";
  EXPECT_THAT(refusal(), HasSubstr("is a folder, not a regular file"));
  path_ = "";
}

}  // namespace
}  // namespace slipd
