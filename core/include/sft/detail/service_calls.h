// The rules of services (service.h) without their types: what a client does until its call is over, and
// which calls a server carries out. They take the time as an argument, wait for nothing and send nothing.
// One thread at a time uses an object.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/status.h"

namespace sft::detail {

using ServiceTime = std::chrono::steady_clock::time_point;

std::string call_topic(std::string_view service);
std::string reply_topic(std::string_view service);

/// A random number that is not 0.
std::uint64_t new_client_id();

/// True while a callback for samples runs on this thread. It may be the thread that receives.
bool in_sample_callback();

/// The right of one thread to use an object, to the end of the scope; false if another thread has it.
class OnlyCall {
 public:
  explicit OnlyCall(std::atomic<bool>& is_used) : is_used_(is_used), is_only_(!is_used.exchange(true)) {}
  ~OnlyCall() {
    if (is_only_) is_used_ = false;
  }
  OnlyCall(const OnlyCall&) = delete;
  OnlyCall& operator=(const OnlyCall&) = delete;
  explicit operator bool() const { return is_only_; }

 private:
  std::atomic<bool>& is_used_;
  const bool is_only_;
};

/// A server, as a client sees it.
struct SeenServer {
  std::uint64_t id = 0;    ///< of its publisher of replies
  std::string node;        ///< the name of its node
  bool matched = false;    ///< types and policies fit, and it is alive
  bool connected = false;  ///< calls and replies can go
  std::string reason;      ///< for not being matched or connected
};

/// The servers that the two ends of a client know.
std::vector<SeenServer> seen_servers(const PublisherStatus& calls, const SubscriberStatus& replies);

/// The one server that can be called; null if there is none, or more than one.
const SeenServer* only_server(const std::vector<SeenServer>& seen);

/// One call of a client. A call is sent to one server only, and repeated until that server answers. If it was
/// sent, and its server is gone, it is over: another server might carry it out a second time.
class ClientCall {
 public:
  /// What to do next.
  struct Step {
    enum class Kind : std::uint8_t { send, wait, fail };
    Kind kind{};
    std::uint64_t server = 0;  ///< to send: the id of the server
    ServiceTime until{};       ///< to wait: for a reply, but no longer
    std::string reason{};      ///< why the call is to fail
  };

  ClientCall(std::string_view service, ServiceTime now, std::chrono::nanoseconds timeout);

  Step next(ServiceTime now, const std::vector<SeenServer>& seen);
  /// So long the client will repeat the call.
  std::uint32_t timeout_ms() const;

 private:
  Step failed(const std::string& text) const { return {.kind = Step::Kind::fail, .reason = prefix_ + text}; }
  std::string why_late(const std::vector<SeenServer>& seen) const;

  const std::string prefix_;
  const std::chrono::nanoseconds timeout_;
  const ServiceTime deadline_;
  SeenServer server_{};  ///< that the call was sent to; its id is 0 before
  ServiceTime next_{};   ///< when it is sent again
  std::chrono::nanoseconds pause_;
};

/// The latest call of each client of a server, with the answer as long as the client may ask for it again. A
/// client makes one call at a time, and counts its calls.
template <class Answer>
class ServedCalls {
 public:
  enum class Todo : std::uint8_t {
    nothing,  ///< the call is over, or was answered a moment ago
    run,      ///< it is new
    repeat    ///< it was answered, and the answer was lost
  };
  /// When there are more clients, the one that was heard longest ago is forgotten.
  static constexpr std::size_t clients_max = 1024;
  /// Repetitions that have waited while the handler ran come at once behind the answer, and need no other.
  static constexpr std::chrono::milliseconds repeat_least{50};

  Todo heard(std::uint64_t client, std::uint64_t number, ServiceTime now) {
    drop_expired(now);
    if (client == 0) return Todo::run;  // of `sft pub`, which gives its calls no numbers
    // Not try_emplace(): Clang 17 refuses that of libstdc++ 14 as C++23.
    const auto [at, is_new] = clients_.emplace(client, Client{});
    Client& known = at->second;
    known.heard = now;
    if (is_new || number > known.number) {
      known = {.number = number, .heard = now};
      if (clients_.size() > clients_max) forget_one();
      return Todo::run;
    }
    if (number < known.number || !known.answer || now - known.answered < repeat_least) return Todo::nothing;
    known.answered = now;
    return Todo::repeat;
  }

  /// Keeps the answer to the latest call of a client until `expiry`.
  void answered(std::uint64_t client, std::unique_ptr<Answer> answer, ServiceTime now, ServiceTime expiry) {
    const auto at = clients_.find(client);
    if (at == clients_.end()) return;
    at->second.answer = std::move(answer);
    at->second.answered = now;
    at->second.expiry = expiry;
  }

  /// Null if there is none.
  Answer* answer(std::uint64_t client) {
    const auto at = clients_.find(client);
    return at == clients_.end() ? nullptr : at->second.answer.get();
  }

 private:
  struct Client {
    std::uint64_t number = 0;
    ServiceTime heard{};
    ServiceTime answered{};
    ServiceTime expiry{};
    std::unique_ptr<Answer> answer{};  ///< null while the handler runs, and once it has expired
  };

  void drop_expired(ServiceTime now) {
    for (auto& [id, client] : clients_) {
      if (now >= client.expiry) client.answer.reset();
    }
  }
  void forget_one() {
    clients_.erase(std::min_element(clients_.begin(), clients_.end(), [](const auto& a, const auto& b) {
      return a.second.heard < b.second.heard;
    }));
  }

  std::map<std::uint64_t, Client> clients_;
};

}  // namespace sft::detail
