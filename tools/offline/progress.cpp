#include "tools/offline/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <utility>

namespace offline {
namespace {

constexpr int kBarCells = 40;

}  // namespace

ProgressBar::ProgressBar(std::string title)
    : title_(std::move(title)), terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (terminal_ && shown_ >= 0) std::cerr << "\r\x1b[K" << std::flush;
}

void ProgressBar::show(double share, const char* what) {
  const int percent = std::clamp(static_cast<int>(100 * share), 0, 100);
  const int step = terminal_ ? percent : percent / 10;
  if (step <= shown_) return;
  shown_ = step;
  if (!terminal_) {
    std::cerr << title_ << ": " << percent << " % (" << what << ")\n";
    return;
  }
  const int full = percent * kBarCells / 100;
  std::cerr << "\r\x1b[K" << title_ << " [" << std::string(static_cast<std::size_t>(full), '=')
            << std::string(static_cast<std::size_t>(kBarCells - full), ' ') << "] " << percent << " % "
            << what << std::flush;
}

}  // namespace offline
