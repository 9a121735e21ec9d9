#include "bridges/feed/assembler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

namespace slipd::feed {
namespace {

// Number, last and place of one byte each.
const Datagrams kRule{3, {0, {}}, {2, {}}, {1, {}}};

std::vector<std::uint8_t> datagram(std::uint8_t number, std::uint8_t last, std::uint8_t part) {
  return {number, last, part, static_cast<std::uint8_t>(number + part)};
}

std::vector<std::uint8_t> content(std::uint8_t number, std::uint8_t parts) {
  std::vector<std::uint8_t> all(parts);
  for (std::uint8_t i = 0; i < parts; ++i) all[i] = static_cast<std::uint8_t>(number + i);
  return all;
}

using Result = Assembler::Result;

TEST(Assembler, MakesTheSameMessageOfDatagramsInAnyOrder) {
  std::mt19937 random(1);
  Assembler assembler(kRule, false);
  for (std::uint8_t number = 0; number < 100; ++number) {
    std::vector<std::uint8_t> order{0, 1, 2, 3, 4};
    std::ranges::shuffle(order, random);
    Message message;
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_EQ(assembler.put("a", datagram(number, 4, order[i]), message), Result::incomplete);
    ASSERT_EQ(assembler.put("a", datagram(number, 4, order[4]), message), Result::message);
    EXPECT_TRUE(std::ranges::equal(message.body, content(number, 5)));
  }
  EXPECT_EQ(assembler.lost(), 0U);
}

TEST(Assembler, KeepsMessagesOfTheSameNumberFromTwoSendersApart) {
  Assembler assembler(kRule, false);
  Message message;
  assembler.put("a", datagram(1, 1, 0), message);
  EXPECT_EQ(assembler.put("b", datagram(1, 1, 1), message), Result::incomplete);
  EXPECT_EQ(assembler.put("a", datagram(1, 1, 1), message), Result::message);
}

TEST(Assembler, RefusesWhatIsNoPartOfAMessage) {
  Assembler assembler(kRule, true);
  Message message;
  const auto put = [&](std::vector<std::uint8_t> bytes) { return assembler.put("a", bytes, message); };
  EXPECT_EQ(put({}), Result::corrupt);
  EXPECT_EQ(put({1, 1, 0}), Result::corrupt) << "nothing behind the header";
  EXPECT_EQ(put({1, 1, 2, 9}), Result::corrupt) << "behind the last";
  EXPECT_EQ(put({1, 0, 0, 9}), Result::corrupt) << "a head and nothing else";
  EXPECT_EQ(put({1, 2, 0, 9}), Result::incomplete);
  EXPECT_EQ(put({1, 2, 0, 9}), Result::corrupt) << "twice";
  EXPECT_EQ(put({1, 3, 1, 9}), Result::corrupt) << "of another length";
}

TEST(Assembler, KeepsFewMessagesOfWhichPartsAreMissing) {
  Assembler assembler(kRule, false);
  Message message;
  for (std::uint8_t number = 0; number < 200; ++number) assembler.put("a", datagram(number, 1, 0), message);
  EXPECT_EQ(assembler.lost(), 192U);
  EXPECT_EQ(assembler.put("a", datagram(199, 1, 1), message), Result::message);
  EXPECT_EQ(assembler.put("a", datagram(0, 1, 1), message), Result::incomplete);
}

TEST(Assembler, MakesNoMessageOfTwoWhoseNumberIsTheSame) {
  Assembler assembler(kRule, false);
  Message message;
  const std::vector<std::uint8_t> before[] = {{7, 2, 0, 'a'}, {7, 2, 1, 'a'}};
  for (const auto& part : before) assembler.put("a", part, message);
  for (std::uint8_t number = 8; number < 16; ++number)
    for (std::uint8_t part : {0, 1}) assembler.put("a", datagram(number, 1, part), message);
  EXPECT_EQ(assembler.lost(), 1U) << "eight later ones have begun";

  const std::vector<std::uint8_t> after[] = {{7, 2, 2, 'b'}, {7, 2, 0, 'b'}, {7, 2, 1, 'b'}};
  EXPECT_EQ(assembler.put("a", after[0], message), Result::incomplete);
  EXPECT_EQ(assembler.put("a", after[1], message), Result::incomplete);
  ASSERT_EQ(assembler.put("a", after[2], message), Result::message);
  EXPECT_EQ(std::string(message.body.begin(), message.body.end()), "bbb");
  EXPECT_EQ(assembler.lost(), 1U);
}

TEST(Assembler, BeginsAMessageAnewWhenAPartComesWithOtherContent) {
  Assembler assembler(kRule, false);
  Message message;
  const std::vector<std::uint8_t> parts[] = {
      {0, 2, 0, 'a'}, {0, 2, 1, 'a'}, {0, 2, 0, 'b'}, {0, 2, 1, 'b'}, {0, 2, 2, 'b'}};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(assembler.put("a", parts[i], message), Result::incomplete) << i;
  ASSERT_EQ(assembler.put("a", parts[4], message), Result::message);
  EXPECT_EQ(std::string(message.body.begin(), message.body.end()), "bbb");
  EXPECT_EQ(assembler.lost(), 1U);
}

TEST(Assembler, LosesNothingWhenTheNetworkDoublesDatagrams) {
  Assembler assembler(kRule, false);
  Message message;
  int whole = 0;
  for (std::uint8_t number = 0; number < 100; ++number)
    for (const std::uint8_t part : {0, 0, 1, 1})
      whole += assembler.put("a", datagram(number, 1, part), message) == Result::message ? 1 : 0;
  EXPECT_EQ(whole, 100);
  EXPECT_EQ(assembler.lost(), 0U);
}

}  // namespace
}  // namespace slipd::feed
