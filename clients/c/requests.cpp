// The functions of slipd.h that ask slipd for something and wait for its answer.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "clients/c/client.hpp"
#include "clients/c/estimate.hpp"
#include "clients/c/json_values.hpp"
#include "clients/c/recording.hpp"

using namespace slipd::client;

namespace {

// As guarded; after a failure on the way the connection is given up, so that a late answer is not taken for
// another one's.
template <typename Body>
int requested(slipd_client* s, Body body) noexcept {
  const int code = guarded(s, body);
  if (s != nullptr && (code == SLIPD_TIMEOUT || code == SLIPD_DISCONNECTED || code == SLIPD_NO_MEMORY))
    s->requests.close();
  return code;
}

char* copy_of(const std::string& text) {
  char* const copy = static_cast<char*>(std::malloc(text.size() + 1));
  if (copy == nullptr) throw std::bad_alloc();
  std::memcpy(copy, text.c_str(), text.size() + 1);
  return copy;
}

// Age of the oldest frame of the sensors in `members`, ms; absent: one of them has none.
std::optional<double> oldest_ms(const Json& sensors, const Json& members) {
  if (members.empty()) return std::nullopt;
  double oldest = 0;
  for (const Json& name : members) {
    bool found = false;
    for (const Json& sensor : sensors) {
      if (member(sensor, "sensor") != name) continue;
      const auto age_ms = number(sensor, "age_ms");
      if (!age_ms) return std::nullopt;
      oldest = std::max(oldest, *age_ms);
      found = true;
    }
    if (!found) return std::nullopt;
  }
  return oldest;
}

}  // namespace

int slipd_connect(slipd_client* s, double timeout_s) {
  return requested(s, [&] {
    call(*s, "version", "{}", after(timeout_s));
    return SLIPD_DONE;
  });
}

int slipd_gamma(slipd_client* s, const char* sensor, double max_age_s, double timeout_s,
                struct slipd_estimate* estimate) {
  if (estimate == nullptr || sensor == nullptr) return SLIPD_INVALID;
  clear(*estimate, sensor, SLIPD_STATE_DISCONNECTED);
  return requested(s, [&] {
    const Json result = call(*s, "gamma", R"({"sensor":)" + quoted(sensor) + "}", after(timeout_s));
    fill(*estimate, estimate_from(result.at("sensors").at(0)), monotonic_ns(), max_age_s);
    return SLIPD_DONE;
  });
}

int slipd_grasp(slipd_client* s, const char* grasp, double max_age_s, double timeout_s,
                struct slipd_estimate* estimate) {
  if (estimate == nullptr || grasp == nullptr) return SLIPD_INVALID;
  clear(*estimate, grasp, SLIPD_STATE_DISCONNECTED);
  return requested(s, [&] {
    const Json result = call(*s, "gamma", "{}", after(timeout_s));
    for (const Json& each : member(result, "grasps")) {
      EstimateValues values = estimate_from(each);
      if (values.name != grasp) continue;
      values.age_ms = oldest_ms(member(result, "sensors"), member(each, "sensors"));
      fill(*estimate, values, monotonic_ns(), max_age_s);
      return static_cast<int>(SLIPD_DONE);
    }
    throw Failure(SLIPD_REFUSED, std::string("there is no grasp ") + grasp);
  });
}

int slipd_call(slipd_client* s, const char* method, const char* params, int descriptor, double timeout_s,
               char** result) {
  if (result == nullptr || method == nullptr) return SLIPD_INVALID;
  *result = nullptr;
  return requested(s, [&] {
    if (descriptor >= 0)
      throw Failure(SLIPD_INVALID, "slipd takes no descriptors: give -1; slipd_record records");
    const Json named = Json::parse(params == nullptr ? "{}" : params, nullptr, false);
    if (!named.is_object()) throw Failure(SLIPD_INVALID, "params are no JSON object");
    const std::string name = quoted(method);
    const std::string_view bare = std::string_view(name).substr(1, name.size() - 2);
    *result = copy_of(call(*s, bare, named.dump(), after(timeout_s)).dump());
    return SLIPD_DONE;
  });
}

int slipd_sensors(slipd_client* s, double timeout_s, char** result) {
  return slipd_call(s, "sensors", nullptr, -1, timeout_s, result);
}

int slipd_status(slipd_client* s, double timeout_s, char** result) {
  return slipd_call(s, "status", nullptr, -1, timeout_s, result);
}

int slipd_frame(slipd_client* s, const char* sensor, double timeout_s, char** result) {
  if (sensor == nullptr || result == nullptr) return SLIPD_INVALID;
  *result = nullptr;
  return requested(s, [&] {
    *result = copy_of(call(*s, "frame", R"({"sensor":)" + quoted(sensor) + "}", after(timeout_s)).dump());
    return SLIPD_DONE;
  });
}

int slipd_record(slipd_client* s, const char* sensor, double seconds, int fd, double timeout_s,
                 char** result) {
  if (result == nullptr || sensor == nullptr) return SLIPD_INVALID;
  *result = nullptr;
  return guarded(s, [&] {
    Connection connection;  // of its own, which ends the recording when it ends
    connection.connect(s->path);
    const auto patience = std::chrono::duration<double>(seconds_of(timeout_s));
    const Json account = record(connection, quoted(sensor), seconds, fd,
                                std::chrono::duration_cast<Clock::duration>(patience));
    *result = copy_of(account.dump());
    const std::string trouble = text(account, "trouble", "");
    return trouble.empty() ? SLIPD_DONE : note(*s, SLIPD_REFUSED, trouble.c_str());
  });
}

void slipd_free(char* text) {
  std::free(text);
}
