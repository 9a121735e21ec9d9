#include "tools/slipctl/terminal.hpp"

#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <string_view>

namespace slipctl {
namespace {

constexpr std::string_view kEnter = "\x1b[?1049h\x1b[?25l\x1b[?7l";  // alternate screen, no cursor, no wrap
constexpr std::string_view kLeave = "\x1b[0m\x1b[?7h\x1b[?25h\x1b[?1049l";

void write_all(std::string_view bytes) noexcept {
  while (!bytes.empty()) {
    const ssize_t count = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (count < 0 && errno != EINTR) return;  // the terminal is gone: nothing to restore
    if (count > 0) bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): one thread
  return value == nullptr ? std::string_view{} : value;
}

}  // namespace

SignalWatch::SignalWatch() {
  sigset_t wanted;
  sigemptyset(&wanted);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGWINCH, SIGTSTP}) sigaddset(&wanted, signal);
  pthread_sigmask(SIG_BLOCK, &wanted, &before_);
  fd_ = UniqueFd(::signalfd(-1, &wanted, SFD_CLOEXEC | SFD_NONBLOCK));
}

SignalWatch::~SignalWatch() {
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

std::optional<int> SignalWatch::take() const {
  signalfd_siginfo info;
  if (::read(fd_.get(), &info, sizeof info) != sizeof info) return std::nullopt;
  return static_cast<int>(info.ssi_signo);
}

Terminal::Terminal() : depth_(colour_depth()), keys_(::isatty(STDIN_FILENO) == 1) {
  if (keys_) keys_ = ::tcgetattr(STDIN_FILENO, &before_) == 0;
  enter();
}

Terminal::~Terminal() {
  leave();
}

void Terminal::enter() {
  if (keys_) {
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // ISIG stays: Ctrl-C and Ctrl-Z send their signals
    raw.c_cc[VMIN] = 0;
    raw.c_cc[VTIME] = 0;
    ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  }
  write_all(kEnter);
  redraw();
}

void Terminal::leave() noexcept {
  write_all(kLeave);
  if (keys_) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
}

Terminal::Size Terminal::size() const {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {80, 24};
  return {size.ws_col, size.ws_row};
}

int terminal_columns() {
  winsize size{};
  return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

void Terminal::show(const Canvas& canvas) {
  write_all(encode_change(shown_ ? &*shown_ : nullptr, canvas, depth_));
  shown_ = canvas;
}

std::string Terminal::read_keys() {
  std::array<char, 64> keys;
  const ssize_t count = ::read(STDIN_FILENO, keys.data(), keys.size());
  if (count > 0) return {keys.data(), static_cast<std::size_t>(count)};
  keys_ = false;
  return {};
}

void Terminal::suspend() {
  leave();
  ::raise(SIGSTOP);
  enter();
}

ViewSignals take_view_signals(const SignalWatch& signals, std::optional<Terminal>& terminal) {
  ViewSignals asked;
  while (const auto signal = signals.take()) {
    if (*signal == SIGWINCH) {
      if (terminal) terminal->redraw();
      asked.resized = true;
    } else if (*signal == SIGTSTP) {
      if (terminal)
        terminal->suspend();
      else
        ::raise(SIGSTOP);
    } else {
      asked.end = true;
    }
  }
  return asked;
}

ColourDepth colour_depth() {
  const std::string_view term = variable("TERM");
  if (!variable("NO_COLOR").empty() || term == "dumb") return ColourDepth::none;
  const std::string_view direct = variable("COLORTERM");
  if (direct == "truecolor" || direct == "24bit") return ColourDepth::rgb;
  if (term.find("256color") != std::string_view::npos) return ColourDepth::indexed256;
  return ColourDepth::basic16;
}

}  // namespace slipctl
