#include "bridges/mqtt/broker.hpp"

#include <mosquitto.h>
#include <mqtt_protocol.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace slipd::mqtt {
namespace {

using Clock = std::chrono::steady_clock;

// Reasons of MQTT 5 from here on are refusals.
constexpr int kRefusals = 0x80;

// A code of libmosquitto, or a reason of MQTT 5.
std::string library_text_of(int code) {
  if (code >= kRefusals) return mosquitto_reason_string(code);
  return code == MOSQ_ERR_ERRNO ? std::generic_category().message(errno) : mosquitto_strerror(code);
}

// After a cut of the network the kernel sends what it has: nothing that is older than this, and no more than
// was under way when the cut began.
void bound_what_waits(int fd) {
  constexpr unsigned int kLongestMs = 2000;
  constexpr int kUnsentBytes = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &kLongestMs, sizeof(kLongestMs));
  setsockopt(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentBytes, sizeof(kUnsentBytes));
}

void succeeded(int code, const std::string& what) {
  if (code != MOSQ_ERR_SUCCESS) throw std::runtime_error(what + ": " + library_text_of(code));
}

std::string first_line_of(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  if (!in || !std::getline(in, line)) throw std::runtime_error("the password cannot be read from " + file);
  return line;
}

const char* or_null(const std::string& text) {
  return text.empty() ? nullptr : text.c_str();
}

std::chrono::milliseconds since(Clock::time_point begin) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin);
}

}  // namespace

MosquittoLibrary::MosquittoLibrary() {
  mosquitto_lib_init();
}
MosquittoLibrary::~MosquittoLibrary() {
  mosquitto_lib_cleanup();
}

void Broker::Free::operator()(mosquitto* client) const noexcept {
  mosquitto_destroy(client);
}

Broker::Broker(bridges::Loop& loop, const BrokerSettings& settings, const std::string& client_id,
               MqttVersion version, const std::optional<LastWill>& will, BrokerListener listener,
               BrokerLimits limits)
    : loop_(loop),
      listener_(std::move(listener)),
      limits_(limits),
      name_(settings.name()),
      client_(mosquitto_new(client_id.c_str(), true, this)),
      begun_(Clock::now()),
      version_(version),
      time_(loop, [this] { look_at_time(); }),
      failing_(loop, [this] { listener_.lost(failure_); }) {
  if (!client_) throw std::bad_alloc();
  try {
    set_up(settings, will);
    connect(settings);
  } catch (const std::runtime_error& error) {
    lose(error.what());
  }
}

Broker::~Broker() = default;

void Broker::set_up(const BrokerSettings& settings, const std::optional<LastWill>& will) {
  mosquitto_connect_callback_set(client_.get(), &Broker::on_connect);
  mosquitto_publish_v5_callback_set(client_.get(), &Broker::on_publish);
  mosquitto_disconnect_callback_set(client_.get(), &Broker::on_disconnect);
  mosquitto_message_callback_set(client_.get(), &Broker::on_message);
  mosquitto_subscribe_callback_set(client_.get(), &Broker::on_subscribe);
  mosquitto_unsubscribe_callback_set(client_.get(), &Broker::on_unsubscribe);
  mosquitto_log_callback_set(client_.get(), &Broker::on_log);
  succeeded(mosquitto_int_option(client_.get(), MOSQ_OPT_TCP_NODELAY, 1), "TCP_NODELAY");
  const int version = version_ == MqttVersion::v5 ? MQTT_PROTOCOL_V5 : MQTT_PROTOCOL_V311;
  succeeded(mosquitto_int_option(client_.get(), MOSQ_OPT_PROTOCOL_VERSION, version), "the version of MQTT");
  if (will) {
    succeeded(mosquitto_will_set(client_.get(), will->topic.c_str(), static_cast<int>(will->payload.size()),
                                 will->payload.data(), 1, true),
              "the last will");
  }
  if (!settings.user.empty()) {
    const std::string password = settings.password_file.empty() ? "" : first_line_of(settings.password_file);
    succeeded(mosquitto_username_pw_set(client_.get(), settings.user.c_str(), or_null(password)),
              "the password");
  }
  if (!settings.tls) return;
  const TlsSettings& tls = *settings.tls;
  succeeded(mosquitto_tls_set(client_.get(), or_null(tls.ca_file), nullptr, or_null(tls.cert_file),
                              or_null(tls.key_file), nullptr),
            "the certificates " + tls.ca_file + " " + tls.cert_file);
  constexpr int kVerify = 1;  // SSL_VERIFY_PEER
  succeeded(mosquitto_tls_opts_set(client_.get(), kVerify, nullptr, nullptr), "TLS");
}

