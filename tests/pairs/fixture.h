// Hosts on a network, and checks of what has to be true of a publisher and a subscriber in the end.
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

/// The lease of nodes whose end has to be noticed soon. Other nodes have the default, 10 s.
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

/// Checks the condition only a hundred times a second, because each check sends a command to a peer.
template <class Condition>
bool comes_true(Condition condition, std::chrono::milliseconds within = hang_timeout) {
  return eventually(condition, within, 10ms);
}

/// Returns the publisher's entry of the subscriber; null if there is none.
json reader_of(Peer& publisher, const Peer& subscriber);
/// Returns the subscriber's entry of the publisher; null if there is none.
json writer_of(const Peer& publisher, Peer& subscriber);
/// Returns the subscriber's account of the samples that it has taken from this publisher.
json taken_of(const Peer& publisher, Peer& subscriber);

bool is_served(Peer& publisher, const Peer& subscriber);
bool is_served_by(Peer& publisher, const Peer& subscriber, const std::string& transport);
bool is_served_with(Peer& publisher, const Peer& subscriber, const std::string& mask);

/// Waits until both peers report the same path, mask and request of each other.
testing::AssertionResult agree(Peer& publisher, Peer& subscriber);

/// Lets the publisher publish until its newest sample has come. Succeeds if every sample since the first
/// that came is counted as received, lost, withheld or expired, and if the received ones are right and in
/// order.
testing::AssertionResult accounts_for_all(Peer& publisher, Peer& subscriber);

/// Returns true if an event of that kind came whose text contains `text`.
bool was_told(const json& events, const std::string& kind, const std::string& text = "");
/// Waits until the peer has got such an event. `side` is "offered" or "requested". Events come later than
/// the changes that they report, because a separate thread delivers them.
testing::AssertionResult gets_event(Peer& peer, const std::string& side, const std::string& kind,
                                    const std::string& text = "");

}  // namespace sft::test
