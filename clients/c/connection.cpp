#include "clients/c/connection.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <system_error>

#include "clients/c/slipd.h"
#include "core/storage/descriptor_passing.hpp"

namespace slipd::client {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{64} * 1024;
// Longest line, bytes. A frame of a million taxels fits; more is an error of the other end.
constexpr std::size_t kLongestLine = std::size_t{64} << 20;

const char* why_not_connected(int error) {
  switch (error) {
    case ENOENT:
      return "slipd does not run here, nothing is there: start it (systemctl start slipd), or give the path "
             "of "
             "its socket";
    case ECONNREFUSED:
      return "slipd does not run here, nobody listens: it has stopped or is just starting (systemctl status "
             "slipd)";
    case EACCES:
    case EPERM:
      return "not permitted: become a member of the group slipd (usermod -aG slipd USER), and log in again";
    case EAGAIN:
      return "slipd accepts no connections now; try again";
    default:
      return nullptr;
  }
}

[[noreturn]] void disconnected(const std::string& path, int error) {
  const char* const why = why_not_connected(error);
  throw Failure(SLIPD_DISCONNECTED,
                path + ": " + (why != nullptr ? why : std::generic_category().message(error)));
}

[[noreturn]] void gone() {
  throw Failure(SLIPD_DISCONNECTED, "slipd has closed the connection: it was stopped or restarted");
}

[[noreturn]] void foreign(const std::string& why) {
  throw Failure(SLIPD_DISCONNECTED, "what answers is not slipd: it " + why);
}

}  // namespace

void throw_error_of(const Json& message, bool ours) {
  const auto error = message.find("error");
  if (error == message.end()) return;
  if (!error->is_object()) foreign("sends an error without a text");
  const auto code = error->find("code"), text = error->find("message");
  throw Failure(ours ? SLIPD_REFUSED : SLIPD_DISCONNECTED,
                text != error->end() && text->is_string() ? text->get<std::string>() : "slipd refuses this",
                ours && code != error->end() && code->is_number_integer() ? code->get<int>() : 0);
}

Json message_of(std::string_view line) {
  Json message = Json::parse(line, nullptr, false);
  if (!message.is_object()) foreign("does not speak JSON-RPC: " + std::string(line.substr(0, 60)));
  return message;
}

void Connection::connect(const std::string& path) {
  if (connected()) return;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path)
    throw Failure(SLIPD_INVALID, "the socket's path \"" + path + "\" must have 1 to " +
                                     std::to_string(sizeof address.sun_path - 1) + " bytes");
  path.copy(address.sun_path, path.size());
  UniqueFd made(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!made) disconnected(path, errno);
  if (::connect(made.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    disconnected(path, errno);
  close();
  socket_ = std::move(made);
}

void Connection::close() noexcept {
  socket_ = {};
  passed_ = {};
  input_.clear();
  begin_ = searched_ = 0;
}

// False: it is not ready in time.
bool Connection::wait_for(short events, Clock::time_point until) const {
  pollfd ready{socket_.get(), events, 0};
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    const int got = poll(&ready, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
    if (got >= 0) return got > 0;
    if (errno != EINTR) throw Failure(SLIPD_DISCONNECTED, std::generic_category().message(errno));
  }
}

std::uint64_t Connection::request(std::string_view method, std::string_view params, Clock::time_point until) {
  const std::uint64_t id = ++last_id_;
  std::string text = R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"method":")";
  text.append(method).append(R"(","params":)").append(params).append("}\n");
  for (std::size_t sent = 0; sent < text.size();) {
    const auto more =
        send(socket_.get(), text.data() + sent, text.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (more >= 0) {
      sent += static_cast<std::size_t>(more);
    } else if (errno == EAGAIN) {
      if (!wait_for(POLLOUT, until)) throw Failure(SLIPD_TIMEOUT, "slipd does not read in time");
    } else if (errno != EINTR) {
      gone();
    }
  }
  return id;
}

// False: nothing came in time.
bool Connection::receive(Clock::time_point until) {
  input_.erase(0, begin_);
  searched_ -= begin_;
  begin_ = 0;
  const std::size_t had = input_.size();
  if (had > kLongestLine) foreign("sends a line without end");
  piece_.resize(kPieceBytes);
  PassedDescriptors passed;
  const auto got = receive_passed(socket_.get(), std::span(piece_), passed, MSG_DONTWAIT);
  const int error = errno;
  input_.append(piece_.data(), static_cast<std::size_t>(std::max<ssize_t>(0, got)));
  if (got < 0 && (error == EAGAIN || error == EINTR)) {
    return Clock::now() < until && wait_for(POLLIN, until);
  }
  if (got <= 0) gone();
  if (passed.count > 0) passed_ = std::move(passed.files[passed.count - 1]);
  return true;
}

bool Connection::line(std::string_view& out, Clock::time_point until) {
  for (;;) {
    const std::size_t end = input_.find('\n', searched_);
    if (end == std::string::npos) {
      searched_ = input_.size();
      if (!receive(until)) return false;
      continue;
    }
    out = std::string_view(input_).substr(begin_, end - begin_);
    begin_ = searched_ = end + 1;
    return true;
  }
}

bool Connection::message(Json& out, Clock::time_point until) {
  std::string_view text;
  if (!line(text, until)) return false;
  out = message_of(text);
  return true;
}

Json Connection::answer(std::uint64_t id, Clock::time_point until, const std::function<void(Json&&)>& other) {
  Json message;
  while (this->message(message, until)) {
    const auto its_id = message.find("id");
    const bool ours = its_id != message.end() && *its_id == id;
    const bool nobodys = its_id == message.end() || its_id->is_null();
    if (ours || nobodys) throw_error_of(message, ours);
    if (!ours) {
      if (other) other(std::move(message));
      continue;
    }
    const auto result = message.find("result");
    if (result == message.end()) foreign("answers with neither a result nor an error");
    return std::move(*result);
  }
  throw Failure(SLIPD_TIMEOUT, "slipd does not answer in time");
}

}  // namespace slipd::client
