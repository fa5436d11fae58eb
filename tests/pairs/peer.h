// The test's handle of a negotiation_peer, which is a process on a host with a node of its own.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/pairs/host.h"

namespace sft::test {

using nlohmann::json;

/// All functions throw if the peer dies or does not answer. The exception ends the test.
class Peer {
 public:
  /// The options are cyclonedds, port and start_daemon (peer_main.cpp).
  Peer(const Host& host, std::string name, json options = json::object(), const Account& account = {});
  ~Peer();
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  const std::string& name() const { return name_; }

  /// Opens the publisher or the subscriber of the peer. The options are those of peer_roles.cpp.
  void advertise(json options = json::object());
  void subscribe(const std::string& fields, json options = json::object());
  /// Destroys the publisher and the subscriber.
  void leave() { ask({{"do", "leave"}}); }

  /// Publishes `count` more samples, and returns when all of them are published.
  void publish(std::uint64_t count, std::chrono::microseconds period = std::chrono::milliseconds(1));
  /// Publishes until stop_publishing().
  void start_publishing(std::chrono::microseconds period = std::chrono::milliseconds(1));
  void stop_publishing() { ask({{"do", "stop"}}); }
  /// Sets the fields that a recorded subscriber reads from the last sample and from later ones.
  void read(const std::string& fields) { ask({{"do", "read"}, {"fields", fields}}); }
  void set_max_rate_hz(double hz) { ask({{"do", "rate"}, {"hz", hz}}); }
  /// Makes the node learn of all endpoints from now on, including those of other topics.
  void look_around() { ask({{"do", "look around"}}); }
  /// Opens `count` more nodes in the peer's process. Each has a publisher and a subscriber of a topic of its
  /// own. Neighbours with the same number in different processes have the same topic.
  void open_neighbours(std::size_t count) { ask({{"do", "neighbours"}, {"count", count}}); }
  /// Opens publishers of `count` other topics.
  void many_publishers(std::size_t count) { ask({{"do", "many publishers"}, {"count", count}}); }

  /// Makes the peer record all messages that nodes write on the control topics. repeat_control() writes them
  /// again (echo.h).
  void hear_control() { ask({{"do", "hear"}}); }
  void repeat_control() { ask({{"do", "repeat"}}); }

  /// Forges messages of other participants on the control topics (forger.h). `what` must be "watch" in the
  /// first call. After the peer has received records of other participants, `what` may be "withdraw", "mute"
  /// with requests that are `ahead`, "impersonate processes", "outdate announcements", "heartbeats", "ask for
  /// nothing", or "announce version", where `ahead` is the version of the control topics.
  void forge(const std::string& what, std::uint64_t ahead = 1) {
    ask({{"do", "forge"}, {"what", what}, {"ahead", ahead}});
  }

  json status() { return ask({{"do", "status"}}); }
  /// Returns the part of the status about nodes of that name. "reader" and "writer" are the entries of such
  /// nodes, preferably of a node that is served. "taken" is the account of the samples that were taken from
  /// that writer.
  json look_at(const std::string& node) { return ask({{"do", "look"}, {"node", node}}); }
  pid_t pid() const { return process_->pid(); }

  /// Sends SIGSTOP or SIGCONT to the peer.
  void signal(int number) { process_->signal(number); }
  void kill_now() { process_->kill_now(); }
  /// Makes the peer return from main(). Returns its exit code.
  int quit();

 private:
  json ask(const json& command);

  std::string name_;
  int socket_ = -1;
  std::unique_ptr<Process> process_;
};

}  // namespace sft::test
