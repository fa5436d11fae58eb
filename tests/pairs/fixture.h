// Hosts on a network, peers on hosts, and what has to be true of a publisher and a subscriber in the end.
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

/// The lease of a node whose end is to be noticed soon. Others have the default, which is 10 s.
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

/// Looks a hundred times a second, since each look asks a peer.
template <class Condition>
bool comes_true(Condition condition, std::chrono::milliseconds within = hang_timeout) {
  return eventually(condition, within, 10ms);
}

/// The publisher's entry of the subscriber; null if there is none.
json reader_of(Peer& publisher, const Peer& subscriber);
/// The subscriber's entry of the publisher, likewise.
json writer_of(const Peer& publisher, Peer& subscriber);
/// Returns what the subscriber has taken of this publisher.
json taken_of(const Peer& publisher, Peer& subscriber);

bool is_served(Peer& publisher, const Peer& subscriber);
bool is_served_by(Peer& publisher, const Peer& subscriber, const std::string& transport);
bool is_served_with(Peer& publisher, const Peer& subscriber, const std::string& mask);

/// Waits until both tell the same of each other: path, mask, request.
testing::AssertionResult agree(Peer& publisher, Peer& subscriber);

/// Lets the publisher publish until the newest has come. Whether then everything that it published since the
/// first that came was received, lost or withheld, and what was received was right and in order.
testing::AssertionResult accounts_for_all(Peer& publisher, Peer& subscriber);

/// Returns true if an event of that kind came, and its text contains that text.
bool was_told(const json& events, const std::string& kind, const std::string& text = "");
/// Waits until the peer has got such an event. `side` is "offered" or "requested". Events come on a thread of
/// their own, and so later than the changes that they report.
testing::AssertionResult gets_event(Peer& peer, const std::string& side, const std::string& kind,
                                    const std::string& text = "");

}  // namespace sft::test
