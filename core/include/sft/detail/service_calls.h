// The rules of services (service.h) without their types: the steps of a client's call, and the choice of
// the calls that a server carries out. The functions take the time as an argument, do not wait, and send
// nothing. An object must be used by only one thread at a time.
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

/// Returns a random number that is not 0.
std::uint64_t new_client_id();

/// Returns true while a callback for samples runs on this thread, which may be the receiving thread.
bool in_sample_callback();

/// Lets one thread at a time use an object, until the end of the scope. Converts to false if another thread
/// is already using the object.
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

/// A server, as far as a client knows about it.
struct SeenServer {
  std::uint64_t id = 0;    ///< the id of the server's publisher of replies
  std::string node;        ///< the name of the server's node
  bool matched = false;    ///< true: types and policies are compatible, and the server is alive
  bool connected = false;  ///< true: calls can be sent, and replies received
  std::string reason;      ///< the reason why the server is not matched or not connected
};

/// Returns the servers that a client's publisher of calls and its subscriber of replies know.
std::vector<SeenServer> seen_servers(const PublisherStatus& calls, const SubscriberStatus& replies);

/// Returns the server if there is exactly one and it can be called, otherwise null.
const SeenServer* only_server(const std::vector<SeenServer>& seen);

/// One call of a client. A call is sent to one server only, and repeated until that server answers. If the
/// server departs after the call was sent, the call fails, because another server might carry out the same
/// call a second time.
class ClientCall {
 public:
  /// The next step that the client has to take.
  struct Step {
    enum class Kind : std::uint8_t { send, wait, fail };
    Kind kind{};
    std::uint64_t server = 0;  ///< for `send`: the id of the server
    ServiceTime until{};       ///< for `wait`: the time at which the wait for a reply ends
    std::string reason{};      ///< for `fail`: the reason why the call fails
  };

  ClientCall(std::string_view service, ServiceTime now, std::chrono::nanoseconds timeout);

  Step next(ServiceTime now, const std::vector<SeenServer>& seen);
  /// Returns the time in ms for which the client repeats the call.
  std::uint32_t timeout_ms() const;

 private:
  Step failed(const std::string& text) const { return {.kind = Step::Kind::fail, .reason = prefix_ + text}; }
  std::string why_late(const std::vector<SeenServer>& seen) const;

  const std::string prefix_;
  const std::chrono::nanoseconds timeout_;
  const ServiceTime deadline_;
  SeenServer server_{};  ///< the server that the call was sent to; the id is 0 until then
  ServiceTime next_{};   ///< the time at which the call is sent again
  std::chrono::nanoseconds pause_;
};

/// The latest call of each client of a server. The answer to a call is kept as long as the client may
/// repeat the call. A client makes only one call at a time, and numbers its calls.
template <class Answer>
class ServedCalls {
 public:
  enum class Todo : std::uint8_t {
    nothing,  ///< nothing has to be done: the handler is running, the call is over, or it was answered just
              ///< before
    run,      ///< the call is new, and the handler has to run
    repeat    ///< the call was answered before, and the answer was probably lost: it has to be sent again
  };
  /// The maximum number of clients that are remembered. If more clients call, the client that has not
  /// called for the longest time is removed.
  static constexpr std::size_t clients_max = 1024;
  /// The minimum time between two answers to one call. Repetitions of the call that arrived while the
  /// handler ran are read right after the answer was sent, and need no second answer.
  static constexpr std::chrono::milliseconds repeat_least{50};

  Todo heard(std::uint64_t client, std::uint64_t number, ServiceTime now) {
    drop_expired(now);
    if (client == 0) return Todo::run;  // a call of `sft pub`, which does not number its calls
    // Not try_emplace(): Clang 17 rejects try_emplace() of libstdc++ 14 in C++23.
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

  /// Returns the kept answer to the client's latest call; null if no answer is kept.
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
    std::unique_ptr<Answer> answer{};  ///< null while the handler runs, and once the answer has expired
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
