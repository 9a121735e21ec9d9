#include "tools/slipctl/client.hpp"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "tests/support/patience.hpp"
#include "tests/tools/fake_daemon.hpp"

namespace slipctl::testing {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using slipd::testing::kPatience;
using ::testing::AllOf;
using ::testing::HasSubstr;

template <typename Action>
std::string complaint(Action action) {
  try {
    action();
  } catch (const ClientError& error) {
    return error.what();
  }
  return "no complaint";
}

std::string estimate_line(int sequence) {
  return json{{"jsonrpc", "2.0"}, {"method", "estimate"}, {"params", {{"seq", sequence}}}}.dump() + "\n";
}

TEST(Client, GivesTheResultOfItsRequest) {
  FakeDaemon daemon(by_method({{"version", [](const json&) { return json{{"name", "slipd"}}; }}}));
  EXPECT_EQ(json(RpcClient(daemon.path()).call("version")), (json{{"name", "slipd"}}));
}

TEST(Client, SendsJsonRpcOneObjectALine) {
  std::string line;
  FakeDaemon daemon([&](const Asked& asked) {
    line = asked.line;
    return result_line(asked.line, true);
  });
  RpcClient(daemon.path()).call("gamma", {{"sensor", "left"}});
  EXPECT_EQ(json::parse(line),
            (json{{"jsonrpc", "2.0"}, {"id", 1}, {"method", "gamma"}, {"params", {{"sensor", "left"}}}}));
}

TEST(Client, KeepsNotificationsThatComeBeforeTheAnswerInTheirOrder) {
  FakeDaemon daemon([](const Asked& asked) {
    return estimate_line(1) + estimate_line(2) + result_line(asked.line, {{"subscription", 1}}) +
           estimate_line(3);
  });
  RpcClient client(daemon.path());
  EXPECT_EQ(client.call("subscribe")["subscription"], 1);
  for (const int sequence : {1, 2, 3}) {
    const auto notification = client.next(kPatience);
    ASSERT_TRUE(notification);
    EXPECT_EQ(notification->method, "estimate");
    EXPECT_EQ(notification->params["seq"], sequence);
  }
  EXPECT_FALSE(client.next(0ms));
}

TEST(Client, TakesAnAnswerOfSeveralMegabytes) {
  const json values(std::vector<double>(200000, 12345.678));
  FakeDaemon daemon(by_method({{"frame", [&](const json&) { return values; }}}));
  EXPECT_EQ(json(RpcClient(daemon.path()).call("frame")), values);
}

TEST(Client, CopiesARecordingIntoAFileAndKeepsWhatElseIsSaid) {
  FakeDaemon daemon([](const Asked& asked) {
    return recording_line(asked, "first ") +
           json{{"jsonrpc", "2.0"}, {"method", "estimate"}, {"params", {{"seq", 1}}}}.dump() + "\n" +
           result_line(asked.line, true);
  });
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const UniqueFd read_end(pipe[0]);
  const UniqueFd writing(pipe[1]);
  RpcClient client(daemon.path());
  EXPECT_EQ(client.record("left", 1, writing.get())["frames"], 3);
  std::array<char, 8> bytes{};
  ASSERT_EQ(::read(read_end.get(), bytes.data(), bytes.size()), 6);
  EXPECT_EQ(std::string(bytes.data()), "first ");
  const auto kept = client.next(kPatience);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->method, "estimate");
}

TEST(Client, ThrowsTheDaemonsErrorWithItsCode) {
  FakeDaemon daemon(
      [](const Asked& asked) { return error_line(asked.line, -32001, "no sensor is called lfet"); });
  RpcClient client(daemon.path());
  try {
    client.call("gamma");
    FAIL() << "no error";
  } catch (const RpcError& error) {
    EXPECT_EQ(error.code(), -32001);
    EXPECT_STREQ(error.what(), "no sensor is called lfet");
  }
}

TEST(Client, SaysWhichSocketIsNotThereAndWhatToDo) {
  EXPECT_THAT(
      complaint([] { RpcClient("/nowhere/slipd.sock"); }),
      AllOf(HasSubstr("/nowhere/slipd.sock"), HasSubstr("systemctl start slipd"), HasSubstr("--socket")));
}

TEST(Client, SaysThatNobodyListensAtASocketLeftBehind) {
  const std::string folder = temporary_folder();
  const std::string path = folder + "/left-behind.sock";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  const UniqueFd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_EQ(::bind(socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  EXPECT_THAT(complaint([&] { RpcClient client(path); }),
              AllOf(HasSubstr(path), HasSubstr("nobody listens")));
  std::filesystem::remove_all(folder);
}

// Permission is never denied to root, so root acts as another user here.
class AsNobody {
 public:
  AsNobody() {
    if (::getuid() == 0 && ::seteuid(65534) != 0) throw std::runtime_error("cannot become nobody");
  }
  ~AsNobody() {
    if (::getuid() == 0 && ::seteuid(0) != 0) std::abort();
  }
};

TEST(Client, NamesTheGroupWhenPermissionIsDenied) {
  FakeDaemon daemon(by_method({}));
  std::filesystem::permissions(daemon.path(), std::filesystem::perms::none);
  const AsNobody nobody;
  EXPECT_THAT(complaint([&] { RpcClient client(daemon.path()); }), HasSubstr("group slipd"));
}

TEST(Client, RefusesAPathLongerThanASocketsCanBe) {
  EXPECT_THAT(complaint([] { RpcClient(std::string(200, 'x')); }), HasSubstr("107 bytes"));
}

TEST(Client, SaysSoWhenTheDaemonDoesNotAnswer) {
  FakeDaemon daemon([](const Asked&) { return ""; });
  EXPECT_THAT(complaint([&] { RpcClient(daemon.path()).call("status", json::object(), 20ms); }),
              HasSubstr("did not answer status within 20 ms"));
}

TEST(Client, SaysSoWhenTheDaemonHangsUp) {
  FakeDaemon daemon([](const Asked&) { return std::nullopt; });
  EXPECT_THAT(complaint([&] { RpcClient(daemon.path()).call("status"); }),
              HasSubstr("closed the connection"));
}

TEST(Client, SaysSoWhenSomethingElseAnswers) {
  for (const char* answer : {"HTTP/1.1 400 Bad Request\n", "[]\n", "\n", "\xff\xfe\n"}) {
    FakeDaemon daemon([=](const Asked&) { return answer; });
    EXPECT_THAT(complaint([&] { RpcClient(daemon.path()).call("status"); }),
                HasSubstr("does not speak JSON-RPC"));
  }
}

}  // namespace
}  // namespace slipctl::testing
