// Counts the bytes of answers that slipd owes its clients: promised, collected for a batch, or waiting to be
// sent. A client that owes reading is not read from, so that what one client makes slipd keep is limited
// whatever it requested. Not thread-safe. Called from one thread: io.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

namespace slipd {

// Owed to one client, or to all of them.
class OwedBytes {
 public:
  // `of_all` counts the same bytes for all clients and outlives it; null: it is that of all clients.
  explicit OwedBytes(OwedBytes* of_all = nullptr) : of_all_(of_all) {}
  // What is still owed is taken off `of_all`.
  ~OwedBytes() { settle(bytes_); }
  OwedBytes(const OwedBytes&) = delete;
  OwedBytes& operator=(const OwedBytes&) = delete;

  // So many bytes more are owed.
  void add(std::size_t bytes) noexcept {
    bytes_ += bytes;
    if (of_all_ != nullptr) of_all_->add(bytes);
  }
  // So many bytes were sent, or are not owed any more; at most bytes().
  void settle(std::size_t bytes) noexcept {
    bytes_ -= bytes;
    if (of_all_ != nullptr) of_all_->settle(bytes);
  }
  // Bytes owed now.
  std::size_t bytes() const noexcept { return bytes_; }

 private:
  OwedBytes* of_all_;
  std::size_t bytes_ = 0;
};

// A part of what is owed to a client, as long as it lives: of an answer that is promised, or not complete.
class OwedPart {
 public:
  // Nothing.
  OwedPart() = default;
  // Adds so many bytes to `owed`.
  OwedPart(std::shared_ptr<OwedBytes> owed, std::size_t bytes) : owed_(std::move(owed)) { grow(bytes); }
  OwedPart(OwedPart&& other) noexcept
      : owed_(std::move(other.owed_)), bytes_(std::exchange(other.bytes_, 0)) {}
  OwedPart& operator=(OwedPart&& other) noexcept {
    std::swap(owed_, other.owed_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~OwedPart() {
    if (owed_) owed_->settle(bytes_);
  }
  // So many bytes more. Without effect on a part of nothing.
  void grow(std::size_t bytes) noexcept {
    if (!owed_) return;
    owed_->add(bytes);
    bytes_ += bytes;
  }

 private:
  std::shared_ptr<OwedBytes> owed_;
  std::size_t bytes_ = 0;
};

}  // namespace slipd
