// The laws of a world of negotiations, which must hold after each step and at rest.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/simulation/negotiation/negotiation_state.h"

namespace sft::test {

class NegotiationLaws {
 public:
  /// Both arguments outlive this object. The first law that does not hold is written to `violation`.
  NegotiationLaws(const AskedRequests& asked, std::string& violation)
      : asked_(asked), violation_(violation) {}

  /// Checks, after a step, the readers that the node of a writer wants to serve.
  void check_serving(const WorldNode& node, const WorldWriter& writer);
  void check_arrival(const std::vector<WorldNode>& nodes, const Datagram& datagram);
  /// Checks, at rest, that both sides of each pair agree.
  void check_agreement(const std::vector<WorldNode>& nodes);

 private:
  std::size_t check_route(const WorldNode& node, const WorldWriter& writer, const core::Endpoint& reader,
                          std::uint64_t newest);
  void check_pair(const WorldNode& there, const WorldWriter& writer, const WorldNode& here,
                  const WorldReader& reader);
  void fail(const std::string& what) {
    if (violation_.empty()) violation_ = what;
  }

  const AskedRequests& asked_;
  std::string& violation_;
};

}  // namespace sft::test
