// The side of a run that answers samples, or counts them. It serves all runs of its domain, one or several at
// a time, and needs no types: runs bring them along.
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

  /// Readable when step() has something to do. It also has to be called after pause().
  int descriptor() const;
  std::chrono::nanoseconds pause() const;
  /// Handles what came. Returns sentences for the user: a run began, or it ended, with its figures.
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
