#include "bridges/support/line_socket.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <vector>

#include "bridges/support/unix_address.hpp"

namespace slipd::bridges {
namespace {

using std::chrono::milliseconds;

std::string in_capitals(const std::string& line) {
  std::string answer = line;
  for (char& c : answer) c = static_cast<char>(std::toupper(c));
  return answer;
}

class LineSocketTest : public ::testing::Test {
 protected:
  LineSocketTest() {
    std::string name = "/tmp/slipd-line-XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  ~LineSocketTest() override {
    for (const int fd : ends_) close(fd);
    std::filesystem::remove_all(folder_);
  }

  std::string path() const { return folder_ + "/socket"; }
  // A client that stays.
  int connect_to() {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    const sockaddr_un address = unix_address(path()).value();
    EXPECT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ends_.push_back(fd);
    return fd;
  }
  // What comes until the last line has ended; shorter if the other end has closed.
  std::string answers(int fd, const std::string& said, std::size_t lines) {
    EXPECT_EQ(send(fd, said.data(), said.size(), MSG_NOSIGNAL), static_cast<ssize_t>(said.size()));
    std::string heard;
    while (std::count(heard.begin(), heard.end(), '\n') < static_cast<std::ptrdiff_t>(lines)) {
      loop_.run_once(milliseconds(0));
      char bytes[256];
      const ssize_t got = recv(fd, bytes, sizeof bytes, MSG_DONTWAIT);
      if (got == 0 || (got < 0 && errno != EAGAIN)) break;
      if (got > 0) heard.append(bytes, static_cast<std::size_t>(got));
    }
    return heard;
  }

  Loop loop_;
  std::string folder_;
  std::vector<int> ends_;
};

TEST_F(LineSocketTest, AnswersEachLineOfAConnection) {
  const LineSocket socket(loop_, path(), in_capitals);
  const int client = connect_to();
  EXPECT_EQ(answers(client, "a\nb", 1), "A\n");
  EXPECT_EQ(answers(client, "c\nd\n", 2), "BC\nD\n");
}

TEST_F(LineSocketTest, IsAskedByOneCall) {
  const LineSocket socket(loop_, path(), in_capitals);
  std::string answer;
  std::thread other([&] { answer = ask(path(), "status"); });
  while (answer.empty()) loop_.run_once(milliseconds(10));
  other.join();
  EXPECT_EQ(answer, "STATUS");
}

TEST_F(LineSocketTest, SendsAwayWhoTalksTooMuch) {
  const LineSocket socket(loop_, path(), in_capitals, {.longest_line = 8, .most_peers = 4, .refusal = {}});
  EXPECT_EQ(answers(connect_to(), "12345678\n", 1), "12345678\n");
  EXPECT_EQ(answers(connect_to(), "123456789\n", 1), "");
  EXPECT_EQ(answers(connect_to(), "no end of it", 1), "");
}

TEST_F(LineSocketTest, RefusesOneTooManyWhereItIsTold) {
  const LineSocket socket(loop_, path(), in_capitals,
                          {.longest_line = 8, .most_peers = 1, .refusal = "taken"});
  const int first = connect_to();
  EXPECT_EQ(answers(first, "a\n", 1), "A\n");
  EXPECT_EQ(answers(connect_to(), "b\n", 1), "taken\n");
  EXPECT_EQ(answers(first, "c\n", 1), "C\n");
}

TEST_F(LineSocketTest, EndsTheOldestElse) {
  const LineSocket socket(loop_, path(), in_capitals, {.longest_line = 8, .most_peers = 1, .refusal = {}});
  const int first = connect_to();
  EXPECT_EQ(answers(first, "a\n", 1), "A\n");
  EXPECT_EQ(answers(connect_to(), "b\n", 1), "B\n");
  char byte = 0;
  EXPECT_EQ(recv(first, &byte, 1, MSG_DONTWAIT), 0);
}

TEST_F(LineSocketTest, ReplacesASocketThatNobodyListensOn) {
  {
    const int left = ::socket(AF_UNIX, SOCK_STREAM, 0);
    const sockaddr_un address = unix_address(path()).value();
    ASSERT_EQ(::bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    close(left);
  }
  const LineSocket socket(loop_, path(), in_capitals);
  EXPECT_EQ(answers(connect_to(), "a\n", 1), "A\n");
}

TEST_F(LineSocketTest, RefusesAPathThatAnotherProgramHas) {
  const LineSocket socket(loop_, path(), in_capitals);
  try {
    const LineSocket second(loop_, path(), in_capitals);
    FAIL() << "two listen";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("another program listens there"), std::string::npos);
  }
}

TEST_F(LineSocketTest, IsForOwnerAndGroup) {
  const LineSocket socket(loop_, path(), in_capitals);
  struct stat info {};
  ASSERT_EQ(stat(path().c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0660U);
}

}  // namespace
}  // namespace slipd::bridges
