// MCAP files, walked record by record from their bytes. tests/bridges/ros2/peers has readers of others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "bridges/ros2/mcap/mcap_reader.hpp"
#include "bridges/ros2/mcap/mcap_writer.hpp"
#include "bridges/ros2/messages/cdr.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::ros2 {
namespace {

using slipd::testing::TempFolder;
using ::testing::HasSubstr;

struct Record {
  int op = 0;
  std::size_t at = 0;
  std::string content;
};

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.substr(at, sizeof value).data(), sizeof value);
  return value;
}

std::vector<Record> records_of(const std::string& bytes, std::size_t from, std::size_t to) {
  std::vector<Record> records;
  while (from < to) {
    const auto size = number_at<std::uint64_t>(bytes, from + 1);
    records.push_back({static_cast<unsigned char>(bytes[from]), from, bytes.substr(from + 9, size)});
    from += 9 + size;
  }
  EXPECT_EQ(from, to);
  return records;
}

std::uint32_t crc_of(const std::string& bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

constexpr std::size_t kMagicBytes = 8;

class Mcap : public ::testing::Test {
 protected:
  // Two topics with `messages` each, in chunks of a few messages.
  std::string written(int messages) {
    McapWriter writer(folder_.file("a.mcap"), {.library = "test", .chunk_bytes = 400});
    const auto margin = writer.add_channel<Float32>("/a/margin");
    const auto other = writer.add_channel<Float32>("/b/margin");
    std::vector<std::uint8_t> cdr;
    for (int i = 0; i < messages; ++i) {
      encode(Float32{.data = static_cast<float>(i)}, cdr);
      writer.write(margin, 1000 + static_cast<std::uint64_t>(i), cdr);
      writer.write(other, 1000 + static_cast<std::uint64_t>(i), cdr);
    }
    writer.close();
    std::ifstream file(folder_.file("a.mcap"), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  TempFolder folder_;
};

TEST_F(Mcap, HoldsEveryMessageInOrderAndItsChecksumsHold) {
  constexpr int kMessages = 40;
  const std::string bytes = written(kMessages);
  ASSERT_EQ(bytes.substr(0, kMagicBytes), bytes.substr(bytes.size() - kMagicBytes));
  float next = 0;
  int found = 0;
  for (const Record& record : records_of(bytes, kMagicBytes, bytes.size() - kMagicBytes)) {
    if (record.op == 0x0F) {
      EXPECT_EQ(number_at<std::uint32_t>(record.content, 0), crc_of(bytes.substr(0, record.at)));
    }
    if (record.op == 0x02) {
      const auto summary = number_at<std::uint64_t>(record.content, 0);
      EXPECT_EQ(number_at<std::uint32_t>(record.content, 16),
                crc_of(bytes.substr(summary, record.at + 9 + 16 - summary)));
    }
    if (record.op != 0x06) continue;
    const auto size = number_at<std::uint64_t>(record.content, 16);
    std::string chunk(size, '\0');
    LZ4F_dctx* context = nullptr;
    LZ4F_createDecompressionContext(&context, LZ4F_VERSION);
    std::size_t out = size;
    std::size_t in = record.content.size() - 43;  // behind the numbers, "lz4" and the length
    LZ4F_decompress(context, chunk.data(), &out, record.content.data() + 43, &in, nullptr);
    LZ4F_freeDecompressionContext(context);
    EXPECT_EQ(out, size);
    EXPECT_EQ(number_at<std::uint32_t>(record.content, 24), crc_of(chunk));
    for (const Record& message : records_of(chunk, 0, chunk.size())) {
      EXPECT_EQ(message.op, 0x05);
      const auto channel = number_at<std::uint16_t>(message.content, 0);
      EXPECT_EQ(number_at<std::uint32_t>(message.content, 2), static_cast<std::uint32_t>(next)) << "sequence";
      EXPECT_EQ(number_at<float>(message.content, 26), next);
      next += channel == 1 ? 1.0F : 0.0F;
      ++found;
    }
  }
  EXPECT_EQ(found, 2 * kMessages);
}

TEST_F(Mcap, ItsIndexesPointAtWhatTheySay) {
  const std::string bytes = written(40);
  const auto footer_at = bytes.size() - kMagicBytes - 9 - 20;
  const auto summary_at = number_at<std::uint64_t>(bytes, footer_at + 9);
  const auto offsets_at = number_at<std::uint64_t>(bytes, footer_at + 17);
  int chunks = 0;
  for (const Record& record : records_of(bytes, summary_at, offsets_at)) {
    if (record.op != 0x08) continue;
    ++chunks;
    const auto chunk_at = number_at<std::uint64_t>(record.content, 16);
    EXPECT_EQ(bytes[chunk_at], 0x06);
    EXPECT_EQ(number_at<std::uint64_t>(bytes, chunk_at + 1) + 9,
              number_at<std::uint64_t>(record.content, 24));
    ASSERT_EQ(number_at<std::uint32_t>(record.content, 32), 20U)
        << "two channels have messages in each chunk";
    for (const std::size_t entry : {36U, 46U}) {
      const auto index_at = number_at<std::uint64_t>(record.content, entry + 2);
      EXPECT_EQ(bytes[index_at], 0x07);
      EXPECT_EQ(number_at<std::uint16_t>(bytes, index_at + 9),
                number_at<std::uint16_t>(record.content, entry));
    }
  }
  EXPECT_GT(chunks, 3);
  for (const Record& record : records_of(bytes, offsets_at, footer_at)) {
    EXPECT_EQ(record.op, 0x0E);
    EXPECT_EQ(bytes[number_at<std::uint64_t>(record.content, 1)], record.content[0]);
  }
}

TEST_F(Mcap, WithoutMessagesIsWhole) {
  const std::string bytes = written(0);
  EXPECT_EQ(records_of(bytes, kMagicBytes, bytes.size() - kMagicBytes).back().op, 0x02);
}

TEST_F(Mcap, DoesNotReplaceAFileUnlessToldTo) {
  written(1);
  try {
    const McapWriter writer(folder_.file("a.mcap"), {});
    FAIL() << "replaced";
  } catch (const McapError& error) {
    EXPECT_THAT(error.what(), HasSubstr("exists already"));
  }
  const McapWriter writer(folder_.file("a.mcap"), {.overwrite = true});
}

TEST(McapErrors, AreSaidWhenTheDiskIsFull) {
  EXPECT_THROW(McapWriter("/dev/full", {.overwrite = true}), McapError);
}

// What a reader of these bytes says of each message, and its fault at the end.
struct Heard {
  explicit Heard(const std::string& bytes) {
    std::istringstream in(bytes);
    McapReader reader(in, "a.mcap");
    for (McapMessage message; reader.next(message);) {
      Float32 value;
      EXPECT_TRUE(decode(message.data, value));
      EXPECT_EQ(message.schema, "std_msgs/msg/Float32");
      EXPECT_EQ(message.encoding, "cdr");
      values.push_back(value.data);
      times_ns.push_back(message.publish_ns);
    }
    fault = reader.fault();
  }
  std::vector<float> values;
  std::vector<std::uint64_t> times_ns;
  std::string fault;
};

constexpr int kSomeMessages = 50;

TEST_F(Mcap, TheReaderGivesTheMessagesThatTheWriterHasWritten) {
  const std::string bytes = written(kSomeMessages);
  const Heard heard(bytes);
  EXPECT_EQ(heard.fault, "");
  EXPECT_EQ(heard.values.size(), 2U * kSomeMessages);
  EXPECT_TRUE(std::is_sorted(heard.times_ns.begin(), heard.times_ns.end()));
}

TEST_F(Mcap, AFileThatWasCutAnywhereGivesABeginningAndSaysSo) {
  const std::string bytes = written(kSomeMessages);
  const Heard whole(bytes);
  const std::size_t data_end = bytes.size() - 100;  // at least: the summary stands behind the data
  for (std::size_t length = kMagicBytes; length < bytes.size(); length += 7) {
    const Heard part(bytes.substr(0, length));
    ASSERT_LE(part.values.size(), whole.values.size());
    EXPECT_TRUE(std::equal(part.values.begin(), part.values.end(), whole.values.begin())) << length;
    if (part.values.size() < whole.values.size()) {
      EXPECT_THAT(part.fault, HasSubstr("was cut")) << length;
    }
    if (length > data_end) {
      EXPECT_EQ(part.values.size(), whole.values.size());
    }
  }
}

TEST_F(Mcap, AChunkWithAnotherByteIsLeftOutAndTheOthersAreRead) {
  std::string bytes = written(kSomeMessages);
  const std::size_t whole = Heard(bytes).values.size();
  const auto records = records_of(bytes, kMagicBytes, bytes.size() - kMagicBytes);
  const auto chunk =
      std::find_if(records.begin(), records.end(), [](const Record& one) { return one.op == 6; });
  ASSERT_NE(chunk, records.end());
  bytes[chunk->at + 9 + chunk->content.size() - 8] ^= 0x10;
  const Heard heard(bytes);
  EXPECT_GT(heard.values.size(), 0U);
  EXPECT_LT(heard.values.size(), whole);
  EXPECT_THAT(heard.fault, HasSubstr("the chunk is damaged"));
}

TEST_F(Mcap, WhatIsNoMcapFileIsRefused) {
  std::istringstream in("a recording of something else");
  EXPECT_THROW(McapReader(in, "a.mcap"), McapError);
}

}  // namespace
}  // namespace slipd::ros2
