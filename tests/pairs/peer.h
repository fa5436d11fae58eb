// A negotiation_peer, as its test sees it: another process, on some host, with a node of its own.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/pairs/host.h"

namespace sft::test {

using nlohmann::json;

/// A peer that dies or does not answer ends the test, by an exception.
class Peer {
 public:
  /// Options: cyclonedds, port, start_daemon (peer_main.cpp).
  Peer(const Host& host, std::string name, json options = json::object(), const Account& account = {});
  ~Peer();
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  const std::string& name() const { return name_; }

  /// Opens its publisher or its subscriber. Options: those of peer_roles.cpp.
  void advertise(json options = json::object());
  void subscribe(const std::string& fields, json options = json::object());
  /// Destroys both.
  void leave() { ask({{"do", "leave"}}); }

  /// Returns when so many more are published.
  void publish(std::uint64_t count, std::chrono::microseconds period = std::chrono::milliseconds(1));
  /// Publishes until it is stopped.
  void start_publishing(std::chrono::microseconds period = std::chrono::milliseconds(1));
  void stop_publishing() { ask({{"do", "stop"}}); }
  /// Sets the fields that a recorded subscriber reads of the last sample, and of those to come.
  void read(const std::string& fields) { ask({{"do", "read"}, {"fields", fields}}); }
  void set_max_rate_hz(double hz) { ask({{"do", "rate"}, {"hz", hz}}); }
  /// The node is told of all endpoints from now on, whatever their topics are.
  void look_around() { ask({{"do", "look around"}}); }
  /// Opens so many more nodes in its process. Each has a publisher and a subscriber of a topic of its own,
  /// which it shares with the neighbour of the same number in other processes.
  void open_neighbours(std::size_t count) { ask({{"do", "neighbours"}, {"count", count}}); }
  /// Publishers of so many other topics.
  void crowd(std::size_t count) { ask({{"do", "crowd"}, {"count", count}}); }

  /// From now on the peer remembers what all say on the control topics; repeat_control() says that once more
  /// (echo.h).
  void hear_control() { ask({{"do", "hear"}}); }
  void repeat_control() { ask({{"do", "repeat"}}); }

  /// Speaks for others on the control topics (forger.h): "watch", and when it has heard of them "withdraw",
  /// or "mute" with requests that are so far `ahead`, "claim processes", "outdate announcements",
  /// "heartbeats" or "ask for nothing"; "claim version" of the control topics, `ahead`.
  void forge(const std::string& what, std::uint64_t ahead = 1) {
    ask({{"do", "forge"}, {"what", what}, {"ahead", ahead}});
  }

  json status() { return ask({{"do", "status"}}); }
  /// Returns the status as far as it concerns nodes of that name: "reader" and "writer" are entries of such
  /// nodes, rather than of one that is served; "taken" is what was taken of that writer.
  json look_at(const std::string& node) { return ask({{"do", "look"}, {"node", node}}); }
  pid_t pid() const { return process_->pid(); }

  /// SIGSTOP, SIGCONT
  void signal(int number) { process_->signal(number); }
  void kill_now() { process_->kill_now(); }
  /// Returns from main(); its exit code.
  int quit();

 private:
  json ask(const json& command);

  std::string name_;
  int socket_ = -1;
  std::unique_ptr<Process> process_;
};

}  // namespace sft::test
