// Entries are as journald's native protocol has them. The guest's tests read them from a real journal.
#include "daemon/log/journal.hpp"

#include <gtest/gtest.h>

#include <string>

namespace slipd {
namespace {

using namespace std::string_literals;

TEST(JournalEntry, IsALineForEachField) {
  EXPECT_EQ(JournalEntry().add("MESSAGE", "hello").add("PRIORITY", "6").bytes(),
            "MESSAGE=hello\nPRIORITY=6\n");
}

TEST(JournalEntry, GivesTheLengthOfAValueOfSeveralLines) {
  EXPECT_EQ(JournalEntry().add("MESSAGE", "one\ntwo").add("PRIORITY", "4").bytes(),
            "MESSAGE\n\x07\0\0\0\0\0\0\0one\ntwo\nPRIORITY=4\n"s);
}

TEST(JournalEntry, AValueCannotPassForAnotherField) {
  const std::string bytes = JournalEntry().add("MESSAGE", "a\nPRIORITY=0").bytes();
  EXPECT_EQ(bytes.substr(0, 8), "MESSAGE\n") << "its length is given, so journald reads no field in it";
}

}  // namespace
}  // namespace slipd