void Broker::connect(const BrokerSettings& settings) {
  const int code = mosquitto_connect_async(client_.get(), settings.host.c_str(), settings.port,
                                           static_cast<int>(settings.keepalive.count()));
  if (!fine(code)) return;
  time_.start(limits_.period);
  watch_socket();
}

// Watches libmosquitto's socket, for writing while it has something to write.
void Broker::watch_socket() {
  const int fd = mosquitto_socket(client_.get());
  const std::uint32_t events = EPOLLIN | (mosquitto_want_write(client_.get()) ? std::uint32_t{EPOLLOUT} : 0U);
  if (fd < 0) {
    watch_ = {};
  } else if (fd == watched_) {
    watch_.want(events);
  } else {
    watch_ = bridges::Loop::Watch(loop_, fd, events, [this](std::uint32_t came) { serve(came); });
  }
  watched_ = fd;
}

void Broker::serve(std::uint32_t events) {
  constexpr int kPacketsAtOnce = 16;
  int code = MOSQ_ERR_SUCCESS;
  if ((events & ~std::uint32_t{EPOLLOUT}) != 0) code = mosquitto_loop_read(client_.get(), kPacketsAtOnce);
  if (code == MOSQ_ERR_SUCCESS && (events & EPOLLOUT) != 0) code = mosquitto_loop_write(client_.get(), 1);
  if (!fine(code)) return;
  watch_socket();
  if (writable() && listener_.writable) listener_.writable();
}

void Broker::look_at_time() {
  if (!accepted_ && since(begun_) > limits_.accept) {
    lose("does not accept the connection in " + std::to_string(limits_.accept.count()) + " ms");
    return;
  }
  const int code = mosquitto_loop_misc(client_.get());
  if (!fine(code)) return;
  time_.start(limits_.period);
  watch_socket();
}

std::chrono::milliseconds Broker::held() const {
  return accepted_ ? since(accepted_at_) : std::chrono::milliseconds(0);
}

bool Broker::writable() const {
  return accepted_ && failure_.empty() && !mosquitto_want_write(client_.get());
}

int Broker::publish(const std::string& topic, const std::string& payload, int qos, bool retain,
                    std::chrono::seconds keeps) {
  mosquitto_property* properties = nullptr;
  if (version_ == MqttVersion::v5 && keeps.count() > 0 &&
      !fine(mosquitto_property_add_int32(&properties, MQTT_PROP_MESSAGE_EXPIRY_INTERVAL,
                                         static_cast<std::uint32_t>(keeps.count()))))
    return 0;
  int message = 0;
  const int code =
      mosquitto_publish_v5(client_.get(), &message, topic.c_str(), static_cast<int>(payload.size()),
                           payload.data(), qos, retain, properties);
  mosquitto_property_free_all(&properties);
  if (!fine(code)) return 0;
  watch_socket();
  return message;
}

void Broker::subscribe(const std::vector<std::string>& filters) {
  std::vector<char*> texts;
  texts.reserve(filters.size());
  for (const std::string& filter : filters) texts.push_back(const_cast<char*>(filter.c_str()));
  if (!fine(mosquitto_subscribe_multiple(client_.get(), nullptr, static_cast<int>(texts.size()), texts.data(),
                                         0, 0, nullptr)))
    return;
  // A request that changes nothing, whose answer comes behind the retained messages.
  if (fine(mosquitto_unsubscribe(client_.get(), nullptr, (filters.front() + "/end").c_str()))) watch_socket();
}

