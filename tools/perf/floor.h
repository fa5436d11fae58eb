// Carries the same number of bytes as SFT by plain UDP and TCP sockets over IPv4, for comparison. No
// library that uses these protocols can be faster. Threads of both sides block in recv().
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "sft/result.h"

namespace sft::perf {

enum class Socket : std::uint8_t { udp, tcp };

/// Receives whole messages on one socket, and either sends each of them back or only counts them. It
/// handles only messages that begin with `token`, so that other hosts cannot use it as a reflector.
class FloorServer {
 public:
  static Result<std::unique_ptr<FloorServer>> open(Socket kind, std::uint64_t token, bool answers);
  ~FloorServer();
  FloorServer(const FloorServer&) = delete;
  FloorServer& operator=(const FloorServer&) = delete;

  std::uint16_t port() const { return port_; }
  std::uint64_t received() const { return received_; }

 private:
  FloorServer(Socket kind, int listening, std::uint64_t token, bool answers);
  void serve_tcp();

  const Socket kind_;
  const int socket_;
  const std::uint64_t token_;
  const bool answers_;
  std::uint16_t port_ = 0;
  std::atomic<std::uint64_t> received_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

class FloorClient {
 public:
  /// Called on a thread of the client with the number of each message that came back.
  using Answer = std::function<void(std::uint64_t number)>;
  /// Opens a client that sends messages of `bytes` bytes, or the size of a header if that is larger.
  static Result<std::unique_ptr<FloorClient>> open(Socket kind, const std::string& host, std::uint16_t port,
                                                   std::uint64_t token, std::size_t bytes, Answer answer);
  ~FloorClient();
  FloorClient(const FloorClient&) = delete;
  FloorClient& operator=(const FloorClient&) = delete;

  bool send(std::uint64_t number);

 private:
  FloorClient(Socket kind, int connected, std::uint64_t token, std::size_t bytes, Answer answer);

  const Socket kind_;
  const int socket_;
  const std::uint64_t token_;
  std::vector<char> message_;
  const Answer answer_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace sft::perf
