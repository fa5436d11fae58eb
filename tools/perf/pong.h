// The side of a run that answers or counts samples. It serves all runs of its domain, several at a time. It
// needs no message types, because each run sends the definition of its type.
#pragma once

#include <sft/sft.h>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sft::perf {

class Pong {
 public:
  static Result<Pong> open(Node node);
  ~Pong();
  Pong(Pong&&) noexcept;
  Pong& operator=(Pong&&) = delete;

  /// Returns a descriptor that is readable when step() has something to do. step() must also be called
  /// after the time that pause() returns.
  int descriptor() const;
  std::chrono::nanoseconds pause() const;
  /// Handles everything that has arrived. Returns sentences for the user: that a run began, or that it
  /// ended, with its results.
  std::vector<std::string> step();
  /// Returns a line about the last second; empty if no run is under way.
  std::string line();

 private:
  class Session;

  Pong(Node node, DynamicSubscriber offers);
  std::string handle(const std::string& text);

  Node node_;
  DynamicSubscriber offers_;
  std::vector<std::unique_ptr<Session>> sessions_;
};

}  // namespace sft::perf
