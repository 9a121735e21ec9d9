// The part of live views that uses the terminal and the process's signals. Called from one thread.
//
// A view's loop reads signals from a descriptor, so that every way out runs the destructor that restores
// the terminal. There is no signal handler.
#pragma once

#include <termios.h>

#include <optional>
#include <string>

#include "core/storage/unique_fd.hpp"
#include "tools/slipctl/canvas.hpp"

namespace slipctl {

using slipd::UniqueFd;

// Blocks SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGWINCH and SIGTSTP during its lifetime; fd() delivers them.
class SignalWatch {
 public:
  SignalWatch();
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;
  int fd() const noexcept { return fd_.get(); }
  std::optional<int> take() const;  // the next pending signal, if any

 private:
  sigset_t before_;
  UniqueFd fd_;
};

// A terminal on stdout: alternate screen, keys without line buffering and echo. The destructor restores it.
class Terminal {
 public:
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  struct Size {
    int columns;  // characters
    int rows;     // characters
  };
  Size size() const;  // 80 x 24 where the terminal reports none

  void show(const Canvas& canvas);   // writes the changes since the last show()
  void redraw() { shown_.reset(); }  // the next show() writes everything

  bool has_keys() const noexcept { return keys_; }  // false: stdin is not a terminal, or was closed
  std::string read_keys();

  // Restores the terminal, stops the process, and takes the terminal again when the process is continued.
  void suspend();

  ColourDepth depth() const noexcept { return depth_; }

 private:
  void enter();
  void leave() noexcept;
  ColourDepth depth_;
  bool keys_;
  termios before_{};
  std::optional<Canvas> shown_;
};

// What the signals that have come ask of a live view.
struct ViewSignals {
  bool end = false;      // SIGINT, SIGTERM, SIGHUP or SIGQUIT
  bool resized = false;  // the next show() writes everything
};
// Takes them. SIGTSTP stops the process here, with the terminal restored meanwhile; `terminal` is empty for a
// view without one.
ViewSignals take_view_signals(const SignalWatch& signals, std::optional<Terminal>& terminal);

int terminal_columns();  // of standard output; 80 where it reports none

// The colours that the environment (NO_COLOR, COLORTERM, TERM) allows.
ColourDepth colour_depth();

}  // namespace slipctl
