// The connection between the demo and each of its processes: JSON messages over a pair of sockets. It ends
// with either side, so that each side notices the end of the other.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::demo {

using Clock = std::chrono::steady_clock;

class Channel {
 public:
  /// Both ends are closed on exec, but not on fork: see hosts::close_descriptors_except().
  static Result<std::pair<Channel, Channel>> make_pair();

  enum class Event { message, timeout, closed };
  struct Received {
    Event event;
    nlohmann::json message;
  };

  /// Returns false if the other side is gone.
  bool send(const nlohmann::json& message);
  /// Waits for the next message until the deadline, or without limit if there is no deadline.
  Received receive(std::optional<Clock::time_point> deadline);

  int descriptor() const { return socket_.get(); }

 private:
  explicit Channel(core::FileDescriptor socket) : socket_(std::move(socket)) {}

  core::FileDescriptor socket_;
};

}  // namespace sft::demo
