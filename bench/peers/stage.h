// Hosts, shared memory and daemons for all entrants.
#pragma once

#include <memory>

#include "bench/common/hosts.h"
#include "bench/common/roudi.h"
#include "bench/peers/entrant.h"
#include "tests/support/isolated_host.h"

namespace sft::bench::peers {

class Stage {
 public:
  /// Makes the hosts, and starts the daemons of shared memory. Ends the program with a message if that fails.
  /// REQUIRES: the program is isolated.
  Stage();

  /// Moves the calling process, which is the writer's or a reader's, to its host and its shared memory.
  void enter_as_writer(Way way) const;
  void enter_as_reader(const Case& of, Way way, std::size_t reader) const;

 private:
  void enter(std::size_t host, Way way) const;

  const test::ShmOfSize memory_;
  const hosts::EmulatedNetwork network_;
  const Roudi roudi_;
};

}  // namespace sft::bench::peers
