#include "daemon/rpc/protocol/rpc.hpp"

#include <algorithm>

#include "daemon/rpc/protocol/plain_request.hpp"

namespace slipd::rpc {
namespace {

using nlohmann::json;

// Counts brackets outside strings. A text that is not JSON may be reported as nested too deep.
bool nested_too_deep(std::string_view text) noexcept {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepestNesting) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

template <typename Json>
std::string dump(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Request refused(const std::string& id, int code, const std::string& message) {
  Request request;
  request.error_response = error_text(id, code, message);
  return request;
}

Request request_from(const json& item) {
  if (!item.is_object()) return refused(kNoId, kInvalidRequest, "a request is an object");
  const auto id = item.find("id");
  const bool id_legal = id == item.end() || id->is_string() || id->is_number() || id->is_null();
  if (!id_legal) return refused(kNoId, kInvalidRequest, "id must be a string, a number or null");
  const std::string known_id = id == item.end() ? kNoId : dump(*id);
  const auto version = item.find("jsonrpc");
  if (version == item.end() || *version != "2.0") {
    return refused(known_id, kInvalidRequest, "\"jsonrpc\" must be \"2.0\"");
  }
  const auto method = item.find("method");
  if (method == item.end() || !method->is_string()) {
    return refused(known_id, kInvalidRequest, "\"method\" must be a string");
  }
  Request request;
  request.method = method->get<std::string>();
  request.id = known_id;
  request.notification = id == item.end();
  request.params = json::object();
  if (const auto params = item.find("params"); params != item.end()) {
    const bool empty_list = params->is_array() && params->empty();
    if (!params->is_structured()) return refused(known_id, kInvalidRequest, "\"params\" must be an object");
    if (params->is_object()) {
      request.params = *params;
    } else if (!empty_list) {
      request.error_response = request.notification
                                   ? ""
                                   : error_text(known_id, kInvalidParams, "params go by name: use an object");
    }
  }
  return request;
}

}  // namespace

Line parse(std::string_view text) {
  Line line;
  if (auto request = plain_request(text)) {
    line.requests.push_back(std::move(*request));
    return line;
  }
  if (nested_too_deep(text)) {
    line.error_response =
        error_text(kNoId, kParseError, "nested deeper than " + std::to_string(kDeepestNesting) + " levels");
    return line;
  }
  json document;
  try {
    document = json::parse(text);
  } catch (const json::exception& error) {
    line.error_response = error_text(kNoId, kParseError, std::string("not JSON: ") + error.what());
    return line;
  }
  if (!document.is_array()) {
    line.requests.push_back(request_from(document));
  } else if (document.empty()) {
    line.error_response = error_text(kNoId, kInvalidRequest, "an empty batch");
  } else if (document.size() > kLargestBatch) {
    line.error_response = error_text(kNoId, kInvalidRequest,
                                     "a batch has at most " + std::to_string(kLargestBatch) + " requests");
  } else {
    line.batch = true;
    for (const json& item : document) line.requests.push_back(request_from(item));
  }
  return line;
}

std::string result_text(const std::string& id, std::string_view result) {
  constexpr std::size_t kFrame = 40;  // the text around them, and the end of the line
  std::string text;
  text.reserve(kFrame + id.size() + result.size());
  text += R"({"jsonrpc":"2.0","id":)";
  text += id;
  text += R"(,"result":)";
  text += result;
  text += '}';
  return text;
}

std::string error_text(const std::string& id, int code, const std::string& message) {
  return R"({"jsonrpc":"2.0","id":)" + id + R"(,"error":)" +
         dump(json{{"code", code}, {"message", message}}) + "}";
}

Responses::Responses(bool batch, std::size_t expected, std::function<void(std::string)> done, OwedPart owed)
    : batch_(batch), missing_(expected), done_(std::move(done)), owed_(std::move(owed)) {}

void Responses::add(std::string text) {
  owed_.grow(text.size());
  if (collected_.empty()) {
    collected_ = std::move(text);
  } else if (!text.empty()) {
    collected_ += ',';
    collected_ += text;
  }
  if (--missing_ > 0) return;
  if (batch_ && !collected_.empty()) {
    collected_.insert(collected_.begin(), '[');
    collected_ += ']';
  }
  owed_ = {};  // from here on `done` counts it
  done_(std::move(collected_));
}

Reply::Reply(const Request& request, std::shared_ptr<Responses> answers)
    : id_(request.id), notification_(request.notification), answers_(std::move(answers)) {}

void Reply::result(const nlohmann::ordered_json& value) const {
  answers_->add(notification_ ? "" : result_text(id_, dump(value)));
}

void Reply::text(std::string_view json) const {
  answers_->add(notification_ ? "" : result_text(id_, json));
}

void Reply::error(int code, const std::string& message) const {
  answers_->add(notification_ ? "" : error_text(id_, code, message));
}

}  // namespace slipd::rpc
