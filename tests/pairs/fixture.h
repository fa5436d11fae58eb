// Hosts on a network, and checks of the final state of a publisher and a subscriber.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <optional>
#include <string>

#include "tests/pairs/host.h"
#include "tests/pairs/network.h"
#include "tests/pairs/peer.h"
#include "tests/support/eventually.h"
#include "tests/support/test_seed.h"

namespace sft::test {

using namespace std::chrono_literals;

/// The lease of nodes whose death has to be noticed soon. Other nodes have the default of 10 s.
inline constexpr std::chrono::milliseconds short_lease = 2s;
json with_short_lease(json options = json::object());

class NegotiationTest : public RandomTest {
 protected:
  void SetUp() override;

  Host& here() { return *here_; }
  Host& there() { return *there_; }
  Network& network() { return *network_; }

 private:
  std::optional<Network> network_;
  std::optional<Host> here_;
  std::optional<Host> there_;
};

/// Waits for the condition. Checks the condition only a hundred times a second, because each check sends a
/// command to a peer.
template <class Condition>
bool comes_true(Condition condition, std::chrono::milliseconds within = hang_timeout) {
  return eventually(condition, within, 10ms);
}

/// Returns the entry of the subscriber in the publisher's status, or null if there is none.
json reader_of(Peer& publisher, const Peer& subscriber);
/// Returns the entry of the publisher in the subscriber's status, or null if there is none.
json writer_of(const Peer& publisher, Peer& subscriber);
/// Returns the subscriber's account of the samples that it has taken from the publisher.
json taken_of(const Peer& publisher, Peer& subscriber);

bool is_served(Peer& publisher, const Peer& subscriber);
bool is_served_by(Peer& publisher, const Peer& subscriber, const std::string& transport);
bool is_served_with(Peer& publisher, const Peer& subscriber, const std::string& mask);

/// Waits until both peers report the same path, mask and request for each other.
testing::AssertionResult agree(Peer& publisher, Peer& subscriber);

/// Makes the publisher publish until its newest sample has arrived. Succeeds if each sample since the first
/// one that arrived counts as received, lost, withheld or expired, and if the received samples are right and
/// in order.
testing::AssertionResult accounts_for_all(Peer& publisher, Peer& subscriber);

/// Returns true if an event of that kind arrived whose text contains `text`.
bool was_notified(const json& events, const std::string& kind, const std::string& text = "");
/// Waits until the peer has got such an event. `side` is "offered" or "requested". An event arrives later
/// than the change that it reports, because a separate thread delivers events.
testing::AssertionResult gets_event(Peer& peer, const std::string& side, const std::string& kind,
                                    const std::string& text = "");

}  // namespace sft::test