void Broker::leave(std::chrono::milliseconds patience) {
  const auto until = Clock::now() + patience;
  while (mosquitto_want_write(client_.get())) {
    pollfd ready{mosquitto_socket(client_.get()), POLLOUT, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    if (ready.fd < 0 || left <= 0 || poll(&ready, 1, static_cast<int>(left)) <= 0) break;
    if (mosquitto_loop_write(client_.get(), 1) != MOSQ_ERR_SUCCESS) break;
  }
  told_ = true;  // no lost() from here on
  watch_ = {};
  mosquitto_disconnect(client_.get());
}

std::string Broker::text_of(int code) const {
  if (code != MOSQ_ERR_TLS || errors_.empty()) return library_text_of(code);
  return "TLS: " + errors_ +
         "; the certificate of the broker must be signed by an authority of ca_file, and name the host";
}

// Notes a failure of the library. False: there was one, now or before.
bool Broker::fine(int code) {
  if (code != MOSQ_ERR_SUCCESS) lose(text_of(code));
  return failure_.empty();
}

// Calls listener_.lost later, from the loop: it may destroy this object.
void Broker::lose(const std::string& why) {
  if (told_) return;
  told_ = true;
  failure_ = name_ + ": " + why;
  watch_ = {};
  watched_ = -1;
  time_.stop();
  failing_.start({});
}

void Broker::on_connect(mosquitto*, void* self, int code) {
  Broker& broker = *static_cast<Broker*>(self);
  if (code != 0) {
    constexpr int kVersionRefused = 1;  // MQTT 3.1.1, section 3.2.2.3
    broker.refuses_version_ = broker.version_ == MqttVersion::v5 &&
                              (code == MQTT_RC_UNSUPPORTED_PROTOCOL_VERSION || code == kVersionRefused);
    broker.lose(code < kRefusals ? mosquitto_connack_string(code)
                                 : "Connection refused: " + library_text_of(code));
    return;
  }
  bound_what_waits(mosquitto_socket(broker.client_.get()));
  broker.accepted_ = true;
  broker.accepted_at_ = Clock::now();
  broker.listener_.accepted();
}

void Broker::on_publish(mosquitto*, void* self, int message, int reason, const mqtt5__property*) {
  Broker& broker = *static_cast<Broker*>(self);
  if (reason >= kRefusals) return broker.lose("refuses a message: " + library_text_of(reason));
  if (broker.listener_.acknowledged) broker.listener_.acknowledged(message);
}

void Broker::on_message(mosquitto*, void* self, const mosquitto_message* message) {
  const Broker& broker = *static_cast<Broker*>(self);
  const auto* const bytes = static_cast<const char*>(message->payload);
  const std::size_t size = message->payloadlen > 0 ? static_cast<std::size_t>(message->payloadlen) : 0;
  if (broker.listener_.message)
    broker.listener_.message(message->topic, std::string_view(bytes, size), message->retain);
}

void Broker::on_subscribe(mosquitto*, void* self, int, int count, const int* granted) {
  constexpr int kRefused = 0x80;  // MQTT 3.1.1, section 3.9.3
  if (std::find(granted, granted + count, kRefused) != granted + count)
    static_cast<Broker*>(self)->lose("refuses a subscription");
}

void Broker::on_unsubscribe(mosquitto*, void* self, int) {
  const Broker& broker = *static_cast<Broker*>(self);
  if (broker.listener_.subscribed && broker.failure_.empty()) broker.listener_.subscribed();
}

void Broker::on_disconnect(mosquitto*, void* self, int code) {
  Broker& broker = *static_cast<Broker*>(self);
  broker.lose(code == 0 ? "it has ended" : broker.text_of(code));
}

// "OpenSSL Error[0]: error:0A000086:SSL routines::certificate verify failed": what is behind the last colon.
void Broker::on_log(mosquitto*, void* self, int level, const char* text) {
  constexpr std::size_t kLongest = 200;
  std::string& errors = static_cast<Broker*>(self)->errors_;
  if (level != MOSQ_LOG_ERR || errors.size() > kLongest) return;
  const std::string_view line = text;
  const std::size_t end = line.find_last_not_of(". ");
  const std::size_t colon = line.rfind(':', end);
  std::string_view reason = line.substr(0, end + 1).substr(colon == std::string_view::npos ? 0 : colon + 1);
  reason.remove_prefix(std::min(reason.find_first_not_of(' '), reason.size()));
  errors += (errors.empty() ? "" : ", ") + std::string(reason);
}

}  // namespace slipd::mqtt
