// The thin part of `slipctl watch` that touches the terminal and the process's signals. One thread.
//
// Signals are taken from a descriptor in the watch's own loop, so that whatever ends it unwinds through the
// destructor that gives the terminal back; nothing happens in a signal handler.
#pragma once

#include <termios.h>

#include <optional>
#include <string>

#include "core/storage/unique_fd.hpp"
#include "tools/slipctl/canvas.hpp"

namespace slipctl {

using slipd::UniqueFd;

// Blocks SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGWINCH and SIGTSTP for as long as it lives; they are read from
// fd().
class SignalWatch {
 public:
  SignalWatch();
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;
  int fd() const noexcept { return fd_.get(); }
  std::optional<int> take() const;  // the next signal that came, if any

 private:
  sigset_t before_;
  UniqueFd fd_;
};

// A terminal on stdout, in its alternate screen, with keys coming at once and unseen. Restored by the
// destructor.
class Terminal {
 public:
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  struct Size {
    int columns, rows;
  };
  Size size() const;  // 80 x 24 where the terminal does not say

  void show(const Canvas& canvas);   // writes what changed since the last one
  void redraw() { shown_.reset(); }  // the next show writes all

  bool has_keys() const noexcept { return keys_; }  // false: stdin is no terminal, or was closed
  std::string read_keys();

  void
  suspend();  // gives the terminal back, stops the process, and takes the terminal again once it is continued

  ColourDepth depth() const noexcept { return depth_; }

 private:
  void enter();
  void leave() noexcept;
  ColourDepth depth_;
  bool keys_;
  termios before_{};
  std::optional<Canvas> shown_;
};

int terminal_columns();  // of standard output; 80 where it does not say

// What the environment (NO_COLOR, COLORTERM, TERM) says of colours.
ColourDepth colour_depth();

}  // namespace slipctl
