#include "daemon/rpc/clients/backlog.hpp"

#include <algorithm>
#include <iterator>

namespace slipd {

void Backlog::push_response(std::string text, UniqueFd descriptor) {
  items_.push_back({std::move(text), nullptr, 0, std::move(descriptor)});
}

void Backlog::push_notification(std::shared_ptr<const Notification> head, std::uint64_t lost) {
  dropped_ += lost;
  items_.push_back({{}, std::move(head), lost, {}});
  if (++notifications_ > max_notifications_) drop_oldest();
}

void Backlog::drop_oldest() {
  const auto is_notification = [](const Item& item) { return item.head != nullptr; };
  const auto oldest = std::find_if(items_.begin(), items_.end(), is_notification);
  const auto next = std::find_if(std::next(oldest), items_.end(), is_notification);
  next->lost += oldest->lost + 1;  // there is a next one: more than max_notifications_ >= 1 are queued
  items_.erase(oldest);
  --notifications_;
  ++dropped_;
}

std::optional<std::string> Backlog::next() {
  if (items_.empty()) return std::nullopt;
  Item item = std::move(items_.front());
  items_.pop_front();
  descriptor_ = std::move(item.descriptor);
  if (item.head == nullptr) {
    published_ns_ = 0;
    item.response += '\n';
    return std::move(item.response);
  }
  --notifications_;
  published_ns_ = item.head->published_ns;
  return item.head->text + ",\"dropped\":" + std::to_string(item.lost) + "}}\n";
}

}  // namespace slipd
