// One connection to a broker, by libmosquitto without its thread. It lives from the attempt to connect to the
// first error and is then thrown away, so that nothing of it reaches the next one. One thread's own: that of
// the loop.
//
// A host's name is looked up by the C library, which waits: give addresses, or names that a resolver of this
// machine answers.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/mqtt/settings.hpp"
#include "bridges/support/loop.hpp"

struct mosquitto;
struct mosquitto_message;
struct mqtt5__property;

namespace slipd::mqtt {

// Holds the library while a program uses it.
class MosquittoLibrary {
 public:
  MosquittoLibrary();
  ~MosquittoLibrary();
  MosquittoLibrary(const MosquittoLibrary&) = delete;
  MosquittoLibrary& operator=(const MosquittoLibrary&) = delete;
};

enum class MqttVersion { v3_1_1, v5 };

struct BrokerLimits {
  // A broker that has not accepted the connection by then is left.
  std::chrono::milliseconds accept{10'000};
  // How often time-outs are looked at; libmosquitto wants it about once a second.
  std::chrono::milliseconds period{1000};
};

struct LastWill {
  std::string topic, payload;
};

struct BrokerListener {
  // The broker has accepted the connection.
  std::function<void()> accepted;
  // The broker has the message of this number (QoS 1). May be empty.
  std::function<void(int message)> acknowledged;
  // All that was given to publish() is on its way. May be empty.
  std::function<void()> writable;
  // A message of a topic of subscribe(). `retained`: the broker kept it, for how long is unknown. May be
  // empty.
  std::function<void(std::string_view topic, std::string_view payload, bool retained)> message;
  // The broker has answered a request that it got behind subscribe(): as it answers in order, the retained
  // messages came before this. May be empty.
  std::function<void()> subscribed;
  // The connection has failed or ended, or was never made. Called once, from the loop; the Broker may be
  // destroyed in it.
  std::function<void(const std::string& why)> lost;
};

class Broker {
 public:
  // Begins to connect. Never throws for a network's error: lost() tells.
  Broker(bridges::Loop& loop, const BrokerSettings& settings, const std::string& client_id,
         MqttVersion version, const std::optional<LastWill>& will, BrokerListener listener,
         BrokerLimits limits = {});
  ~Broker();
  Broker(const Broker&) = delete;
  Broker& operator=(const Broker&) = delete;

  bool accepted() const noexcept { return accepted_; }
  // Whether the broker refused the connection because it does not speak this version.
  bool refuses_version() const noexcept { return refuses_version_; }
  // Since it was accepted; 0: it was not.
  std::chrono::milliseconds held() const;
  // Whether the broker takes what is sent. Publish only then: libmosquitto keeps the rest in memory without a
  // limit.
  bool writable() const;

  // Gives a message to the connection. `keeps`: the broker throws it away after this long (MQTT 5); 0: it
  // does not. Returns its number, 0 if it failed (lost() follows).
  int publish(const std::string& topic, const std::string& payload, int qos, bool retain,
              std::chrono::seconds keeps = {});

  // Asks for the messages of these topic filters, QoS 0. The broker refuses one: lost() follows.
  void subscribe(const std::vector<std::string>& filters);

  // Says goodbye, so that no last will is published, and waits at most `patience` until all is written.
  void leave(std::chrono::milliseconds patience);

 private:
  struct Free {
    void operator()(mosquitto* client) const noexcept;
  };
  static void on_connect(mosquitto* client, void* self, int code);
  static void on_publish(mosquitto* client, void* self, int message, int reason,
                         const mqtt5__property* properties);
  static void on_disconnect(mosquitto* client, void* self, int code);
  static void on_message(mosquitto* client, void* self, const mosquitto_message* message);
  static void on_subscribe(mosquitto* client, void* self, int request, int count, const int* granted);
  static void on_unsubscribe(mosquitto* client, void* self, int request);
  static void on_log(mosquitto* client, void* self, int level, const char* text);

  void set_up(const BrokerSettings& settings, const std::optional<LastWill>& will);
  void connect(const BrokerSettings& settings);
  void serve(std::uint32_t events);
  void look_at_time();
  void watch_socket();
  bool fine(int code);
  void lose(const std::string& why);
  std::string text_of(int code) const;

  bridges::Loop& loop_;
  BrokerListener listener_;
  BrokerLimits limits_;
  std::string name_;    // host:port, for messages
  std::string errors_;  // what libmosquitto has logged as errors, for messages
  std::unique_ptr<mosquitto, Free> client_;
  std::chrono::steady_clock::time_point begun_, accepted_at_;
  MqttVersion version_;
  bool accepted_ = false, refuses_version_ = false;
  int watched_ = -1;
  std::string failure_;  // told when the library has returned
  bool told_ = false;
  bridges::Loop::Timer time_;
  bridges::Loop::Timer failing_;
  bridges::Loop::Watch watch_;
};

}  // namespace slipd::mqtt
