// Shows the progress of long work on stderr: a bar on a terminal, elsewhere a line for each tenth.
#pragma once

#include <string>

#include "paper/dataset/column_source.hpp"

namespace offline {

class ProgressBar {
 public:
  explicit ProgressBar(std::string title);
  ~ProgressBar();  // clears the terminal's line
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(double share, const char* what);
  slipd::Progress callback() {
    return [this](double share, const char* what) { show(share, what); };
  }

 private:
  std::string title_;
  bool terminal_;
  int shown_ = -1;  // percent on a terminal, else tenth
};

}  // namespace offline
